/* SPDX-License-Identifier: Apache-2.0 */
/* Sorts ranges by their first byte. */
#ifndef ASSAY_CHECK_OVERLAP_SORT_H
#define ASSAY_CHECK_OVERLAP_SORT_H

#include "src/view/view.h"

/* The first byte of a range, and the index of the range. */
struct range_key {
    uint64_t memory, begin;
    uint32_t index;
};

/* Returns a value below, equal to or above 0 if `a` begins before, with or after `b`. Ranges of
 * different memory are ordered by the memory's handle. */
int range_compare(const struct used_range *a, const struct used_range *b);

/* Writes the indices of the ranges to `order`, sorted by first byte; the sort is stable. `keys` has
 * room for 2 * count keys. */
void range_order(const struct used_range *ranges, uint32_t count, uint32_t *order,
                 struct range_key *keys);

#endif
