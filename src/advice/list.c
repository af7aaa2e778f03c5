/* SPDX-License-Identifier: Apache-2.0 */
#include "src/advice/list.h"

#include <stdlib.h>
#include <string.h>

#include "src/platform/threads.h"
#include "src/report/reporter.h"

struct advice_line {
    uint64_t weight;
    struct advice_report report;
};

/* The lines of one id. */
struct advice_lines {
    struct advice_line *items; /* the heaviest first; NULL: none yet, or no memory */
    uint32_t used;             /* at most `lines` of the list */
    uint32_t count;            /* of all that were added since the list was sent */
    uint32_t sent;             /* lines that were sent before the end */
};

struct advice_list {
    pthread_mutex_t lock; /* guards what follows */
    uint32_t lines;       /* constant */
    struct advice_lines of[ADVICE_COUNT];
};

struct advice_list *advice_list_create(uint32_t lines)
{
    struct advice_list *list = calloc(1, sizeof(*list));
    if (!list)
        return NULL;
    pthread_mutex_init(&list->lock, NULL);
    list->lines = lines;
    return list;
}

void advice_list_destroy(struct advice_list *list)
{
    if (!list)
        return;
    for (enum advice advice = 0; advice < ADVICE_COUNT; advice++)
        free(list->of[advice].items);
    pthread_mutex_destroy(&list->lock);
    free(list);
}

static bool has_items(struct advice_lines *lines, uint32_t most)
{
    if (!lines->items && most)
        lines->items = malloc(most * sizeof(*lines->items));
    return lines->items;
}

/* Equal weights stay in the order in which they came. */
static void insert_line(struct advice_lines *lines, uint32_t most,
                        const struct advice_report *report, uint64_t weight)
{
    uint32_t at = lines->used;
    while (at > 0 && lines->items[at - 1].weight < weight)
        at--;
    if (at == most)
        return;
    lines->used += lines->used < most;
    memmove(&lines->items[at + 1], &lines->items[at],
            (lines->used - 1 - at) * sizeof(*lines->items));
    lines->items[at].weight = weight;
    lines->items[at].report = *report;
}

void advice_list_add(struct advice_list *list, const struct advice_report *report, uint64_t weight)
{
    struct advice_lines *lines = &list->of[report->advice];
    pthread_mutex_lock(&list->lock);
    lines->count++;
    if (has_items(lines, list->lines))
        insert_line(lines, list->lines, report, weight);
    pthread_mutex_unlock(&list->lock);
}

/* Removes the lines. */
static struct advice_lines take_lines(struct advice_list *list, enum advice advice)
{
    struct advice_lines *of = &list->of[advice];
    pthread_mutex_lock(&list->lock);
    const struct advice_lines lines = *of;
    *of = (struct advice_lines){.sent = lines.sent + lines.used};
    pthread_mutex_unlock(&list->lock);
    return lines;
}

static void send_lines(struct advice_list *list, enum advice advice, struct reporter *reporter,
                       VkDevice device)
{
    const struct advice_lines lines = take_lines(list, advice);
    for (uint32_t i = 0; i < lines.used; i++) {
        const bool is_last = i + 1 == lines.used;
        lines.items[i].report.more = is_last ? lines.count - lines.used : 0;
        reporter_send_advice(reporter, &lines.items[i].report, device);
    }
    free(lines.items);
}

static bool is_sent_now(struct advice_list *list, enum advice advice)
{
    const struct advice_lines *lines = &list->of[advice];
    pthread_mutex_lock(&list->lock);
    const bool is_now = advice_infos[advice].is_certain && lines->used && lines->sent < list->lines;
    pthread_mutex_unlock(&list->lock);
    return is_now;
}

void advice_list_send_certain(struct advice_list *list, struct reporter *reporter, VkDevice device)
{
    for (enum advice advice = 0; advice < ADVICE_COUNT; advice++)
        if (is_sent_now(list, advice))
            send_lines(list, advice, reporter, device);
}

void advice_list_send(struct advice_list *list, struct reporter *reporter, VkDevice device)
{
    for (enum advice advice = 0; advice < ADVICE_COUNT; advice++)
        send_lines(list, advice, reporter, device);
}
