/* SPDX-License-Identifier: Apache-2.0 */
/* Words the lines of report_flags = info. */
#include "src/report/summary.h"

#include <inttypes.h>
#include <string.h>

enum { REASON_SIZE = 512 };

/* ---- what was not validated */

void unchecked_init(struct unchecked_counts *unchecked)
{
    pthread_mutex_init(&unchecked->lock, NULL);
}

void unchecked_destroy(struct unchecked_counts *unchecked)
{
    pthread_mutex_destroy(&unchecked->lock);
}

void unchecked_add(struct unchecked_counts *unchecked, const char *what, uint32_t count)
{
    unsigned i = 0;
    pthread_mutex_lock(&unchecked->lock);
    while (i < unchecked->used && strcmp(unchecked->items[i].what, what) != 0)
        i++;
    if (i < UNCHECKED_MAX) {
        unchecked->items[i].what = what;
        unchecked->items[i].count += count;
        unchecked->used += i == unchecked->used;
    }
    pthread_mutex_unlock(&unchecked->lock);
}

/* ---- the start */

void summary_append_start(struct text_buffer *text, const char *version,
                          const struct settings *settings)
{
    text_append(text, "Assay %s validates acceleration-structure builds: level = %s, backend = %s.",
                version, level_name(settings->level),
                settings->backend == BACKEND_CPU ? "cpu" : "driver");
    if (settings->changes)
        text_append(text, " Settings that differ from the defaults: %s.", settings->changes);
}

/* ---- the end */

static uint64_t count_findings(const struct duplicates *duplicates)
{
    uint64_t count = 0;
    for (uint32_t id = 0; id < REPORTED_IDS; id++)
        count += atomic_load(&duplicates->ids[id].found);
    return count;
}

static void append_findings(struct text_buffer *text, const struct duplicates *duplicates)
{
    const char *separator = ":";
    for (uint32_t id = 0; id < REPORTED_IDS; id++) {
        uint64_t found = atomic_load(&duplicates->ids[id].found);
        uint64_t held = atomic_load(&duplicates->ids[id].held);
        if (!found)
            continue;
        text_append(text, "%s %s ", separator, reported_id_name(id));
        text_append_count(text, found, "time");
        if (held)
            text_append(text, " (%" PRIu64 " held back by duplicate_message_limit)", held);
        separator = ",";
    }
}

/* Counts the VUIDs that only rules of higher levels decide. */
static uint32_t count_above(enum level level)
{
    bool is_within[VUID_COUNT] = {false}, is_above[VUID_COUNT] = {false};
    uint32_t count = 0;
    for (int rule = 0; rule < RULE_COUNT; rule++)
        for (int command = 0; rule_infos[rule].subject && command < COMMAND_COUNT; command++) {
            enum vuid vuid = rule_infos[rule].vuid[command];
            if (vuid != VUID_NONE && vuid < VUID_COUNT)
                (rule_infos[rule].level <= level ? is_within : is_above)[vuid] = true;
        }
    for (int vuid = 0; vuid < VUID_COUNT; vuid++)
        count += is_above[vuid] && !is_within[vuid];
    return count;
}

static uint32_t count_muted(const struct settings *settings)
{
    uint32_t count = 0;
    for (int id = 0; id < MESSAGE_ID_COUNT; id++)
        count += settings->muted[id];
    return count;
}

/* What report_flags leaves out; nothing if it has errors and warnings. */
static void append_left_out(struct text_buffer *text, const struct settings *settings)
{
    uint32_t shown = settings->report_flags & (REPORT_ERROR | REPORT_WARNING);
    if (shown == (REPORT_ERROR | REPORT_WARNING))
        return;
    text_append(text, "%s, which report_flags leaves out",
                !shown                  ? "errors and warnings"
                : shown == REPORT_ERROR ? "warnings"
                                        : "errors");
}

static void append_counted(struct text_buffer *text, unsigned i, struct unchecked_counts *unchecked)
{
    pthread_mutex_lock(&unchecked->lock);
    if (i < unchecked->used)
        text_append(text, "%s (%" PRIu64 ")", unchecked->items[i].what, unchecked->items[i].count);
    pthread_mutex_unlock(&unchecked->lock);
}

void summary_append_reason(struct text_buffer *text, unsigned n, const struct settings *settings,
                           struct unchecked_counts *unchecked)
{
    uint32_t count;
    switch (n) {
    case 0:
        append_left_out(text, settings);
        return;
    case 1:
        if (!(count = count_above(settings->level)))
            return;
        text_append_count(text, count, "VUID");
        text_append(text, " of higher levels (level = %s)", level_name(settings->level));
        return;
    case 2:
        if (!(count = count_muted(settings)))
            return;
        text_append_count(text, count, "VUID");
        text_append(text, " that message_id_filter names");
        return;
    default:
        append_counted(text, n - (SUMMARY_REASONS - UNCHECKED_MAX), unchecked);
    }
}

static void append_unchecked(struct text_buffer *text, const struct settings *settings,
                             struct unchecked_counts *unchecked)
{
    const char *separator = " Not checked: ";
    for (unsigned n = 0; n < SUMMARY_REASONS; n++) {
        char line[REASON_SIZE];
        struct text_buffer reason;
        text_begin(&reason, line, sizeof(line));
        summary_append_reason(&reason, n, settings, unchecked);
        if (!reason.length)
            continue;
        text_append(text, "%s%s", separator, line);
        separator = "; ";
    }
    if (separator[0] == ';')
        text_append(text, ".");
}

void summary_append_end(struct text_buffer *text, const struct settings *settings,
                        const struct duplicates *duplicates, struct unchecked_counts *unchecked)
{
    uint64_t count = count_findings(duplicates);
    if (!(settings->report_flags & (REPORT_ERROR | REPORT_WARNING))) {
        text_append(text,
                    "Assay reported no violations, because report_flags leaves out errors "
                    "and warnings.");
        return;
    }
    text_append(text, "Assay found ");
    if (count)
        text_append_count(text, count, "violation");
    else
        text_append(text, "no violations");
    text_append(text, " in this instance");
    append_findings(text, duplicates);
    text_append(text, ".");
    append_unchecked(text, settings, unchecked);
}
