/* SPDX-License-Identifier: Apache-2.0 */
/* Whether indices of triangles are certainly those of another index type.
 *
 * Indices that are too narrow for their data: 0, 1, 2, 3 as 32 bits each, read with 16 bits, are
 * 0, 0, 1, 0, 2, 0, 3, 0, and every second triangle has an index twice. Indices that are too wide
 * join two: only a large maxVertex has room for them. */
#ifndef ASSAY_ADVICE_FIGURES_INDICES_H
#define ASSAY_ADVICE_FIGURES_INDICES_H

#include <stdbool.h>
#include <stdint.h>

/* What index data leads to if its indices have `size` bytes. */
struct other_indices {
    uint32_t size;
    uint64_t triangles; /* whole ones in these bytes */
    uint32_t max;       /* the largest index */
};

/* `count` indices of `size` bytes each (1, 2 or 4), the largest of which is `max`; it is below
 * `limit`. Returns whether another size suits them, and they make no sense as they are. Reads no
 * index of most meshes, and allocates nothing. */
bool indices_suit_another_size(const uint8_t *indices, uint32_t size, uint64_t count, uint32_t max,
                               uint64_t limit, struct other_indices *other);

/* Which vertices indices use. */
struct used_vertices {
    uint32_t smallest, largest;
    uint64_t count; /* of different ones */
};
/* There is at least one index. Returns false if there is no memory for a bit for each vertex. */
bool indices_find_used(const uint8_t *indices, uint32_t size, uint64_t count, uint32_t largest,
                       struct used_vertices *used);

#endif
