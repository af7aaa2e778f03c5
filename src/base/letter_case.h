/* SPDX-License-Identifier: Apache-2.0 */
/* Comparisons that ignore the case of the letters A to Z, in any locale. */
#ifndef ASSAY_BASE_LETTER_CASE_H
#define ASSAY_BASE_LETTER_CASE_H

#include <stdbool.h>

static inline char letter_lower(char letter)
{
    return letter >= 'A' && letter <= 'Z' ? (char)(letter - 'A' + 'a') : letter;
}

static inline bool text_starts_in_any_case(const char *text, const char *start)
{
    while (*start && letter_lower(*text) == letter_lower(*start)) {
        text++;
        start++;
    }
    return !*start;
}

static inline bool text_equals_in_any_case(const char *a, const char *b)
{
    while (*a && letter_lower(*a) == letter_lower(*b)) {
        a++;
        b++;
    }
    return !*a && !*b;
}

#endif
