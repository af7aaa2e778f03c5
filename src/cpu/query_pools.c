/* SPDX-License-Identifier: Apache-2.0 */
/* The table of query pools, and their results. */
#include "src/cpu/query_pools.h"

#include <stdlib.h>
#include <string.h>

#include "src/base/handle_table.h"
#include "src/cpu/structures.h"
#include "src/cpu/trees/tree.h"
#include "src/platform/threads.h"
#include "src/state/commands/query_pools.h"

struct query {
    struct ticket *ticket; /* NULL: reset, or never written */
    struct cpu_tree *tree; /* NULL: the structure was not built */
};

struct cpu_query_pool {
    VkQueryType type;
    uint32_t count;
    struct query queries[];
};

struct cpu_query_pools {
    pthread_mutex_t lock;
    struct handle_table table; /* of struct cpu_query_pool */
};

VkResult cpu_query_pools_create(struct cpu_query_pools **pools)
{
    *pools = calloc(1, sizeof(**pools));
    if (!*pools)
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    pthread_mutex_init(&(*pools)->lock, NULL);
    return VK_SUCCESS;
}

static void release_query(const struct query *query)
{
    ticket_release(query->ticket);
    cpu_tree_release(query->tree);
}

static void free_pool(void *record)
{
    struct cpu_query_pool *pool = record;
    for (uint32_t i = 0; pool && i < pool->count; i++)
        release_query(&pool->queries[i]);
    free(pool);
}

void cpu_query_pools_destroy(struct cpu_query_pools *pools)
{
    if (!pools)
        return;
    handle_table_drop(&pools->table, free_pool);
    pthread_mutex_destroy(&pools->lock);
    free(pools);
}

static struct cpu_query_pool *create_pool(VkQueryType type, uint32_t count)
{
    struct cpu_query_pool *pool = calloc(1, sizeof(*pool) + count * sizeof(pool->queries[0]));
    if (!pool)
        return NULL;
    pool->type = type;
    pool->count = count;
    return pool;
}

static VkResult add_pool(struct cpu_query_pools *pools, struct cpu_query_pool *pool,
                         uint64_t *handle)
{
    *handle = cpu_unique_handle();
    pthread_mutex_lock(&pools->lock);
    bool is_added = handle_table_set(&pools->table, *handle, pool);
    pthread_mutex_unlock(&pools->lock);
    if (is_added)
        return VK_SUCCESS;
    free_pool(pool);
    return VK_ERROR_OUT_OF_HOST_MEMORY;
}

VkResult cpu_query_pools_add(struct cpu_query_pools *pools, VkQueryType type, uint32_t count,
                             uint64_t *handle)
{
    struct cpu_query_pool *pool = create_pool(type, count);
    return pool ? add_pool(pools, pool, handle) : VK_ERROR_OUT_OF_HOST_MEMORY;
}

void cpu_query_pools_remove(struct cpu_query_pools *pools, uint64_t handle)
{
    pthread_mutex_lock(&pools->lock);
    struct cpu_query_pool *pool = handle_table_remove(&pools->table, handle);
    pthread_mutex_unlock(&pools->lock);
    free_pool(pool);
}

bool cpu_query_type_is_known(VkQueryType type)
{
    return query_type_is_property(type);
}

bool cpu_query_pools_has(struct cpu_query_pools *pools, uint64_t handle)
{
    pthread_mutex_lock(&pools->lock);
    bool has = handle_table_find(&pools->table, handle) != NULL;
    pthread_mutex_unlock(&pools->lock);
    return has;
}

/* Replaces a query with `next`, and returns the old one. Returns `next` if there is no such query.
 */
static struct query exchange_query(struct cpu_query_pools *pools, uint64_t handle, uint32_t query,
                                   struct query next)
{
    struct query before = next;
    pthread_mutex_lock(&pools->lock);
    struct cpu_query_pool *pool = handle_table_find(&pools->table, handle);
    if (pool && query < pool->count) {
        before = pool->queries[query];
        pool->queries[query] = next;
    }
    pthread_mutex_unlock(&pools->lock);
    return before;
}

/* Returns how many of the queries exist; 0 if the pool is unknown. */
static uint32_t clamp_count(struct cpu_query_pools *pools, uint64_t handle, uint32_t first,
                            uint32_t count)
{
    pthread_mutex_lock(&pools->lock);
    const struct cpu_query_pool *pool = handle_table_find(&pools->table, handle);
    uint32_t left = pool && first < pool->count ? pool->count - first : 0;
    pthread_mutex_unlock(&pools->lock);
    return count < left ? count : left;
}

void cpu_query_pools_reset(struct cpu_query_pools *pools, uint64_t handle, uint32_t first,
                           uint32_t count)
{
    uint32_t existing = clamp_count(pools, handle, first, count);
    for (uint32_t i = 0; i < existing; i++) {
        struct query before = exchange_query(pools, handle, first + i, (struct query){0});
        release_query(&before);
    }
}

void cpu_query_pools_write(struct cpu_query_pools *pools, uint64_t handle, uint32_t query,
                           struct cpu_tree *tree, struct ticket *ticket)
{
    struct query next = {.ticket = ticket_share(ticket), .tree = tree};
    struct query before = exchange_query(pools, handle, query, next);
    release_query(&before);
}

/* ---- results */

/* Copies a query, and adds references. Returns false if there is no such query. */
static bool find_query(struct cpu_query_pools *pools, uint64_t handle, uint32_t query,
                       struct query *found, VkQueryType *type)
{
    pthread_mutex_lock(&pools->lock);
    const struct cpu_query_pool *pool = handle_table_find(&pools->table, handle);
    bool is_found = pool && query < pool->count;
    if (is_found) {
        *found = pool->queries[query];
        *type = pool->type;
        if (found->ticket)
            ticket_share(found->ticket);
        if (found->tree)
            cpu_tree_keep(found->tree);
    }
    pthread_mutex_unlock(&pools->lock);
    return is_found;
}

VkResult cpu_query_pools_copy(struct cpu_query_pools *pools, uint64_t handle, uint32_t first,
                              uint32_t *count, uint64_t *copy)
{
    *count = clamp_count(pools, handle, first, *count);
    struct cpu_query_pool *pool = create_pool(VK_QUERY_TYPE_MAX_ENUM, *count);
    if (!pool)
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    for (uint32_t i = 0; i < *count; i++)
        find_query(pools, handle, first + i, &pool->queries[i], &pool->type);
    return add_pool(pools, pool, copy);
}

/* Returns VK_SUCCESS, VK_NOT_READY, or the error of the submission. Leaves `value` unchanged if the
 * structure is not built. */
static VkResult value_of(const struct query *query, VkQueryType type, bool waits, uint64_t *value)
{
    if (!query->ticket)
        return VK_NOT_READY;
    VkResult result = query->ticket->wait(query->ticket, waits ? UINT64_MAX : 0);
    if (result != VK_SUCCESS)
        return result == VK_TIMEOUT ? VK_NOT_READY : result;
    const void *bytes = query->tree ? cpu_tree_read(query->tree) : NULL;
    if (bytes)
        cpu_property(bytes, type, value);
    return VK_SUCCESS;
}

/* Writes a value if it fits into `size` bytes. */
static void put_value(unsigned char *data, size_t size, uint64_t at, uint64_t value, bool is_64_bit)
{
    const uint32_t low = value < UINT32_MAX ? (uint32_t)value : UINT32_MAX;
    const size_t width = is_64_bit ? sizeof(value) : sizeof(low);
    if (at <= size && width <= size - at)
        memcpy(data + at, is_64_bit ? (const void *)&value : (const void *)&low, width);
}

VkResult cpu_query_pools_read(struct cpu_query_pools *pools, uint64_t handle, uint32_t first,
                              uint32_t count, size_t size, void *data, VkDeviceSize stride,
                              VkQueryResultFlags flags)
{
    bool is_64_bit = flags & VK_QUERY_RESULT_64_BIT;
    VkResult result = VK_SUCCESS;
    for (uint32_t i = 0; i < count; i++) {
        struct query query;
        VkQueryType type;
        uint64_t value = 0, at = i * stride;
        if (!find_query(pools, handle, first + i, &query, &type))
            break;
        VkResult state = value_of(&query, type, flags & VK_QUERY_RESULT_WAIT_BIT, &value);
        release_query(&query);
        if (state == VK_SUCCESS || (flags & VK_QUERY_RESULT_PARTIAL_BIT))
            put_value(data, size, at, value, is_64_bit);
        if (flags & VK_QUERY_RESULT_WITH_AVAILABILITY_BIT)
            put_value(data, size, at + (is_64_bit ? 8 : 4), state == VK_SUCCESS, is_64_bit);
        if (state != VK_SUCCESS && result >= VK_SUCCESS)
            result = state;
    }
    return result;
}
