/* SPDX-License-Identifier: Apache-2.0 */
/* The builder's functions for the bytes of a tree, which are those of an acceleration structure or
 * of a micromap. */
#ifndef ASSAY_CPU_TREES_BYTES_H
#define ASSAY_CPU_TREES_BYTES_H

#include "src/bvh/micromap.h"

static inline uint64_t bytes_size(const void *bytes)
{
    return micromap_is(bytes) ? micromap_size(bytes) : builder_size(bytes);
}

static inline uint64_t bytes_compacted_size(const void *bytes)
{
    return micromap_is(bytes) ? micromap_compacted_size(bytes) : builder_compacted_size(bytes);
}

static inline enum builder_result bytes_clone(const void *bytes, void *target, uint64_t size)
{
    return micromap_is(bytes) ? micromap_clone(bytes, target, size)
                              : builder_clone(bytes, target, size);
}

static inline enum builder_result bytes_compact(const void *bytes, void *target, uint64_t size)
{
    return micromap_is(bytes) ? micromap_compact(bytes, target, size)
                              : builder_compact(bytes, target, size);
}

static inline uint64_t bytes_serialized_size(const void *bytes)
{
    return micromap_is(bytes) ? micromap_serialized_size(bytes) : builder_serialized_size(bytes);
}

static inline uint64_t bytes_reference_count(const void *bytes)
{
    return micromap_is(bytes) ? 0 : builder_reference_count(bytes);
}

static inline enum builder_result
bytes_serialize(const void *bytes, const struct builder_uuids *uuids, void *to, uint64_t size)
{
    return micromap_is(bytes) ? micromap_serialize(bytes, uuids, to, size)
                              : builder_serialize(bytes, uuids, to, size);
}

/* Whether the bytes are those of a bottom-level, or top-level, structure (`type`). */
static inline bool bytes_are_of_level(const void *bytes, VkAccelerationStructureTypeKHR type)
{
    return !micromap_is(bytes) && builder_type(bytes) == type;
}

#endif
