/* SPDX-License-Identifier: Apache-2.0 */
/* The order of ranges by where they begin. */
#ifndef ASSAY_CHECK_OVERLAP_SORT_H
#define ASSAY_CHECK_OVERLAP_SORT_H

#include "src/view/view.h"

/* Where a range begins, and which one it is. */
struct range_key {
    uint64_t memory, begin;
    uint32_t index;
};

/* Below, at, or above 0: where `a` begins before, with, or behind `b`. Ranges of different memory
 * are in the order of its handles. */
int range_compare(const struct used_range *a, const struct used_range *b);

/* Writes the indices of ranges to `order`, by where the ranges begin; equal ones stay as they were.
 * `keys` has room for twice as many. */
void range_order(const struct used_range *ranges, uint32_t count, uint32_t *order,
                 struct range_key *keys);

#endif
