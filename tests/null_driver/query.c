/* SPDX-License-Identifier: Apache-2.0 */
/* Query pools. What a query answers depends on its type alone. */
#include "internal.h"

static uint64_t query_value(VkQueryType type)
{
    switch ((int)type) {
    case VK_QUERY_TYPE_ACCELERATION_STRUCTURE_COMPACTED_SIZE_KHR:
    case VK_QUERY_TYPE_ACCELERATION_STRUCTURE_COMPACTED_SIZE_NV:
    case VK_QUERY_TYPE_MICROMAP_COMPACTED_SIZE_EXT:
        return COMPACTED_SIZE;
    case VK_QUERY_TYPE_ACCELERATION_STRUCTURE_SERIALIZATION_SIZE_KHR:
    case VK_QUERY_TYPE_MICROMAP_SERIALIZATION_SIZE_EXT:
        return SERIALIZED_SIZE;
    case VK_QUERY_TYPE_ACCELERATION_STRUCTURE_SIZE_KHR:
        return STRUCTURE_SIZE;
    default:
        return 0;
    }
}

static void write_value(void *to, size_t size, uint64_t value)
{
    const uint32_t low = (uint32_t)value;
    memcpy(to, size == sizeof(low) ? (const void *)&low : (const void *)&value, size);
}

void query_write(uint32_t count, VkQueryType type, size_t size, void *data, size_t stride)
{
    const uint64_t value = query_value(type);
    if (data == NULL)
        return;
    for (uint32_t i = 0; i < count && i * stride + sizeof(value) <= size; i++)
        write_value((char *)data + i * stride, sizeof(value), value);
}

/* All queries are available at once. */
COMMAND(GetQueryPoolResults)
{
    const struct object *pool = FIND(QUERY_POOL, queryPool);
    if (device_is_lost())
        return VK_ERROR_DEVICE_LOST;
    if (pool == NULL)
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    const size_t word = flags & VK_QUERY_RESULT_64_BIT ? sizeof(uint64_t) : sizeof(uint32_t);
    const bool extra = flags & VK_QUERY_RESULT_WITH_AVAILABILITY_BIT;
    const size_t size = extra ? 2 * word : word;
    for (uint32_t i = 0; i < queryCount && i * stride + size <= dataSize; i++) {
        char *to = (char *)pData + i * stride;
        write_value(to, word, query_value(pool->query_type));
        if (extra)
            write_value(to + word, word, 1);
    }
    return VK_SUCCESS;
}
