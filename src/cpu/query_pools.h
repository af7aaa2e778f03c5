/* SPDX-License-Identifier: Apache-2.0 */
/* Query pools for properties of acceleration structures.
 *
 * A query holds a reference to the tree whose property it returns, and the ticket of the submission
 * that wrote it. Its value is computed when it is read. One lock guards all pools; it is not held
 * while trees are read or tickets are waited for. */
#ifndef ASSAY_CPU_QUERY_POOLS_H
#define ASSAY_CPU_QUERY_POOLS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "src/cpu/trees/tree.h"
#include "src/snapshots/ticket.h"

struct cpu_query_pools;

VkResult cpu_query_pools_create(struct cpu_query_pools **pools);
void cpu_query_pools_destroy(struct cpu_query_pools *pools); /* accepts NULL */

/* Whether the backend implements queries of a type. */
bool cpu_query_type_is_known(VkQueryType type);

VkResult cpu_query_pools_add(struct cpu_query_pools *pools, VkQueryType type, uint32_t count,
                             uint64_t *handle);
void cpu_query_pools_remove(struct cpu_query_pools *pools, uint64_t handle);
bool cpu_query_pools_has(struct cpu_query_pools *pools, uint64_t handle);

/* This function and those below ignore queries beyond the end of the pool. */
void cpu_query_pools_reset(struct cpu_query_pools *pools, uint64_t handle, uint32_t first,
                           uint32_t count);
/* Takes over the tree (NULL: not built); shares the ticket. */
void cpu_query_pools_write(struct cpu_query_pools *pools, uint64_t handle, uint32_t query,
                           struct cpu_tree *tree, struct ticket *ticket);

/* Creates a pool with copies of `*count` queries. Sets `*count` to the number of those that exist.
 */
VkResult cpu_query_pools_copy(struct cpu_query_pools *pools, uint64_t handle, uint32_t first,
                              uint32_t *count, uint64_t *copy);

/* vkGetQueryPoolResults. Does not wait for a query that no submission has written. */
VkResult cpu_query_pools_read(struct cpu_query_pools *pools, uint64_t handle, uint32_t first,
                              uint32_t count, size_t size, void *data, VkDeviceSize stride,
                              VkQueryResultFlags flags);

#endif
