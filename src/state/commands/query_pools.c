/* SPDX-License-Identifier: Apache-2.0 */
/* The table of query pools. */
#include "src/state/commands/query_pools.h"

#include <stdatomic.h>
#include <stdlib.h>

#include "src/base/handle_table.h"
#include "src/base/reader_lock.h"

/* Ids of queries never equal ids of structures, which count from 1. */
#define FIRST_QUERY_ID ((uint64_t)1 << 63)

struct pool_record {
    struct query_pool pool; /* first_id: 0 if the queries have no ids */
};

struct query_pools {
    atomic_uint count; /* of pools; most applications have none */
    struct reader_lock lock;
    struct handle_table by_handle;
    uint64_t next_id;
    bool incomplete; /* memory ran out for a record */
};

VkResult query_pools_create(struct query_pools **pools)
{
    *pools = calloc(1, sizeof(**pools));
    if (!*pools)
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    (*pools)->next_id = FIRST_QUERY_ID;
    return VK_SUCCESS;
}

void query_pools_destroy(struct query_pools *pools)
{
    if (!pools)
        return;
    handle_table_drop(&pools->by_handle, free);
    free(pools);
}

static struct pool_record *take_out(struct query_pools *pools, VkQueryPool handle)
{
    struct pool_record *record =
        handle_table_remove(&pools->by_handle, (uint64_t)(uintptr_t)handle);
    if (record)
        atomic_fetch_sub_explicit(&pools->count, 1, memory_order_relaxed);
    return record;
}

static void add_pool(struct query_pools *pools, VkQueryPool handle, VkQueryType type,
                     uint32_t count, bool has_ids)
{
    struct pool_record *record = malloc(sizeof(*record));
    reader_lock_write(&pools->lock);
    free(take_out(pools, handle));
    if (record) {
        *record = (struct pool_record){{has_ids ? pools->next_id : 0, count, type}};
        pools->next_id += has_ids ? count : 0;
    }
    if (record && handle_table_set(&pools->by_handle, (uint64_t)(uintptr_t)handle, record)) {
        atomic_fetch_add_explicit(&pools->count, 1, memory_order_relaxed);
    } else {
        free(record);
        pools->incomplete = true;
    }
    reader_lock_write_done(&pools->lock);
}

void query_pools_add(struct query_pools *pools, VkQueryPool handle, VkQueryType type,
                     uint32_t count)
{
    add_pool(pools, handle, type, count, true);
}

void query_pools_add_plain(struct query_pools *pools, VkQueryPool handle, VkQueryType type,
                           uint32_t count)
{
    add_pool(pools, handle, type, count, false);
}

void query_pools_facts(struct query_pools *pools, VkQueryPool handle,
                       struct query_pool_facts *facts)
{
    *facts = (struct query_pool_facts){.handle = handle};
    if (!handle)
        return;
    unsigned stripe = reader_lock_enter(&pools->lock);
    const struct pool_record *record =
        handle_table_find(&pools->by_handle, (uint64_t)(uintptr_t)handle);
    facts->alive = record ? YES : pools->incomplete ? UNKNOWN : NO;
    if (record) {
        facts->type = record->pool.type;
        facts->count = record->pool.count;
    }
    reader_lock_leave(&pools->lock, stripe);
}

static bool has_pools(struct query_pools *pools)
{
    return atomic_load_explicit(&pools->count, memory_order_relaxed) != 0;
}

bool query_pools_remove(struct query_pools *pools, VkQueryPool handle, struct query_pool *pool)
{
    if (!has_pools(pools))
        return false;
    reader_lock_write(&pools->lock);
    struct pool_record *record = take_out(pools, handle);
    reader_lock_write_done(&pools->lock);
    bool has_ids = record && record->pool.first_id;
    if (has_ids)
        *pool = record->pool;
    free(record);
    return has_ids;
}

bool query_pools_find(struct query_pools *pools, VkQueryPool handle, struct query_pool *pool)
{
    if (!has_pools(pools))
        return false;
    unsigned stripe = reader_lock_enter(&pools->lock);
    const struct pool_record *record =
        handle_table_find(&pools->by_handle, (uint64_t)(uintptr_t)handle);
    bool has_ids = record && record->pool.first_id;
    if (has_ids)
        *pool = record->pool;
    reader_lock_leave(&pools->lock, stripe);
    return has_ids;
}

uint32_t query_pool_clamp(const struct query_pool *pool, uint32_t first, uint32_t count)
{
    uint32_t left = first < pool->count ? pool->count - first : 0;
    return count < left ? count : left;
}
