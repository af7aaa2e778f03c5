/* SPDX-License-Identifier: Apache-2.0 */
/* Observes queries of properties. Commands that query structures, and resets of their queries, are
 * recorded in journals; resets and reads by the host are placed in execution order among the
 * batches. */
#include "layer/execution/input_checks.h"
#include "layer/execution/query_writes.h"
#include "src/state/commands/query_pools.h"

#include <stdlib.h>
#include <string.h>

#include "layer/intercepts/intercepts.h"
#include "observers.h"
#include "src/base/readable.h"
#include "src/check/replay/object_states.h"

/* ---- pools */

void note_query_pool(struct layer_device *device, VkQueryPool pool,
                     const VkQueryPoolCreateInfo *info)
{
    const bool has_ids = device->order && query_type_is_property(info->queryType);
    query_pools_add(device->query_pools, pool, info, has_ids);
    if (has_ids && info->flags & VK_QUERY_POOL_CREATE_RESET_BIT_KHR)
        note_query_resets(device, pool, 0, info->queryCount);
}

void forget_query_pool(struct layer_device *device, VkQueryPool handle)
{
    struct query_pool pool = {0};
    query_writes_forget(device->query_writes, handle);
    if (query_pools_remove(device->query_pools, handle, &pool)) {
        structures_note_destroyed(device->structures, pool.first_id, pool.count);
        resources_count_destroyed(device->resources);
    }
    object_names_end(device->names, VK_OBJECT_TYPE_QUERY_POOL, handle_number(handle),
                     pool.first_id);
}

/* ---- queries of structures and micromaps */

enum { QUERIED_AT_ONCE = 16 };

/* A command that queries a property of structures or micromaps. */
struct queried {
    enum build_command command;
    VkQueryType type;
    uint32_t count;
    const void *handles; /* of 64 bits each */
    /* In command buffers. */
    VkQueryPool pool;
    uint32_t first;
    uint64_t first_id;      /* of the first query; 0: it is unknown */
    uint32_t tracked_count; /* as many queries from the first one on have ids */
};

static struct journal_entry read_entry(const struct layer_device *device,
                                       const struct queried *queried, uint32_t i)
{
    uint64_t handle;
    memcpy(&handle, (const char *)queried->handles + i * sizeof(handle), sizeof(handle));
    const struct object_facts facts =
        object_facts_find(device->resources, journal_object_type(queried->command), handle);
    struct journal_entry entry = journal_read_entry(queried->command, queried->type);
    entry.src_backing = object_backing(&facts);
    entry.info = i;
    entry.dst = handle_number(queried->pool);
    entry.src = handle;
    entry.src_id = facts.id;
    entry.dst_id = i < queried->tracked_count ? queried->first_id + i : 0;
    entry.read.number = queried->first + i;
    return entry;
}

/* A query of another type than that of the command has no result that means anything. */
bool note_queries(struct layer_device *device, VkCommandBuffer handle, enum build_command command,
                  uint32_t count, const void *handles, VkQueryType type, VkQueryPool pool_handle,
                  uint32_t first)
{
    struct queried queried = {.command = command,
                              .type = type,
                              .count = count,
                              .handles = handles,
                              .pool = pool_handle,
                              .first = first};
    bool skip = false;
    struct query_pool pool;
    if (query_pools_touch(device->query_pools, pool_handle, first, count, &pool) &&
        pool.type == type) {
        queried.tracked_count = query_pool_clamp(&pool, first, count);
        queried.first_id = pool.first_id + first;
    }
    for (uint32_t i = 0; i < count;) {
        struct journal_entry entries[QUERIED_AT_ONCE];
        uint32_t read = 0;
        while (i < count && read < QUERIED_AT_ONCE)
            entries[read++] = read_entry(device, &queried, i++);
        skip |= layer_record(device, handle, entries, read);
    }
    return skip;
}

struct host_work begin_queries(struct layer_device *device, enum build_command command,
                               uint32_t count, const void *handles, VkQueryType type)
{
    const struct queried queried = {
        .command = command, .type = type, .count = count, .handles = handles};
    struct host_work work = host_work_begin(device);
    for (uint32_t i = 0; work.journal && i < count; i++) {
        struct journal_entry entry = read_entry(device, &queried, i);
        if (entry.src_id)
            host_work_add(&work, &entry);
    }
    return work;
}

/* ---- resets */

static void add_resets(struct journal *journal, const struct query_pool *pool, uint32_t first,
                       uint32_t count)
{
    journal_add_reset_queries(journal,
                              (struct journal_entry){.dst_id = pool->first_id + first,
                                                     .info = query_pool_clamp(pool, first, count)});
}

void note_query_resets(struct layer_device *device, VkQueryPool handle, uint32_t first,
                       uint32_t count)
{
    struct query_pool pool;
    if (!query_pools_touch(device->query_pools, handle, first, count, &pool))
        return;
    struct journal *journal = journal_create(VK_NULL_HANDLE);
    if (journal)
        add_resets(journal, &pool, first, count);
    layer_run_host_command(device, journal);
}

void note_recorded_query_resets(struct layer_device *device, VkCommandBuffer command_buffer,
                                VkQueryPool handle, uint32_t first, uint32_t count)
{
    struct query_pool pool;
    if (!query_pools_touch(device->query_pools, handle, first, count, &pool))
        return;
    struct command_buffer *recording = layer_find_recording(device, command_buffer);
    if (!recording)
        return;
    journal_begin_call(recording->journal);
    add_resets(recording->journal, &pool, first, count);
}

/* ---- other queries */

/* In a render pass instance with several views a command writes one query for each of them. */
enum { VIEWS_MAX = 32 };

void note_query_write(struct layer_device *device, VkCommandBuffer command_buffer, VkQueryPool pool,
                      uint32_t query)
{
    struct command_buffer *recording =
        device->query_writes ? layer_find_recording(device, command_buffer) : NULL;
    if (recording)
        journal_add_write_queries(
            recording->journal,
            (struct journal_entry){.dst = handle_number(pool),
                                   .info = device->facts.multiview ? VIEWS_MAX : 1,
                                   .number = query});
}

/* ---- the host reads
 *
 * The completions that the host has observed are recorded before the call goes down: a batch that
 * is submitted during the call may change a query after it was read. */

static struct journal *begin_reading(struct layer_device *device)
{
    struct journal *journal = journal_create(VK_NULL_HANDLE);
    struct host_view *host = malloc(sizeof(*host));
    struct idle_wait wait;
    if (!journal || !host) {
        device->sizes_may_be_unknown = true;
        journal_release(journal);
        free(host);
        return NULL;
    }
    journal->host = host;
    execution_order_host_clock(device->order, &host->executed);
    execution_order_start_idle(device->order, VK_NULL_HANDLE, &wait);
    host->submitted = wait.clock;
    return journal;
}

/* Without memory for an answer the application knows sizes that the layer does not. */
static void end_reading(struct layer_device *device, struct journal *reading)
{
    const bool is_complete = !unknown_is_set(&reading->unknown);
    if (!layer_run_host_command(device, reading) || !is_complete)
        device->sizes_may_be_unknown = true;
}

/* Whether a later copy is validated against results of this type. */
static bool is_size_to_track(VkQueryType type)
{
    return type == VK_QUERY_TYPE_ACCELERATION_STRUCTURE_COMPACTED_SIZE_KHR ||
           type == VK_QUERY_TYPE_ACCELERATION_STRUCTURE_SERIALIZATION_SIZE_KHR ||
           type == VK_QUERY_TYPE_ACCELERATION_STRUCTURE_SIZE_KHR ||
           type == VK_QUERY_TYPE_ACCELERATION_STRUCTURE_COMPACTED_SIZE_NV ||
           type == VK_QUERY_TYPE_MICROMAP_SERIALIZATION_SIZE_EXT;
}

/* Results as vkGetQueryPoolResults lays them out. */
struct results {
    const char *data;
    VkDeviceSize size, stride;
    VkQueryResultFlags flags;
    bool all_available;
};

static uint64_t read_word(const struct results *results, const char *at, uint32_t word)
{
    if (results->flags & VK_QUERY_RESULT_64_BIT) {
        uint64_t value;
        memcpy(&value, at + word * sizeof(value), sizeof(value));
        return value;
    }
    uint32_t value;
    memcpy(&value, at + word * sizeof(value), sizeof(value));
    return value;
}

static bool has_result(const struct results *results, uint32_t i)
{
    VkDeviceSize word =
        results->flags & VK_QUERY_RESULT_64_BIT ? sizeof(uint64_t) : sizeof(uint32_t);
    VkDeviceSize size = results->flags & VK_QUERY_RESULT_WITH_AVAILABILITY_BIT ? 2 * word : word;
    return size <= results->size && (!i || results->stride <= (results->size - size) / i) &&
           readable(readable_cache_of_thread(), results->data + i * results->stride, size);
}

/* Returns 0 if the query was, or may have been, unavailable: without an availability word, partial
 * results look like complete ones. */
static VkDeviceSize read_result(const struct results *results, uint32_t i)
{
    const char *at = results->data + i * results->stride;
    bool has_availability = results->flags & VK_QUERY_RESULT_WITH_AVAILABILITY_BIT;
    bool available = has_availability ? read_word(results, at, 1) != 0 : results->all_available;
    return available ? read_word(results, at, 0) : 0;
}

/* Returns whether it understands all results. */
static bool add_answers(struct journal *journal, VkQueryType type, uint64_t first_id,
                        uint32_t count, const struct results *results)
{
    uint32_t understood = 0;
    for (uint32_t i = 0; i < count && has_result(results, i); i++) {
        const uint64_t answer = read_result(results, i);
        if (answer)
            journal_add_answer(journal, (struct journal_entry){.info = (uint32_t)type,
                                                               .src_id = first_id + i,
                                                               .number = answer});
        understood += answer != 0;
    }
    return understood == count;
}

/* The application may read the results where the layer does not. */
void note_copied_results(struct layer_device *device, VkQueryPool handle)
{
    struct query_pool pool;
    if (query_pools_find(device->query_pools, handle, &pool) && is_size_to_track(pool.type))
        device->sizes_may_be_unknown = true;
}

struct journal *begin_query_reading(struct layer_device *device, VkQueryPool handle)
{
    struct query_pool pool;
    return query_pools_find(device->query_pools, handle, &pool) && is_size_to_track(pool.type)
               ? begin_reading(device)
               : NULL;
}

/* Whether the application may have learned that a query is available. */
static bool may_have_read(uint32_t count, VkQueryResultFlags flags, VkResult result)
{
    return result == VK_SUCCESS ||
           (result == VK_NOT_READY && (count > 1 || flags & VK_QUERY_RESULT_PARTIAL_BIT));
}

static void observe_queries(const struct layer_device *device, VkQueryPool pool, uint32_t first,
                            uint32_t count)
{
    struct execution_clock clock;
    const bool is_known = query_writes_find(device->query_writes, pool, first, count, &clock);
    execution_order_note_results(device->order, is_known ? &clock : NULL);
}

/* Looks the pool up again: it may not be destroyed during the call. */
void note_query_results(struct layer_device *device, struct journal *reading, VkQueryPool handle,
                        uint32_t first, uint32_t count, size_t size, void *data,
                        VkDeviceSize stride, VkQueryResultFlags flags, VkResult result)
{
    struct query_pool pool;
    input_checks_deliver(device->input_checks);
    if (may_have_read(count, flags, result))
        observe_queries(device, handle, first, count);
    if (!reading)
        return;
    bool partial = (flags & VK_QUERY_RESULT_PARTIAL_BIT) && !(flags & VK_QUERY_RESULT_WAIT_BIT);
    const struct results results = {
        .data = data,
        .size = size,
        .stride = stride,
        .flags = flags,
        .all_available = result == VK_SUCCESS && !partial,
    };
    if (result >= VK_SUCCESS && query_pools_find(device->query_pools, handle, &pool) &&
        !add_answers(reading, pool.type, pool.first_id + first,
                     query_pool_clamp(&pool, first, count), &results) &&
        (result == VK_SUCCESS || partial))
        device->sizes_may_be_unknown = true;
    end_reading(device, reading);
}

struct journal *begin_size_reading(struct layer_device *device, VkQueryType type)
{
    return device->order && is_size_to_track(type) ? begin_reading(device) : NULL;
}

void note_sizes(struct layer_device *device, struct journal *reading, uint32_t count,
                const VkAccelerationStructureKHR *accels, VkQueryType type, size_t size, void *data,
                size_t stride, VkResult result)
{
    const struct results results = {.data = data,
                                    .size = size,
                                    .stride = stride,
                                    .flags = VK_QUERY_RESULT_64_BIT,
                                    .all_available = result == VK_SUCCESS};
    for (uint32_t i = 0; reading && i < count && has_result(&results, i); i++)
        journal_add_answer(reading,
                           (struct journal_entry){.info = (uint32_t)type,
                                                  .src = handle_number(accels[i]),
                                                  .src_id = layer_accel_id(device, accels[i]),
                                                  .number = read_result(&results, i)});
    if (reading)
        end_reading(device, reading);
}
