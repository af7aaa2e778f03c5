/* SPDX-License-Identifier: Apache-2.0 */
/* Caches build sizes by build shape, so that the driver is queried once for each shape.
 *
 * vkGetAccelerationStructureBuildSizesKHR ignores addresses, src, dst and mode, except whether
 * triangles have a transform (Vulkan specification, VkAccelerationStructureBuildSizesInfoKHR); the
 * other parameters of a build and its primitive counts are its shape. A 128-bit hash (XXH3)
 * identifies a shape. */
#ifndef ASSAY_STATE_BUILDS_SIZE_CACHE_H
#define ASSAY_STATE_BUILDS_SIZE_CACHE_H

#include <stdbool.h>
#include <stdint.h>
#include <vulkan/vulkan_core.h>

#include "src/state/facts.h"

struct size_cache; /* one per device; any thread may use it at any time */

/* The caller destroys `*cache`. Returns VK_ERROR_OUT_OF_HOST_MEMORY if there is no memory. */
VkResult size_cache_create(struct size_cache **cache);
void size_cache_destroy(struct size_cache *cache);

struct build_shape {
    uint64_t low, high;
};

/* Returns false if there is a chain, whose effect on the sizes is unknown: then query the driver.
 * All of `info` and `primitive_counts` must be readable. */
bool build_shape_of(const VkAccelerationStructureBuildGeometryInfoKHR *info,
                    const uint32_t *primitive_counts,
                    VkAccelerationStructureBuildTypeKHR build_type, struct build_shape *shape);

/* Returns false, and leaves `sizes` unchanged, if the cache lacks the shape or another thread is
 * writing its entry. */
bool size_cache_find(const struct size_cache *cache, const struct build_shape *shape,
                     struct size_facts *sizes);
/* Stores known sizes, replacing those of another shape. Does nothing if another thread is writing
 * the same entry. */
void size_cache_add(struct size_cache *cache, const struct build_shape *shape,
                    const struct size_facts *sizes);

#endif
