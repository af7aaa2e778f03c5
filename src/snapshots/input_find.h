/* SPDX-License-Identifier: Apache-2.0 */
/* How far the data of a geometry extends, and where it lies in the memory that builds read. */
#ifndef ASSAY_SNAPSHOTS_INPUT_FIND_H
#define ASSAY_SNAPSHOTS_INPUT_FIND_H

#include <vulkan/vulkan_core.h>

#include "src/snapshots/memory.h"

/* offset + count * stride + size, at most UINT64_MAX. */
static inline uint64_t input_extent(uint64_t offset, uint64_t count, uint64_t stride, uint64_t size)
{
    uint64_t sum;
    return __builtin_mul_overflow(count, stride, &sum) ||
                   __builtin_add_overflow(sum, offset, &sum) ||
                   __builtin_add_overflow(sum, size, &sum)
               ? UINT64_MAX
               : sum;
}

static inline uint64_t input_find(const struct input_memory *memory,
                                  VkDeviceOrHostAddressConstKHR address, uint64_t size,
                                  const void **bytes)
{
    return memory->find(memory->context, address.deviceAddress, size, bytes);
}

enum { INPUT_VERTEX_MAX = 32 /* the most bytes of any format */ };

static inline uint64_t input_index_size(VkIndexType type)
{
    return type == VK_INDEX_TYPE_UINT32 ? 4 : type == VK_INDEX_TYPE_UINT16 ? 2 : 1;
}

/* The number of vertices that a range may use, from its firstVertex on. */
static inline uint64_t
input_vertices(const VkAccelerationStructureGeometryTrianglesDataKHR *triangles,
               const VkAccelerationStructureBuildRangeInfoKHR *range)
{
    uint64_t vertices = (uint64_t)triangles->maxVertex + 1;
    uint64_t corners = (uint64_t)range->primitiveCount * 3;
    return triangles->indexType == VK_INDEX_TYPE_NONE_KHR && corners < vertices ? corners
                                                                                : vertices;
}

#endif
