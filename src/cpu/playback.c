/* SPDX-License-Identifier: Apache-2.0 */
/* Plays the journals of executions, without waiting for the device; and keeps results for buffers.
 */
#include "src/cpu/playback.h"

#include <stdlib.h>

#include "src/cpu/trees/tree.h"
#include "src/cpu/trees/trees.h"
#include "src/state/builds/structures.h"

/* A result that is written to a buffer when its submission is complete: a serialized tree, or
 * queries. */
struct result {
    struct result *next;
    struct ticket *ticket;
    struct timestamp timestamp;
    struct buffer_target target;
    struct cpu_tree *tree; /* to be serialized, or NULL */
    uint64_t pool;         /* a copy of the queries, or 0; the members below are for queries */
    uint32_t count;
    VkDeviceSize stride;
    VkQueryResultFlags flags;
};

struct cpu_playback {
    struct cpu_device *device;
    struct resources *resources;
    atomic_uint failed;       /* see cpu_playback_take_failed */
    pthread_mutex_t playing;  /* held while an execution is played, so executions don't mix */
    pthread_mutex_t delivery; /* held while results are written; never held with `playing` */
    pthread_mutex_t lock;     /* guards the list of results; taken last */
    struct result *results, **results_last;
};

VkResult cpu_playback_create(struct cpu_device *device, struct resources *resources,
                             struct cpu_playback **playback)
{
    struct cpu_playback *state = calloc(1, sizeof(*state));
    *playback = state;
    if (!state)
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    state->device = device;
    state->resources = resources;
    state->results_last = &state->results;
    pthread_mutex_init(&state->playing, NULL);
    pthread_mutex_init(&state->delivery, NULL);
    pthread_mutex_init(&state->lock, NULL);
    return VK_SUCCESS;
}

static void free_result(struct cpu_playback *playback, struct result *result)
{
    if (result->pool)
        cpu_query_pools_remove(playback->device->query_pools, result->pool);
    ticket_release(result->ticket);
    cpu_tree_release(result->tree);
    free(result);
}

void cpu_playback_destroy(struct cpu_playback *playback)
{
    if (!playback)
        return;
    while (playback->results) {
        struct result *result = playback->results;
        playback->results = result->next;
        free_result(playback, result);
    }
    pthread_mutex_destroy(&playback->playing);
    pthread_mutex_destroy(&playback->delivery);
    pthread_mutex_destroy(&playback->lock);
    free(playback);
}

/* ---- entries */

static void set_tree(struct cpu_playback *playback, uint64_t structure, struct cpu_tree *tree)
{
    cpu_structures_set_tree(playback->device->structures, structure, tree);
}

static struct cpu_tree *tree_of(struct cpu_playback *playback, uint64_t structure)
{
    return cpu_structures_tree(playback->device->structures, structure);
}

/* What a command writes: the structure `dst`, from `src` if it has one. */
struct write {
    uint64_t dst, src;
    bool compacts;
    const struct recorded_build *build; /* of a build */
    const struct snapshot *serialized;  /* of CPU_DESERIALIZE */
};

/* Returns the new tree of a structure of `size_max` bytes. Takes over the reference of `source`.
 * Returns NULL if memory runs out. */
static struct cpu_tree *make_tree(struct cpu_playback *playback, struct execution *execution,
                                  const struct write *write, struct cpu_tree *source,
                                  uint64_t size_max)
{
    struct cpu_device *device = playback->device;
    if (write->build)
        return cpu_lazy_build(device, execution, write->build, source, size_max);
    if (write->serialized)
        return cpu_lazy_deserialization(device, execution, write->serialized, size_max);
    if (write->compacts)
        return cpu_lazy_compaction(device, execution, source, size_max);
    return source; /* a clone shares it */
}

/* What an execution plays: `user` of the walk over its entries. */
struct playing {
    struct cpu_playback *playback;
    struct execution *execution;
    struct timestamp timestamp;
    uint32_t child; /* index of the next execution of a secondary */
};

static void change_structure(const struct playing *playing, const struct write *write)
{
    struct cpu_playback *playback = playing->playback;
    bool has_source =
        write->build ? build_is_update(&write->build->parameters.info) : !write->serialized;
    struct cpu_tree *source = has_source ? tree_of(playback, write->src) : NULL, *tree = NULL;
    struct cpu_structure_info info;
    if (!cpu_structures_find(playback->device->structures, write->dst, &info)) {
        cpu_tree_release(source);
        return;
    }
    if (source || !has_source) {
        tree = make_tree(playback, playing->execution, write, source, info.size);
        if (!tree)
            atomic_fetch_add(&playback->failed, 1);
    }
    set_tree(playback, write->dst, tree);
}

static void play_build(struct journal_walk *walk, const struct journal_entry *entry)
{
    const struct recorded_build *build = journal_copies(entry);
    if (!build)
        return;
    const VkAccelerationStructureBuildGeometryInfoKHR *info = &build->parameters.info;
    change_structure(walk->user, &(struct write){.dst = (uint64_t)info->dstAccelerationStructure,
                                                 .src = (uint64_t)info->srcAccelerationStructure,
                                                 .build = build});
}

static void play_copy(struct journal_walk *walk, const struct journal_entry *entry)
{
    change_structure(walk->user,
                     &(struct write){entry->dst, entry->src, .compacts = entry->read.compacts});
}

static void play_own_copy(struct journal_walk *walk, const struct recorded_command *copy)
{
    change_structure(walk->user,
                     &(struct write){copy->structure, copy->src, .compacts = copy->compacts});
}

static void play_deserialization(struct journal_walk *walk, const struct recorded_command *command)
{
    change_structure(
        walk->user, &(struct write){.dst = command->structure, .serialized = &command->serialized});
}

static void play_query(struct journal_walk *walk, const struct recorded_command *command)
{
    const struct playing *playing = walk->user;
    cpu_query_pools_write(playing->playback->device->query_pools, command->pool, command->first,
                          tree_of(playing->playback, command->structure),
                          playing->execution->ticket);
}

static void play_resets(struct journal_walk *walk, const struct recorded_command *command)
{
    const struct playing *playing = walk->user;
    cpu_query_pools_reset(playing->playback->device->query_pools, command->pool, command->first,
                          command->count);
}

/* The buffer stays unchanged if memory runs out or the address is invalid. */
static void add_result(struct journal_walk *walk, const struct recorded_command *command)
{
    const struct playing *playing = walk->user;
    struct cpu_playback *playback = playing->playback;
    struct result *result = calloc(1, sizeof(*result));
    if (!result) {
        atomic_fetch_add(&playback->failed, 1);
        return;
    }
    VkResult copied = VK_SUCCESS;
    result->ticket = ticket_share(playing->execution->ticket);
    result->timestamp = playing->timestamp;
    if (journal_is_cpu_serialize(command)) {
        buffer_target_find(playback->resources, command->address, &result->target);
        result->tree = tree_of(playback, command->structure);
    } else {
        result->target = command->target;
        result->count = command->count;
        result->stride = command->stride;
        result->flags = command->flags;
        copied = cpu_query_pools_copy(playback->device->query_pools, command->pool, command->first,
                                      &result->count, &result->pool);
    }
    if (copied != VK_SUCCESS)
        atomic_fetch_add(&playback->failed, 1);
    pthread_mutex_lock(&playback->lock);
    *playback->results_last = result;
    playback->results_last = &result->next;
    pthread_mutex_unlock(&playback->lock);
}

static void play(struct playing playing);

static void play_child(struct journal_walk *walk, const struct journal_entry *entry)
{
    struct playing *playing = walk->user;
    struct execution *child = playing->execution->children[playing->child++];
    (void)entry;
    if (child)
        play((struct playing){playing->playback, child, playing->timestamp, 0});
}

static void play(struct playing playing)
{
    static const struct journal_events plays = {ON_BUILDS(play_build),
                                                .inputs = play_build,
                                                .copy = play_copy,
                                                .execute = play_child,
                                                .cpu_copy = play_own_copy,
                                                .cpu_serialize = add_result,
                                                .cpu_deserialize = play_deserialization,
                                                .cpu_write_query = play_query,
                                                .cpu_reset_queries = play_resets,
                                                .cpu_copy_queries = add_result};
    execution_walk(playing.execution, &plays, &playing);
}

/* ---- executions */

uint32_t cpu_playback_take_failed(struct cpu_playback *playback)
{
    return atomic_exchange(&playback->failed, 0);
}

void cpu_playback_run(struct cpu_playback *playback, struct execution *execution,
                      struct timestamp timestamp)
{
    pthread_mutex_lock(&playback->playing);
    play((struct playing){playback, execution, timestamp, 0});
    pthread_mutex_unlock(&playback->playing);
}

/* ---- results */

/* The functions that write return false if the result is to be written later. */

static bool write_serialized(struct cpu_playback *playback, const struct result *result,
                             const struct buffer_target *target,
                             const struct cpu_delivery *delivery)
{
    const void *tree = cpu_tree_read(result->tree);
    uint64_t size = tree ? bytes_serialized_size(tree) : 0;
    bool is_done = true;
    if (!size || size > target->size)
        return true;
    unsigned char *bytes = malloc(size);
    const VkBufferCopy region = {0, target->offset, size};
    const struct result_bytes written = {result->ticket, target->buffer, bytes, size, &region, 1};
    if (bytes && bytes_serialize(tree, &playback->device->uuids, bytes, size) == BUILDER_OK)
        is_done = delivery->write(delivery->user, &written);
    free(bytes);
    return is_done;
}

/* Sets the region of query `i`, whose value and availability are at `at` in the bytes. Without a
 * value, only the availability is copied. The bytes between queries stay unchanged. Returns the
 * number of regions, 0 or 1. */
static uint32_t add_region(const struct result *result, uint32_t i, bool has_value, uint64_t at,
                           VkBufferCopy *region)
{
    uint64_t width = result->flags & VK_QUERY_RESULT_64_BIT ? 8 : 4;
    uint64_t end = result->flags & VK_QUERY_RESULT_WITH_AVAILABILITY_BIT ? 2 * width : width;
    uint64_t begin = has_value ? 0 : width;
    *region =
        (VkBufferCopy){at + begin, result->target.offset + i * result->stride + begin, end - begin};
    return end > begin;
}

enum { QUERY_BYTES = 16 };

static bool write_queried(struct cpu_playback *playback, const struct result *result,
                          const struct buffer_target *target, const struct cpu_delivery *delivery)
{
    VkQueryResultFlags flags = result->flags & ~(VkQueryResultFlags)VK_QUERY_RESULT_WAIT_BIT;
    VkBufferCopy *regions = malloc(result->count * sizeof(*regions));
    unsigned char *bytes = calloc(result->count, QUERY_BYTES);
    uint32_t count = 0;
    bool is_done = true;
    for (uint32_t i = 0; regions && bytes && i < result->count; i++) {
        uint64_t at = (uint64_t)i * QUERY_BYTES;
        VkResult state = cpu_query_pools_read(playback->device->query_pools, result->pool, i, 1,
                                              QUERY_BYTES, bytes + at, 0, flags);
        bool has_value = state == VK_SUCCESS || (flags & VK_QUERY_RESULT_PARTIAL_BIT);
        count += add_region(result, i, has_value, at, &regions[count]);
    }
    const struct result_bytes written = {
        .ticket = result->ticket,
        .buffer = target->buffer,
        .bytes = bytes,
        .size = (uint64_t)result->count * QUERY_BYTES,
        .regions = regions,
        .region_count = count,
    };
    if (count)
        is_done = delivery->write(delivery->user, &written);
    free(regions);
    free(bytes);
    return is_done;
}

/* Whether a result's batch is complete. */
static bool result_is_complete(const struct result *result, const struct cpu_delivery *delivery,
                               VkResult *end)
{
    bool was_seen = execution_clock_has(delivery->seen, result->timestamp);
    return ticket_has_ended(result->ticket, was_seen, end);
}

/* Where a result is written by now; cpu_playback_forget_buffer() changes that. */
static struct buffer_target target_of(struct cpu_playback *playback, const struct result *result)
{
    pthread_mutex_lock(&playback->lock);
    struct buffer_target target = result->target;
    pthread_mutex_unlock(&playback->lock);
    return target;
}

/* Returns whether nothing is left to do for the result. */
static bool deliver_result(struct cpu_playback *playback, const struct result *result,
                           const struct cpu_delivery *delivery)
{
    VkResult end;
    if (!result_is_complete(result, delivery, &end))
        return false;
    const struct buffer_target target = target_of(playback, result);
    if (end != VK_SUCCESS || !target.buffer)
        return true;
    if (result->pool)
        return write_queried(playback, result, &target, delivery);
    return !result->tree || write_serialized(playback, result, &target, delivery);
}

/* The first result behind `after`; NULL: of all. */
static struct result *next_result(struct cpu_playback *playback, const struct result *after)
{
    pthread_mutex_lock(&playback->lock);
    struct result *result = after ? after->next : playback->results;
    pthread_mutex_unlock(&playback->lock);
    return result;
}

static void remove_result(struct cpu_playback *playback, const struct result *result)
{
    pthread_mutex_lock(&playback->lock);
    struct result **link = &playback->results;
    while (*link != result)
        link = &(*link)->next;
    *link = result->next;
    if (playback->results_last == &result->next)
        playback->results_last = link;
    pthread_mutex_unlock(&playback->lock);
}

void cpu_playback_deliver(struct cpu_playback *playback, const struct cpu_delivery *delivery)
{
    pthread_mutex_lock(&playback->delivery);
    for (struct result *result = next_result(playback, NULL), *next; result; result = next) {
        bool is_done = deliver_result(playback, result, delivery);
        next = next_result(playback, result);
        if (!is_done)
            continue;
        remove_result(playback,
                      result); /* for cpu_playback_has_results(): only now it is written */
        free_result(playback, result);
    }
    pthread_mutex_unlock(&playback->delivery);
}

bool cpu_playback_has_results(struct cpu_playback *playback)
{
    return next_result(playback, NULL) != NULL;
}

void cpu_playback_forget_buffer(struct cpu_playback *playback, VkBuffer buffer)
{
    pthread_mutex_lock(&playback->lock);
    for (struct result *result = playback->results; result; result = result->next)
        if (result->target.buffer == buffer)
            result->target.buffer = VK_NULL_HANDLE;
    pthread_mutex_unlock(&playback->lock);
}
