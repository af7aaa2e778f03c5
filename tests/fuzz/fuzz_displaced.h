/* SPDX-License-Identifier: Apache-2.0 */
/* Displacements of any kind, of the fuzz target's data. */
#ifndef FUZZ_DISPLACED_H
#define FUZZ_DISPLACED_H

#include "src/bvh/micromap.h"

struct span {
    const uint8_t *bytes;
    size_t size;
};

/* `flags` are random bits. */
struct builder_displacement fuzz_displacement(const struct span *data, VkIndexType index_type,
                                              uint32_t flags);

/* Mostly triangles that are within their data. */
void fuzz_make_likely(struct builder_triangles *triangles,
                      VkAccelerationStructureBuildRangeInfoKHR *range, uint32_t flags);

/* A resolver's; its context: a span. Micromap 1 alone is there, where there is enough data. */
const void *fuzz_find_displacing(void *context, uint64_t reference);

#endif
