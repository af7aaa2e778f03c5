/* SPDX-License-Identifier: Apache-2.0 */
/* The query pools of one device. Each query of a property of structures or micromaps has an id that
 * is never reused, even if the handle of its pool is. The table has its own lock. */
#ifndef ASSAY_STATE_COMMANDS_QUERY_POOLS_H
#define ASSAY_STATE_COMMANDS_QUERY_POOLS_H

#include <stdbool.h>
#include <stdint.h>
#include <vulkan/vulkan_core.h>

#include "src/state/facts.h"

struct query_pools;

VkResult query_pools_create(struct query_pools **pools);
void query_pools_destroy(struct query_pools *pools);

struct query_pool {
    uint64_t first_id; /* id of query 0; the ids of the others follow */
    uint32_t count;    /* number of queries */
    VkQueryType type;
};

/* Whether queries of a type are of properties of structures or micromaps. */
static inline bool query_type_is_property(VkQueryType type)
{
    switch ((int)type) {
    case VK_QUERY_TYPE_ACCELERATION_STRUCTURE_SIZE_KHR:
    case VK_QUERY_TYPE_ACCELERATION_STRUCTURE_SERIALIZATION_BOTTOM_LEVEL_POINTERS_KHR:
    case VK_QUERY_TYPE_ACCELERATION_STRUCTURE_COMPACTED_SIZE_KHR:
    case VK_QUERY_TYPE_ACCELERATION_STRUCTURE_SERIALIZATION_SIZE_KHR:
    case VK_QUERY_TYPE_ACCELERATION_STRUCTURE_COMPACTED_SIZE_NV:
    case VK_QUERY_TYPE_MICROMAP_COMPACTED_SIZE_EXT:
    case VK_QUERY_TYPE_MICROMAP_SERIALIZATION_SIZE_EXT:
        return true;
    default:
        return false;
    }
}

/* Gives the queries ids if `has_ids`. If memory runs out, the pool is unknown. */
void query_pools_add(struct query_pools *pools, VkQueryPool handle,
                     const VkQueryPoolCreateInfo *info, bool has_ids);
/* Finds the first of these queries that was certainly never touched: of properties only. */
bool query_pools_find_untouched(struct query_pools *pools, VkQueryPool handle, uint32_t first,
                                uint32_t count, uint32_t *number);
/* For any pool. */
void query_pools_facts(struct query_pools *pools, VkQueryPool handle,
                       struct query_pool_facts *facts);
/* Whether the pool whose query has this id is alive. */
enum tristate query_pools_has(struct query_pools *pools, VkQueryPool handle, uint64_t query_id);
/* These return false if the pool is unknown, or its queries have no ids. */
bool query_pools_remove(struct query_pools *pools, VkQueryPool handle, struct query_pool *pool);
bool query_pools_find(struct query_pools *pools, VkQueryPool handle, struct query_pool *pool);
/* Notes that a command resets or writes queries, when it is recorded or called by the host. */
bool query_pools_touch(struct query_pools *pools, VkQueryPool handle, uint32_t first,
                       uint32_t count, struct query_pool *pool);

/* Returns how many of the `count` queries from `first` on exist in the pool. */
uint32_t query_pool_clamp(const struct query_pool *pool, uint32_t first, uint32_t count);

#endif
