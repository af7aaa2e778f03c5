/* SPDX-License-Identifier: Apache-2.0 */
/* Properties of trees, by query type. */
#include "src/cpu/trees/property.h"

#include "src/cpu/trees/bytes.h"

bool cpu_property(const void *tree, VkQueryType type, uint64_t *value)
{
    switch (type) {
    case VK_QUERY_TYPE_ACCELERATION_STRUCTURE_COMPACTED_SIZE_KHR:
    case VK_QUERY_TYPE_ACCELERATION_STRUCTURE_COMPACTED_SIZE_NV:
    case VK_QUERY_TYPE_MICROMAP_COMPACTED_SIZE_EXT:
        *value = bytes_compacted_size(tree);
        return true;
    case VK_QUERY_TYPE_ACCELERATION_STRUCTURE_SERIALIZATION_SIZE_KHR:
    case VK_QUERY_TYPE_MICROMAP_SERIALIZATION_SIZE_EXT:
        *value = bytes_serialized_size(tree);
        return true;
    case VK_QUERY_TYPE_ACCELERATION_STRUCTURE_SERIALIZATION_BOTTOM_LEVEL_POINTERS_KHR:
        *value = bytes_reference_count(tree);
        return true;
    case VK_QUERY_TYPE_ACCELERATION_STRUCTURE_SIZE_KHR:
        *value = bytes_size(tree);
        return true;
    default:
        return false;
    }
}
