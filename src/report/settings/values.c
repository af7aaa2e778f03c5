/* SPDX-License-Identifier: Apache-2.0 */
/* Reads the values of settings. */
#include "src/report/settings/values.h"

#include <ctype.h>
#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "src/base/letter_case.h"

static const struct choice *find_choice(const struct choice *choices, const char *name)
{
    for (const struct choice *choice = choices; choice->name; choice++)
        if (text_equals_in_any_case(choice->name, name))
            return choice;
    return NULL;
}

char *value_next_entry(char **list)
{
    while (*list) {
        char *entry = *list, *comma = strchr(entry, ',');
        *list = comma ? comma + 1 : NULL;
        if (comma)
            *comma = '\0';
        while (isspace((unsigned char)*entry))
            entry++;
        size_t length = strlen(entry);
        while (length && isspace((unsigned char)entry[length - 1]))
            entry[--length] = '\0';
        if (length)
            return entry;
    }
    return NULL;
}

bool value_read_choice(const struct choice *choices, char *list, uint32_t *value)
{
    const char *name = value_next_entry(&list);
    const struct choice *choice = name ? find_choice(choices, name) : NULL;
    if (!choice || value_next_entry(&list))
        return false;
    *value = choice->value;
    return true;
}

bool value_read_flags(const struct choice *choices, char *list, uint32_t *flags)
{
    uint32_t all = 0;
    const char *name = value_next_entry(&list);
    if (!name)
        return false;
    for (; name; name = value_next_entry(&list)) {
        const struct choice *choice = find_choice(choices, name);
        if (!choice)
            return false;
        all |= choice->value;
    }
    *flags = all;
    return true;
}

bool value_read_number(char *list, uint32_t *value)
{
    const char *digits = value_next_entry(&list);
    if (!digits || !isdigit((unsigned char)digits[0]) || value_next_entry(&list))
        return false;
    char *end;
    errno = 0;
    unsigned long long number = strtoull(digits, &end, 10);
    if (*end || errno || number > UINT32_MAX)
        return false;
    *value = (uint32_t)number;
    return true;
}
