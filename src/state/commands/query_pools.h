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

/* If memory runs out, the pool is unknown. The queries of query_pools_add() have ids. */
void query_pools_add(struct query_pools *pools, VkQueryPool handle, VkQueryType type,
                     uint32_t count);
void query_pools_add_plain(struct query_pools *pools, VkQueryPool handle, VkQueryType type,
                           uint32_t count);
/* For any pool. */
void query_pools_facts(struct query_pools *pools, VkQueryPool handle,
                       struct query_pool_facts *facts);
/* Both return false if the pool is unknown, or its queries have no ids. */
bool query_pools_remove(struct query_pools *pools, VkQueryPool handle, struct query_pool *pool);
bool query_pools_find(struct query_pools *pools, VkQueryPool handle, struct query_pool *pool);

/* Returns how many of the `count` queries from `first` on exist in the pool. */
uint32_t query_pool_clamp(const struct query_pool *pool, uint32_t first, uint32_t count);

#endif
