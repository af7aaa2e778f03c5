/* SPDX-License-Identifier: Apache-2.0 */
/* Scans of whole arrays of indices and positions. */
#ifndef ASSAY_BVH_INPUT_INDICES_H
#define ASSAY_BVH_INPUT_INDICES_H

#include <stdbool.h>
#include <stdint.h>

/* The largest of `count` indices of `size` bytes each (1, 2 or 4), at any address; 0 if there are
 * none. */
uint32_t indices_max(const uint8_t *indices, uint32_t size, uint64_t count);

/* Whether any of `count` positions, three floats each, has an element that is NaN. `stride` is in
 * bytes; addresses need no alignment. */
bool positions_have_nan(const uint8_t *positions, uint64_t stride, uint64_t count);

#endif
