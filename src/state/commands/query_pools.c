/* SPDX-License-Identifier: Apache-2.0 */
/* The table of query pools. */
#include "src/state/commands/query_pools.h"

#include <stdatomic.h>
#include <stdlib.h>

#include "src/base/handle_table.h"
#include "src/base/reader_lock.h"
#include "src/base/unknown.h"

/* Ids of queries never equal ids of structures, which count from 1. */
#define FIRST_QUERY_ID ((uint64_t)1 << 63)

struct pool_record {
    struct query_pool pool; /* first_id: 0 if the queries have no ids */
    bool *touched;          /* by query; NULL: unknown */
};

struct query_pools {
    atomic_uint count; /* of pools; most applications have none */
    struct reader_lock lock;
    struct handle_table by_handle;
    uint64_t next_id;
    struct unknown unknown; /* memory ran out for a record */
};

VkResult query_pools_create(struct query_pools **pools)
{
    *pools = calloc(1, sizeof(**pools));
    if (!*pools)
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    (*pools)->next_id = FIRST_QUERY_ID;
    return VK_SUCCESS;
}

static void release_pool(void *record)
{
    if (record)
        free(((struct pool_record *)record)->touched);
    free(record);
}

void query_pools_destroy(struct query_pools *pools)
{
    if (!pools)
        return;
    handle_table_drop(&pools->by_handle, release_pool);
    free(pools);
}

static struct pool_record *take_out(struct query_pools *pools, VkQueryPool handle)
{
    struct pool_record *record = handle_table_remove(&pools->by_handle, handle_number(handle));
    if (record)
        atomic_fetch_sub_explicit(&pools->count, 1, memory_order_relaxed);
    return record;
}

/* What touches queries of other types is not observed. */
static struct pool_record *create_record(const VkQueryPoolCreateInfo *info)
{
    struct pool_record *record = calloc(1, sizeof(*record));
    if (!record)
        return NULL;
    record->pool = (struct query_pool){.count = info->queryCount, .type = info->queryType};
    if (query_type_is_property(info->queryType) &&
        !(info->flags & VK_QUERY_POOL_CREATE_RESET_BIT_KHR))
        record->touched = calloc(info->queryCount, sizeof(*record->touched));
    return record;
}

void query_pools_add(struct query_pools *pools, VkQueryPool handle,
                     const VkQueryPoolCreateInfo *info, bool has_ids)
{
    struct pool_record *record = create_record(info);
    reader_lock_write(&pools->lock);
    release_pool(take_out(pools, handle));
    if (record && has_ids) {
        record->pool.first_id = pools->next_id;
        pools->next_id += info->queryCount;
    }
    if (record && handle_table_set(&pools->by_handle, handle_number(handle), record)) {
        atomic_fetch_add_explicit(&pools->count, 1, memory_order_relaxed);
    } else {
        release_pool(record);
        unknown_set(&pools->unknown, UNKNOWN_QUERY_POOLS);
    }
    reader_lock_write_done(&pools->lock);
}

void query_pools_facts(struct query_pools *pools, VkQueryPool handle,
                       struct query_pool_facts *facts)
{
    *facts = (struct query_pool_facts){.handle = handle};
    if (!handle)
        return;
    unsigned stripe = reader_lock_enter(&pools->lock);
    const struct pool_record *record = handle_table_find(&pools->by_handle, handle_number(handle));
    facts->alive = record ? YES : unknown_is_set(&pools->unknown) ? UNKNOWN : NO;
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

static bool copy_if_tracked(const struct pool_record *record, struct query_pool *pool)
{
    const bool has_ids = record && record->pool.first_id;
    if (has_ids)
        *pool = record->pool;
    return has_ids;
}

bool query_pools_remove(struct query_pools *pools, VkQueryPool handle, struct query_pool *pool)
{
    if (!has_pools(pools))
        return false;
    reader_lock_write(&pools->lock);
    struct pool_record *record = take_out(pools, handle);
    reader_lock_write_done(&pools->lock);
    const bool has_ids = copy_if_tracked(record, pool);
    release_pool(record);
    return has_ids;
}

bool query_pools_find(struct query_pools *pools, VkQueryPool handle, struct query_pool *pool)
{
    if (!has_pools(pools))
        return false;
    unsigned stripe = reader_lock_enter(&pools->lock);
    const bool has_ids =
        copy_if_tracked(handle_table_find(&pools->by_handle, handle_number(handle)), pool);
    reader_lock_leave(&pools->lock, stripe);
    return has_ids;
}

enum tristate query_pools_has(struct query_pools *pools, VkQueryPool handle, uint64_t query_id)
{
    unsigned stripe = reader_lock_enter(&pools->lock);
    const struct pool_record *record = handle_table_find(&pools->by_handle, handle_number(handle));
    const enum tristate absent = unknown_is_set(&pools->unknown) ? UNKNOWN : NO;
    const bool has =
        record && record->pool.first_id && query_id - record->pool.first_id < record->pool.count;
    reader_lock_leave(&pools->lock, stripe);
    return has ? YES : absent;
}

uint32_t query_pool_clamp(const struct query_pool *pool, uint32_t first, uint32_t count)
{
    uint32_t left = first < pool->count ? pool->count - first : 0;
    return count < left ? count : left;
}

bool query_pools_touch(struct query_pools *pools, VkQueryPool handle, uint32_t first,
                       uint32_t count, struct query_pool *pool)
{
    if (!has_pools(pools))
        return false;
    reader_lock_write(&pools->lock);
    struct pool_record *record = handle_table_find(&pools->by_handle, handle_number(handle));
    if (record && record->touched)
        for (uint32_t i = query_pool_clamp(&record->pool, first, count); i-- > 0;)
            record->touched[first + i] = true;
    const bool has_ids = copy_if_tracked(record, pool);
    reader_lock_write_done(&pools->lock);
    return has_ids;
}

static bool find_untouched(const struct pool_record *record, uint32_t first, uint32_t count,
                           uint32_t *number)
{
    for (uint32_t i = 0; i < query_pool_clamp(&record->pool, first, count); i++) {
        *number = first + i;
        if (!record->touched[*number])
            return true;
    }
    return false;
}

bool query_pools_find_untouched(struct query_pools *pools, VkQueryPool handle, uint32_t first,
                                uint32_t count, uint32_t *number)
{
    if (!has_pools(pools))
        return false;
    unsigned stripe = reader_lock_enter(&pools->lock);
    const struct pool_record *record = handle_table_find(&pools->by_handle, handle_number(handle));
    const bool found = record && record->touched && find_untouched(record, first, count, number);
    reader_lock_leave(&pools->lock, stripe);
    return found;
}
