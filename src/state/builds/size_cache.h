/* SPDX-License-Identifier: Apache-2.0 */
/* Build sizes by build shape, so that the driver is asked once a shape.
 *
 * vkGetAccelerationStructureBuildSizesKHR ignores addresses, src, dst and mode, except whether
 * transformData is null (Vulkan specification, VkAccelerationStructureBuildSizesInfoKHR); the rest
 * of a build and its primitive counts are its shape. A shape is known by a 128-bit hash (XXH3). */
#ifndef ASSAY_STATE_BUILDS_SIZE_CACHE_H
#define ASSAY_STATE_BUILDS_SIZE_CACHE_H

#include <stdbool.h>
#include <stdint.h>
#include <vulkan/vulkan_core.h>

#include "src/state/facts.h"

struct size_cache; /* one per device; any thread may use it at any time */

VkResult size_cache_create(struct size_cache **cache);
void size_cache_destroy(struct size_cache *cache);

struct build_shape {
    uint64_t low, high;
};

/* False where a chain is present whose meaning for the sizes isn't known: ask the driver then. All
 * of `info` and `counts` must be readable. */
bool build_shape_of(const VkAccelerationStructureBuildGeometryInfoKHR *info,
                    const uint32_t *primitive_counts,
                    VkAccelerationStructureBuildTypeKHR build_type, struct build_shape *shape);

/* False if the sizes of the shape aren't there, or if they are just being replaced; `sizes` are
 * left alone then. */
bool size_cache_find(const struct size_cache *cache, const struct build_shape *shape,
                     struct size_facts *sizes);
/* Keeps sizes that are known, in place of those of another shape; or keeps none, if another thread
 * replaces the same ones. */
void size_cache_add(struct size_cache *cache, const struct build_shape *shape,
                    const struct size_facts *sizes);

#endif
