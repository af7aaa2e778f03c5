/* SPDX-License-Identifier: Apache-2.0 */
/* Query pools of acceleration-structure properties.
 *
 * A query holds the tree that it was written for, and the ticket of the submission that wrote it;
 * its value is found when somebody reads it. One lock guards all pools; trees are read and tickets
 * waited for without it. */
#ifndef ASSAY_CPU_QUERY_POOLS_H
#define ASSAY_CPU_QUERY_POOLS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "src/cpu/trees/tree.h"
#include "src/snapshots/ticket.h"

struct cpu_query_pools;

VkResult cpu_query_pools_create(struct cpu_query_pools **pools);
void cpu_query_pools_destroy(struct cpu_query_pools *pools); /* NULL: nothing */

/* Whether queries of a type are the backend's. */
bool cpu_query_type_is_known(VkQueryType type);

VkResult cpu_query_pools_add(struct cpu_query_pools *pools, VkQueryType type, uint32_t count,
                             uint64_t *handle);
void cpu_query_pools_remove(struct cpu_query_pools *pools, uint64_t handle);
bool cpu_query_pools_has(struct cpu_query_pools *pools, uint64_t handle);

/* Queries that the pool doesn't have are left out, here and below. */
void cpu_query_pools_reset(struct cpu_query_pools *pools, uint64_t handle, uint32_t first,
                           uint32_t count);
/* Takes over the tree (NULL: not built); shares the ticket. */
void cpu_query_pools_write(struct cpu_query_pools *pools, uint64_t handle, uint32_t query,
                           struct cpu_tree *tree, struct ticket *ticket);

/* A pool of copies of `*count` queries, as they are now; *count becomes how many of them there are.
 */
VkResult cpu_query_pools_copy(struct cpu_query_pools *pools, uint64_t handle, uint32_t first,
                              uint32_t *count, uint64_t *copy);

/* vkGetQueryPoolResults. A query that nothing has written is not waited for. */
VkResult cpu_query_pools_read(struct cpu_query_pools *pools, uint64_t handle, uint32_t first,
                              uint32_t count, size_t size, void *data, VkDeviceSize stride,
                              VkQueryResultFlags flags);

#endif
