/* SPDX-License-Identifier: Apache-2.0 */
/* Stable sorting by 32-bit keys: radix sort for long arrays, insertion sort for short ones. */
#include "src/bvh/tree/tree.h"

#define DIGIT_BITS 8 /* log2 of SORT_DIGITS */
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

/* Sorts from the lowest digit up, alternating between the two arrays; copies the result back if it
 * ends in `spare`. Skips digits that all keys share. */
static void radix_sort(struct sort_pair *pairs, struct sort_pair *spare, uint32_t count)
{
    uint32_t tallies[32 / DIGIT_BITS][SORT_DIGITS] = {{0}};
    for (uint32_t i = 0; i < count; i++)
        for (int digit = 0; digit < 32 / DIGIT_BITS; digit++)
            tallies[digit][pairs[i].key >> digit * DIGIT_BITS & (SORT_DIGITS - 1)]++;
    struct sort_pair *from = pairs, *to = spare;
    for (int digit = 0; digit < 32 / DIGIT_BITS; digit++) {
        uint32_t *tally = tallies[digit], start = 0;
        int shift = digit * DIGIT_BITS;
        if (tally[from[0].key >> shift & (SORT_DIGITS - 1)] == count)
            continue;
        for (uint32_t value = 0; value < SORT_DIGITS; value++) {
            uint32_t next = start + tally[value];
            tally[value] = start;
            start = next;
        }
        for (uint32_t i = 0; i < count; i++)
            to[tally[from[i].key >> shift & (SORT_DIGITS - 1)]++] = from[i];
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

/* One pass over a digit. Each piece of the input counts its values. A value of a piece goes after
 * all smaller values of all pieces, and after the same value of the preceding pieces. */
struct digit_pass {
    const struct sort_pair *from;
    struct sort_pair *to;
    /* SORT_DIGITS per piece: first counts, then the position of the next pair with that value. */
    uint32_t *tallies;
    uint32_t count, piece;
    int shift;
};

static uint32_t *tally_of(const struct digit_pass *pass, uint32_t begin)
{
    return pass->tallies + (uint64_t)(begin / pass->piece) * SORT_DIGITS;
}

static void tally_piece(void *context, uint32_t begin, uint32_t end)
{
    const struct digit_pass *pass = context;
    uint32_t *tally = tally_of(pass, begin);
    memset(tally, 0, SORT_DIGITS * sizeof(*tally));
    for (uint32_t i = begin; i < end; i++)
        tally[pass->from[i].key >> pass->shift & (SORT_DIGITS - 1)]++;
}

static void move_piece(void *context, uint32_t begin, uint32_t end)
{
    const struct digit_pass *pass = context;
    uint32_t *tally = tally_of(pass, begin);
    for (uint32_t i = begin; i < end; i++)
        pass->to[tally[pass->from[i].key >> pass->shift & (SORT_DIGITS - 1)]++] = pass->from[i];
}

static void place_pieces(const struct digit_pass *pass)
{
    uint32_t start = 0;
    for (uint32_t value = 0; value < SORT_DIGITS; value++)
        for (uint32_t begin = 0; begin < pass->count; begin += pass->piece) {
            uint32_t *tally = &tally_of(pass, begin)[value], next = start + *tally;
            *tally = start;
            start = next;
        }
}

void sort_pairs_shared(struct workers *workers, struct sort_pair *pairs, struct sort_pair *spare,
                       uint32_t count, uint32_t *tallies)
{
    struct digit_pass pass = {.from = pairs, .to = spare, .tallies = tallies, .count = count};
    pass.piece = (count + SORT_PIECES - 1) / SORT_PIECES;
    for (; pass.shift < 32; pass.shift += DIGIT_BITS) { /* an even number of passes */
        workers_each(workers, count, pass.piece, tally_piece, &pass);
        place_pieces(&pass);
        workers_each(workers, count, pass.piece, move_piece, &pass);
        struct sort_pair *sorted = pass.to;
        pass.to = pass.from == pairs ? pairs : spare;
        pass.from = sorted;
    }
}
