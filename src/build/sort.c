/* SPDX-License-Identifier: Apache-2.0 */
/* Sorting by 32-bit keys, stable: radix for many, insertion for few. */
#include "build/tree.h"

#define DIGIT_BITS 8
#define DIGITS (1u << DIGIT_BITS)
#define INSERTION_LIMIT 48u

static void insertion_sort(struct sort_pair *pairs, uint32_t count)
{
    for (uint32_t i = 1; i < count; i++) {
        struct sort_pair pair = pairs[i];
        uint32_t j = i;
        for (; j > 0 && pairs[j - 1].key > pair.key; j--)
            pairs[j] = pairs[j - 1];
        pairs[j] = pair;
    }
}

/* From the lowest digit up, between the two arrays; an even number of digits ends where it began.
 * Digits that all keys share are skipped. */
static void radix_sort(struct sort_pair *pairs, struct sort_pair *spare, uint32_t count)
{
    uint32_t tallies[32 / DIGIT_BITS][DIGITS] = {{0}};
    for (uint32_t i = 0; i < count; i++)
        for (int digit = 0; digit < 32 / DIGIT_BITS; digit++)
            tallies[digit][pairs[i].key >> digit * DIGIT_BITS & (DIGITS - 1)]++;
    struct sort_pair *from = pairs, *to = spare;
    for (int digit = 0; digit < 32 / DIGIT_BITS; digit++) {
        uint32_t *tally = tallies[digit], start = 0;
        int shift = digit * DIGIT_BITS;
        if (tally[from[0].key >> shift & (DIGITS - 1)] == count)
            continue;
        for (uint32_t value = 0; value < DIGITS; value++) {
            uint32_t next = start + tally[value];
            tally[value] = start;
            start = next;
        }
        for (uint32_t i = 0; i < count; i++)
            to[tally[from[i].key >> shift & (DIGITS - 1)]++] = from[i];
        struct sort_pair *swap = from;
        from = to;
        to = swap;
    }
    if (from != pairs)
        memcpy(pairs, from, count * sizeof(*pairs));
}

void sort_pairs(struct sort_pair *pairs, struct sort_pair *spare, uint32_t count)
{
    if (count <= INSERTION_LIMIT)
        insertion_sort(pairs, count);
    else
        radix_sort(pairs, spare, count);
}
