/* SPDX-License-Identifier: Apache-2.0 */
/* The query pools of one device that take compacted sizes of acceleration structures, and ids of
 * their queries, which no query of another pool has, though handles are reused. It has its own
 * lock. */
#ifndef ASSAY_STATE_COMMANDS_QUERY_POOLS_H
#define ASSAY_STATE_COMMANDS_QUERY_POOLS_H

#include <stdbool.h>
#include <stdint.h>
#include <vulkan/vulkan_core.h>

struct query_pools;

VkResult query_pools_create(struct query_pools **pools);
void query_pools_destroy(struct query_pools *pools);

struct query_pool {
    uint64_t first_id; /* of query 0; the others follow */
    uint32_t count;    /* of queries */
};

/* Of a pool that can't be kept for lack of memory nothing is known. */
void query_pools_add(struct query_pools *pools, VkQueryPool handle, uint32_t count);
/* False where the pool isn't known, as is any of another query type. */
bool query_pools_remove(struct query_pools *pools, VkQueryPool handle, struct query_pool *pool);
bool query_pools_find(struct query_pools *pools, VkQueryPool handle, struct query_pool *pool);

/* How many of `count` queries from `first` on the pool has. */
uint32_t query_pool_clamp(const struct query_pool *pool, uint32_t first, uint32_t count);

#endif
