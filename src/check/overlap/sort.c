/* SPDX-License-Identifier: Apache-2.0 */
/* Sorts few ranges by insertion, many by radix, one byte of the keys at a time. Bytes that are
 * equal in all keys, as most bytes of handles and offsets are, cost no pass. */
#include "src/check/overlap/sort.h"

#include <string.h>

enum { FEW = 16, DIGIT_BITS = 8, DIGITS = 1 << DIGIT_BITS };

static int compare_numbers(uint64_t a, uint64_t b)
{
    return (a > b) - (a < b);
}

static uint64_t memory_number(const struct used_range *range)
{
    return (uint64_t)(uintptr_t)range->span.memory;
}

int range_compare(const struct used_range *a, const struct used_range *b)
{
    int order = compare_numbers(memory_number(a), memory_number(b));
    return order ? order : compare_numbers(a->span.begin, b->span.begin);
}

static void insert_all(const struct used_range *ranges, uint32_t count, uint32_t *order)
{
    for (uint32_t i = 0; i < count; i++) {
        uint32_t at = i;
        for (; at && range_compare(&ranges[order[at - 1]], &ranges[i]) > 0; at--)
            order[at] = order[at - 1];
        order[at] = i;
    }
}

static uint64_t number_at(const struct range_key *key, size_t member)
{
    uint64_t number;
    memcpy(&number, (const char *)key + member, sizeof(number));
    return number;
}

/* One stable pass: copies `from` to `to`, sorted by one digit. */
static void sort_pass(const struct range_key *from, struct range_key *to, uint32_t count,
                      size_t member, int shift)
{
    uint32_t next[DIGITS] = {0}, sum = 0;
    for (uint32_t i = 0; i < count; i++)
        next[number_at(&from[i], member) >> shift & (DIGITS - 1)]++;
    for (int digit = 0; digit < DIGITS; digit++) {
        uint32_t before = sum;
        sum += next[digit];
        next[digit] = before;
    }
    for (uint32_t i = 0; i < count; i++)
        to[next[number_at(&from[i], member) >> shift & (DIGITS - 1)]++] = from[i];
}

/* Sorts by one member. May swap the two arrays: `*keys` is the sorted one. */
static void sort_by(struct range_key **keys, struct range_key **spare, uint32_t count,
                    size_t member)
{
    uint64_t varies = 0;
    for (uint32_t i = 1; i < count; i++)
        varies |= number_at(&(*keys)[i], member) ^ number_at(&(*keys)[0], member);
    while (varies) {
        int shift = __builtin_ctzll(varies);
        sort_pass(*keys, *spare, count, member, shift);
        struct range_key *sorted = *spare;
        *spare = *keys;
        *keys = sorted;
        varies &= ~((uint64_t)(DIGITS - 1) << shift);
    }
}

void range_order(const struct used_range *ranges, uint32_t count, uint32_t *order,
                 struct range_key *keys)
{
    if (count <= FEW) {
        insert_all(ranges, count, order);
        return;
    }
    struct range_key *spare = keys + count;
    for (uint32_t i = 0; i < count; i++)
        keys[i] = (struct range_key){
            .memory = memory_number(&ranges[i]), .begin = ranges[i].span.begin, .index = i};
    sort_by(&keys, &spare, count, offsetof(struct range_key, begin));
    sort_by(&keys, &spare, count, offsetof(struct range_key, memory));
    for (uint32_t i = 0; i < count; i++)
        order[i] = keys[i].index;
}
