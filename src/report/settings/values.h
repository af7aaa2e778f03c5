/* SPDX-License-Identifier: Apache-2.0 */
/* Values of settings, as text: comma-separated lists with blanks around the entries. */
#ifndef ASSAY_REPORT_SETTINGS_VALUES_H
#define ASSAY_REPORT_SETTINGS_VALUES_H

#include <stdbool.h>
#include <stdint.h>

/* One word that a setting accepts, in any case. An array of choices ends with a NULL name. */
struct choice {
    const char *name;
    uint32_t value;
};

/* Cuts the next entry off a list, and trims it. Returns NULL at the end. */
char *value_next_entry(char **list);

/* These change the list. Each returns false, and leaves the value as it was, if the list is no
 * value of its kind: exactly one choice; one choice or several, whose values are combined; exactly
 * one number. */
bool value_read_choice(const struct choice *choices, char *list, uint32_t *value);
bool value_read_flags(const struct choice *choices, char *list, uint32_t *flags);
bool value_read_number(char *list, uint32_t *value);

#endif
