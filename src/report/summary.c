/* SPDX-License-Identifier: Apache-2.0 */
/* Counts findings by id and object, and words the lines of report_flags = info. */
#include "src/report/summary.h"
#include "src/report/words.h"

#include <inttypes.h>
#include <string.h>
#define XXH_INLINE_ALL
#include <xxhash.h>

#include "src/base/unknown.h"

static const uint32_t NO_LIMIT = UINT32_MAX;

enum {
    OBJECTS_PER_ID = 10,     /* the limit of an id is this many times that of an object */
    HELD_IN_A_ROW_MAX = 1000 /* see duplicates_wanted() */
};

enum { FIRST_RETIRED = MESSAGE_ID_COUNT + OTHER_ID_COUNT };

uint32_t reported_vuid(enum vuid vuid, const struct message_style *style,
                       const struct location *location, const struct finding *finding)
{
    const char *retired = NULL;
    if (style->vuid_names == VUID_NAMES_LISTED)
        retired = vuid_listed(vuid, location->command, finding->field ? finding->field : "");
    for (unsigned row = 0; retired && row < RETIRED_COUNT; row++)
        if (strcmp(vuid_of_retired_row(row), retired) == 0)
            return FIRST_RETIRED + row;
    return vuid;
}

const char *reported_id_name(uint32_t id)
{
    if (id >= FIRST_RETIRED)
        return vuid_of_retired_row(id - FIRST_RETIRED);
    return id < MESSAGE_ID_COUNT ? vuid_texts[id].id : other_id_name(id - MESSAGE_ID_COUNT);
}

static bool id_is_enabled(const struct settings *settings, uint32_t id)
{
    bool is_vuid = id < MESSAGE_ID_COUNT;
    bool is_error =
        is_vuid ? !vuid_is_warning((enum vuid)id) : other_id_is_error(id - MESSAGE_ID_COUNT);
    uint32_t severities = is_error ? REPORT_ERROR : REPORT_WARNING;
    if (!is_vuid && other_id_is_waste(id - MESSAGE_ID_COUNT))
        severities |= REPORT_PERFORMANCE;
    bool is_muted = is_vuid ? settings->muted[id] : settings->muted_others[id - MESSAGE_ID_COUNT];
    return id != VUID_NONE && !is_muted && settings->report_flags & severities &&
           !(settings->debug_action & DEBUG_ACTION_IGNORE);
}

void duplicates_init(struct duplicates *duplicates)
{
    pthread_mutex_init(&duplicates->lock, NULL);
}

void duplicates_enable(struct duplicates *duplicates, const struct settings *settings)
{
    uint64_t limit_of_id = (uint64_t)settings->duplicate_message_limit * OBJECTS_PER_ID;
    uint32_t left = !limit_of_id || limit_of_id > NO_LIMIT ? NO_LIMIT : (uint32_t)limit_of_id;
    duplicates->limit = settings->duplicate_message_limit;
    duplicates->counts_all =
        settings->report_flags & REPORT_INFO || settings->log_format == LOG_FORMAT_JSON;
    for (uint32_t id = 0; id < FIRST_RETIRED; id++) {
        duplicates->ids[id].is_enabled = id_is_enabled(settings, id);
        atomic_init(&duplicates->ids[id].left, duplicates->ids[id].is_enabled ? left : 0);
    }
}

void duplicates_destroy(struct duplicates *duplicates)
{
    handle_table_release(&duplicates->objects);
    pthread_mutex_destroy(&duplicates->lock);
}

bool duplicates_wanted(const struct duplicates *duplicates, uint32_t id)
{
    const struct reported_id *counts = &duplicates->ids[id];
    if (!counts->is_enabled || duplicates->counts_all)
        return counts->is_enabled;
    uint32_t held = atomic_load_explicit(&counts->held_in_a_row, memory_order_relaxed);
    return atomic_load_explicit(&counts->left, memory_order_relaxed) != 0 &&
           (held == 0 || held % HELD_IN_A_ROW_MAX != 0);
}

/* Handles of two devices may be equal. 0 is not a key of the table. */
static uint64_t key_of(uint32_t id, VkDevice device, const struct message_subject *subject)
{
    const uint64_t key[] = {id, handle_number(device), subject->type, subject->handle};
    uint64_t hash = XXH64(key, sizeof(key), 0);
    return hash ? hash : 1;
}

/* Returns the number of findings of this key, including this one. */
static uint32_t count_object(struct duplicates *duplicates, uint64_t key)
{
    pthread_mutex_lock(&duplicates->lock);
    uintptr_t count = (uintptr_t)handle_table_find(&duplicates->objects, key) + 1;
    if (count <= duplicates->limit) /* the number beyond the limit does not matter */
        handle_table_set(&duplicates->objects, key, (void *)count);
    pthread_mutex_unlock(&duplicates->lock);
    return (uint32_t)count;
}

bool duplicates_take(_Atomic uint32_t *messages, uint32_t *left)
{
    *left = atomic_load_explicit(messages, memory_order_relaxed);
    do {
        if (*left == 0)
            return false;
        if (*left == NO_LIMIT)
            return true;
    } while (!atomic_compare_exchange_weak_explicit(messages, left, *left - 1, memory_order_relaxed,
                                                    memory_order_relaxed));
    --*left;
    return true;
}

static bool is_allowed(struct duplicates *duplicates, uint32_t id, VkDevice device,
                       const struct message_subject *subject, struct message_style *style)
{
    struct reported_id *counts = &duplicates->ids[id];
    uint32_t of_object = 0;
    style->last = LAST_OF_NOTHING;
    if (atomic_load_explicit(&counts->left, memory_order_relaxed) == 0)
        return false;
    if (duplicates->limit)
        of_object = count_object(duplicates, key_of(id, device, subject));
    if (of_object > duplicates->limit || !duplicates_take(&counts->left, &style->left))
        return false;
    if (style->left == 0) {
        style->last = LAST_OF_ID;
        style->sent = duplicates->limit * OBJECTS_PER_ID;
    } else if (duplicates->limit && of_object == duplicates->limit) {
        style->last = LAST_OF_OBJECT;
        style->sent = of_object;
    }
    style->are_counted = duplicates->counts_all;
    return true;
}

bool duplicates_add(struct duplicates *duplicates, uint32_t id, uint32_t shown, VkDevice device,
                    const struct message_subject *subject, struct message_style *style)
{
    struct reported_id *counts = &duplicates->ids[id];
    if (!counts->is_enabled)
        return false;
    bool is_sent = is_allowed(duplicates, id, device, subject, style);
    atomic_fetch_add_explicit(&duplicates->ids[shown].found, 1, memory_order_relaxed);
    if (is_sent) {
        atomic_store_explicit(&counts->held_in_a_row, 0, memory_order_relaxed);
    } else {
        atomic_fetch_add_explicit(&counts->held_in_a_row, 1, memory_order_relaxed);
        atomic_fetch_add_explicit(&duplicates->ids[shown].held, 1, memory_order_relaxed);
    }
    return is_sent;
}

void duplicates_hold(struct duplicates *duplicates, uint32_t id, uint32_t count)
{
    if (!duplicates->ids[id].is_enabled)
        return;
    atomic_fetch_add_explicit(&duplicates->ids[id].found, count, memory_order_relaxed);
    atomic_fetch_add_explicit(&duplicates->ids[id].held, count, memory_order_relaxed);
}

/* ---- words the lines of report_flags = info */

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

void unchecked_add_unknown(struct unchecked_counts *unchecked)
{
    for (enum unknown_what what = 0; what < UNKNOWN_WHATS; what++) {
        const uint32_t count = unknown_take_count(what);
        if (count)
            unchecked_add(unchecked, unknown_text(what), count);
    }
}

/* ---- the start */

void summary_append_start(struct text_buffer *text, const char *version,
                          const struct settings *settings)
{
    text_say(text, "Assay {} validates acceleration-structure builds: level = {}, backend = {}.",
             phrase(version), phrase(level_name(settings->level)),
             phrase(settings->backend == BACKEND_CPU ? "cpu" : "driver"));
    if (settings->changes)
        text_say(text, " Settings that differ from the defaults: {}.", phrase(settings->changes));
}

/* ---- the end */

static bool is_advice(uint32_t id)
{
    return id >= reported_other(OTHER_ID_ADVICE) && id < FIRST_RETIRED;
}

static uint64_t count_findings(const struct duplicates *duplicates, bool of_advice)
{
    uint64_t count = 0;
    for (uint32_t id = 0; id < REPORTED_IDS; id++)
        if (is_advice(id) == of_advice)
            count += atomic_load(&duplicates->ids[id].found);
    return count;
}

static void append_findings(struct text_buffer *text, const struct duplicates *duplicates,
                            bool of_advice)
{
    const char *separator = ":";
    for (uint32_t id = 0; id < REPORTED_IDS; id++) {
        uint64_t found = atomic_load(&duplicates->ids[id].found);
        uint64_t held = atomic_load(&duplicates->ids[id].held);
        if (!found || is_advice(id) != of_advice)
            continue;
        text_say(text, "{} {} {}", phrase(separator), phrase(reported_id_name(id)),
                 count_of(found, "time"));
        if (held)
            text_say(text, " ({} held back by duplicate_message_limit)", number(held));
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
    text_append(text, !shown                  ? "errors and warnings"
                      : shown == REPORT_ERROR ? "warnings"
                                              : "errors");
    text_append(text, ", which report_flags leaves out");
}

static void append_counted(struct text_buffer *text, unsigned i, struct unchecked_counts *unchecked)
{
    pthread_mutex_lock(&unchecked->lock);
    if (i < unchecked->used)
        text_say(text, "{} ({})", phrase(unchecked->items[i].what),
                 number(unchecked->items[i].count));
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
        if ((count = count_above(settings->level)))
            text_say(text, "{} of higher levels (level = {})", count_of(count, "VUID"),
                     phrase(level_name(settings->level)));
        return;
    case 2:
        if ((count = count_muted(settings)))
            text_say(text, "{} that message_id_filter names", count_of(count, "VUID"));
        return;
    default:
        append_counted(text, n - (SUMMARY_REASONS - UNCHECKED_MAX), unchecked);
    }
}

static void append_advice(struct text_buffer *text, const struct duplicates *duplicates)
{
    const uint64_t count = count_findings(duplicates, true);
    if (!count)
        return;
    text_say(text, " It gave {} of advice", count_of(count, "piece"));
    append_findings(text, duplicates, true);
    text_append(text, ".");
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
        text_say(text, "{}{}", phrase(separator), phrase(line));
        separator = "; ";
    }
    if (separator[0] == ';')
        text_append(text, ".");
}

void summary_append_end(struct text_buffer *text, const struct settings *settings,
                        const struct duplicates *duplicates, struct unchecked_counts *unchecked)
{
    uint64_t count = count_findings(duplicates, false);
    if (!(settings->report_flags & (REPORT_ERROR | REPORT_WARNING))) {
        text_append(text,
                    "Assay reported no violations, because report_flags leaves out errors "
                    "and warnings.");
        append_advice(text, duplicates);
        return;
    }
    text_append(text, "Assay found ");
    if (count)
        text_append_count(text, count, "violation");
    else
        text_append(text, "no violations");
    text_append(text, " in this instance");
    append_findings(text, duplicates, false);
    text_append(text, ".");
    append_advice(text, duplicates);
    append_unchecked(text, settings, unchecked);
}
