/* SPDX-License-Identifier: Apache-2.0 */
/* Matches patterns of names. */
#include "src/base/glob.h"

#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include "src/base/text_buffer.h"

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
