/* SPDX-License-Identifier: Apache-2.0 */
/* Matches filter entries, which may have wildcards, with the ids of messages. */
#include "src/report/ids/message_filter.h"

#include <errno.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include "src/base/letter_case.h"
#include "src/base/text_buffer.h"
#include "src/report/ids/message_id.h"
#include "src/report/settings/source.h"
#include "src/report/words.h"

static uint32_t next_character(const char **text)
{
    uint32_t character;
    size_t length = text_decode((const unsigned char *)*text, strlen(*text), &character);
    if (!length)
        character = (unsigned char)**text;
    *text += length ? length : 1;
    return character;
}

/* Returns the end of the set that begins at a bracket, or NULL if it does not end. */
static const char *find_set_end(const char *set)
{
    const char *at = set + 1;
    at += *at == '!';
    at += *at == ']'; /* a bracket in the first place is a member */
    return strchr(at, ']');
}

/* `set` begins behind the bracket. */
static bool is_in_set(const char *set, const char *end, uint32_t character)
{
    const bool is_excluding = *set == '!';
    bool is_member = false;
    set += is_excluding;
    while (set < end) {
        uint32_t first = next_character(&set), last = first;
        if (*set == '-' && set + 1 < end) {
            set++;
            last = next_character(&set);
        }
        is_member |= first <= character && character <= last;
    }
    return is_member != is_excluding;
}

/* Matches one character. Returns the rest of the pattern, or NULL. */
static const char *match_one(const char *glob, uint32_t character)
{
    const char *end = *glob == '[' ? find_set_end(glob) : NULL;
    if (end)
        return is_in_set(glob + 1, end, character) ? end + 1 : NULL;
    if (*glob == '?')
        return glob + 1;
    return *glob && next_character(&glob) == character ? glob : NULL;
}

bool glob_matches(const char *glob, const char *text)
{
    /* The pattern behind the last star, and the end of the text that this star covers so far. */
    const char *behind_star = NULL, *covered = NULL;
    for (;;) {
        if (*glob == '*') {
            behind_star = ++glob;
            covered = text;
            continue;
        }
        if (!*text) {
            if (!*glob)
                return true;
        } else {
            const char *after = text;
            const char *rest = match_one(glob, next_character(&after));
            if (rest) {
                glob = rest;
                text = after;
                continue;
            }
        }
        if (!behind_star || !*covered)
            return false;
        next_character(&covered);
        glob = behind_star;
        text = covered;
    }
}

/* ---- matches filter entries with the ids of messages */

enum { ENTRY_SHOWN = 200 };

struct pattern {
    const char *text;
    bool is_digits, is_number;
    int32_t number;
};

/* Some applications print message numbers signed, others in hexadecimal. */
static bool read_message_number(const char *text, int32_t *number)
{
    bool is_hex = text_starts_in_any_case(text, "0x");
    char *end;
    errno = 0;
    long long value = strtoll(text, &end, is_hex ? 16 : 10);
    if (end == text || *end || errno || value < INT32_MIN || value > UINT32_MAX)
        return false;
    *number = (int32_t)(uint32_t)value;
    return true;
}

static bool matches(const struct pattern *pattern, const char *id)
{
    if (text_equals_in_any_case(pattern->text, id))
        return true;
    const char *tail = strrchr(id, '-');
    if (pattern->is_digits && tail && strcmp(pattern->text, tail + 1) == 0)
        return true;
    return pattern->is_number && message_id_number(id) == pattern->number;
}

static struct pattern make_pattern(const char *entry)
{
    struct pattern pattern = {
        .text = entry,
        .is_digits = entry[0] && strspn(entry, "0123456789") == strlen(entry),
    };
    pattern.is_number = read_message_number(entry, &pattern.number);
    return pattern;
}

/* Does the same for other ids (message_id.h), which `entry` names by id or message number. */
static bool message_filter_add_other(bool muted[OTHER_ID_COUNT], const char *entry)
{
    const struct pattern pattern = make_pattern(entry);
    bool found = false;
    for (unsigned other = 0; other < OTHER_ID_COUNT; other++)
        if (matches(&pattern, other_id_name(other)))
            muted[other] = found = true;
    return found;
}

bool message_filter_add(bool muted[MESSAGE_ID_COUNT], const char *entry)
{
    const struct pattern pattern = make_pattern(entry);
    bool found = false;
    for (enum vuid vuid = VUID_NONE + 1; vuid < MESSAGE_ID_COUNT; vuid++) {
        if (vuid == VUID_COUNT)
            continue;
        bool match = matches(&pattern, vuid_texts[vuid].id);
        const char *retired;
        for (unsigned n = 0; !match && (retired = vuid_retired(vuid, n)); n++)
            match = matches(&pattern, retired);
        if (match)
            muted[vuid] = found = true;
    }
    return found;
}

/* ---- entries ID@GLOB, and lists of entries */

static bool add_narrow(struct narrow_filter **list, const char *id, const char *glob)
{
    size_t size = strlen(glob) + 1;
    struct narrow_filter *filter = calloc(1, sizeof(*filter) + size);
    if (!filter)
        return true;
    memcpy(filter->glob, glob, size);
    if (size == 1 ||
        !(message_filter_add(filter->vuids, id) || message_filter_add_other(filter->others, id))) {
        free(filter);
        return false;
    }
    filter->next = *list;
    *list = filter;
    return true;
}

/* May change the entry. */
static bool add_entry(const struct message_filters *filters, char *entry)
{
    char *at = strchr(entry, '@');
    if (!at)
        return message_filter_add(filters->vuids, entry) ||
               message_filter_add_other(filters->others, entry);
    *at = '\0';
    bool is_valid = add_narrow(filters->narrow, entry, at + 1);
    *at = '@';
    return is_valid;
}

static void warn_of_entry(const char *entry, struct kept_lines *warnings)
{
    kept_lines_say(
        warnings,
        "assay_validation.message_id_filter: {} names no message of this layer. An entry is a "
        "VUID, a message number (decimal or 0x...) or the last digits of a VUID, alone or "
        "followed by @ and a pattern of names of objects and labels. The entry is ignored.",
        quoted(entry, ENTRY_SHOWN));
}

void message_filters_load(const struct message_filters *filters, char *list,
                          struct kept_lines *warnings)
{
    for (char *entry; (entry = value_next_entry(&list));)
        if (!add_entry(filters, entry))
            warn_of_entry(entry, warnings);
}

void narrow_filters_free(struct narrow_filter *filters)
{
    for (struct narrow_filter *next; filters; filters = next) {
        next = filters->next;
        free(filters);
    }
}

static bool is_about(const struct narrow_filter *filter, uint32_t id)
{
    return id < MESSAGE_ID_COUNT ? filter->vuids[id] : filter->others[id - MESSAGE_ID_COUNT];
}

bool narrow_filters_have(const struct narrow_filter *filters, uint32_t id)
{
    for (; filters; filters = filters->next)
        if (is_about(filters, id))
            return true;
    return false;
}

/* A backslash stands for itself, as in baselines of assay-run. */
bool narrow_filters_match(const struct narrow_filter *filters, uint32_t id, const char *name)
{
    for (; name && filters; filters = filters->next)
        if (is_about(filters, id) && glob_matches(filters->glob, name))
            return true;
    return false;
}
