/* SPDX-License-Identifier: Apache-2.0 */
/* Matches filter entries with the ids of messages. */
#include "src/report/message_filter.h"

#include <errno.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "src/report/message_id.h"

struct pattern {
    const char *text;
    bool is_digits, is_number;
    int32_t number;
};

/* Some applications print message numbers signed, others in hexadecimal. */
static bool read_message_number(const char *text, int32_t *number)
{
    bool is_hex = strncasecmp(text, "0x", 2) == 0;
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
    if (strcasecmp(pattern->text, id) == 0)
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

bool message_filter_add_difference(bool muted[DIFFERENCE_COUNT], const char *entry)
{
    const struct pattern pattern = make_pattern(entry);
    bool found = false;
    for (enum difference difference = 0; difference < DIFFERENCE_COUNT; difference++)
        if (matches(&pattern, difference_id(difference)))
            muted[difference] = found = true;
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
