/* SPDX-License-Identifier: Apache-2.0 */
#include "layer/hazards/executed/host_writes.h"

#include <stdlib.h>
#include <string.h>
#define XXH_INLINE_ALL
#include <xxhash.h>

#include "src/base/array.h"
#include "src/base/unknown.h"
#include "src/report/hazard_message.h"
#include "src/state/commands/journal.h"

/* Limits of what is compared: the first bytes of an input, the first inputs of a batch, and the
 * batches that are kept at a time. */
enum { BYTES_COMPARED = 1 << 20, INPUTS_COMPARED = 256, BATCHES_COMPARED = 64 };

/* So many vertices of a geometry with indices are compared. */
enum { VERTICES_COMPARED = 16 };

struct host_writes {
    struct layer_device *device;
    struct batch_list *batches;
    atomic_uint kept;       /* batches */
    atomic_bool is_stopped; /* the device may write what the host writes */
};

/* An input of a build, with a hash of its data from when the batch ran. */
struct submitted_input {
    const struct journal *journal;
    const struct hazard_entry *command, *access;
    uint64_t hash;
    uint32_t vertex_count, vertices[VERTICES_COMPARED]; /* of vertices by indices: indices */
};

/* The slot of a batch. Whoever has a reference to the batch may read it: it is freed when the batch
 * retires. */
struct submitted_inputs {
    uint64_t untracked; /* see execution_order_find_observed(), before the submission */
    atomic_bool is_reported;
    struct unknown unknown; /* memory ran out, or the order is unknown */
    uint32_t count, capacity;
    struct submitted_input *items;
};

/* ---- inputs */

/* Shows bytes of what the access reads. Returns false if they are out of reach, or if the device
 * may write them. */
static bool visit_bytes(const struct host_writes *host_writes, const struct hazard_entry *access,
                        uint64_t begin, uint64_t size,
                        void (*visit)(void *user, const void *bytes, uint64_t size), void *user)
{
    const struct mapped_bytes wanted = {.buffer = (VkBuffer)(uintptr_t)access->object,
                                        .memory_id = access->bytes.memory,
                                        .begin = begin,
                                        .size = size};
    return resources_visit_mapped(host_writes->device->resources, &wanted, visit, user);
}

static void add_to_hash(void *user, const void *bytes, uint64_t size)
{
    uint64_t *hash = user;
    *hash = XXH3_64bits_withSeed(bytes, size, *hash);
}

static bool hash_vertices(const struct host_writes *host_writes,
                          const struct submitted_input *input, uint64_t *hash)
{
    const struct hazard_entry *access = input->access;
    bool is_known = input->vertex_count != 0;
    for (uint32_t i = 0; i < input->vertex_count && is_known; i++) {
        const uint64_t offset = (uint64_t)input->vertices[i] * access->vertex_stride;
        is_known = offset + access->vertex_size <= access->bytes.end - access->bytes.begin &&
                   visit_bytes(host_writes, access, access->bytes.begin + offset,
                               access->vertex_size, add_to_hash, hash);
    }
    return is_known;
}

/* Returns false if not all is known. */
static bool hash_input(const struct host_writes *host_writes, const struct submitted_input *input,
                       uint64_t *hash)
{
    const struct hazard_bytes *bytes = &input->access->bytes;
    const uint64_t size = bytes->end - bytes->begin;
    *hash = 0;
    if (journal_is_hazard_indexed(input->access))
        return hash_vertices(host_writes, input, hash);
    return visit_bytes(host_writes, input->access, bytes->begin,
                       size < BYTES_COMPARED ? size : BYTES_COMPARED, add_to_hash, hash);
}

/* What a build of the device reads, with known bytes. */
static bool is_input(const struct hazard_entry *access)
{
    return access->access == ACCESS_BUILD_SHADER_READ &&
           access->object_type == VK_OBJECT_TYPE_BUFFER && access->object && access->bytes.memory;
}

static void add_input(const struct host_writes *host_writes, struct submitted_inputs *inputs,
                      struct submitted_input input)
{
    if (inputs->count == INPUTS_COMPARED || !hash_input(host_writes, &input, &input.hash))
        return;
    if (ARRAY_HAS_ROOM(inputs->items, inputs->count, inputs->capacity))
        inputs->items[inputs->count++] = input;
    else
        unknown_set(&inputs->unknown, UNKNOWN_HOST_WRITES);
}

struct index_reading {
    struct submitted_input *input;
    uint32_t index_size;
};

/* Takes some vertices, the first and the last one among them. */
static void choose_vertices(void *user, const void *bytes, uint64_t size)
{
    const struct index_reading *reading = user;
    const uint64_t count = size / reading->index_size;
    const uint64_t chosen = count < VERTICES_COMPARED ? count : VERTICES_COMPARED;
    for (uint64_t i = 0; i < chosen; i++) {
        const uint64_t at = chosen > 1 ? i * (count - 1) / (chosen - 1) : 0;
        uint32_t index = 0; /* as VK_INDEX_TYPE_UINT8 and UINT16 on little-endian processors */
        memcpy(&index, (const char *)bytes + at * reading->index_size, reading->index_size);
        reading->input->vertices[reading->input->vertex_count++] = index;
    }
}

/* Adds the vertices that indices in mapped memory name, if their type is known. */
static void add_vertices(const struct host_writes *host_writes, struct submitted_inputs *inputs,
                         struct submitted_input vertices, const struct hazard_entry *indices)
{
    const struct hazard_bytes *bytes = &indices->bytes;
    if (indices->index_size && vertices.access->info == indices->info &&
        vertices.access->geometry == indices->geometry &&
        visit_bytes(host_writes, indices, bytes->begin, bytes->end - bytes->begin, choose_vertices,
                    &(struct index_reading){&vertices, indices->index_size}))
        add_input(host_writes, inputs, vertices);
}

/* A walk over a journal that adds inputs. */
struct input_search {
    const struct host_writes *host_writes;
    struct submitted_inputs *inputs;
    const struct hazard_entry *command; /* that builds, and whose accesses follow; or NULL */
    const struct hazard_entry *indexed; /* its last vertices that are read by indices */
};

static void begin_command(struct journal_walk *walk, const struct hazard_entry *item)
{
    struct input_search *search = walk->user;
    search->command = item->build_count ? item : NULL;
    search->indexed = NULL;
}

static void note_indexed(struct journal_walk *walk, const struct hazard_entry *item)
{
    struct input_search *search = walk->user;
    if (search->command && is_input(item))
        search->indexed = item;
}

/* The vertices of a geometry come before its indices. */
static void add_access(struct journal_walk *walk, const struct hazard_entry *item)
{
    const struct input_search *search = walk->user;
    struct submitted_input input = {
        .journal = walk->journal, .command = search->command, .access = item};
    if (!search->command || !is_input(item))
        return;
    if (item->role == HAZARD_INDICES && search->indexed) {
        input.access = search->indexed;
        add_vertices(search->host_writes, search->inputs, input, item);
        input.access = item;
    }
    add_input(search->host_writes, search->inputs, input);
}

static const struct journal_events adds_inputs = {.hazard_command = begin_command,
                                                  .hazard_access = add_access,
                                                  .hazard_indexed = note_indexed,
                                                  .execute = journal_walk_secondary};

/* ---- batches */

/* Whether a command buffer reads what the host may write, and none waits for an event that the host
 * may set after it has written. */
static bool reads_host_data(const struct order_batch *batch)
{
    bool reads = false, has_events = false;
    for (uint32_t i = 0; i < batch->command_count; i++) {
        const struct journal *journal = batch->commands[i].captured;
        reads |= journal && journal->reads_host_data;
        has_events |= journal && journal->has_events;
    }
    return reads && !has_events;
}

/* Notes what the host has observed so far: the batch may run on another thread later. */
static void begin_inputs(const struct host_writes *host_writes, struct order_batch *batch)
{
    struct execution_clock seen;
    struct submitted_inputs *inputs = calloc(1, sizeof(*inputs));
    batch->slots[USES_HOST_WRITES] = inputs;
    if (inputs)
        unknown_follow(&inputs->unknown, !execution_order_find_observed(host_writes->device->order,
                                                                        &seen, &inputs->untracked));
}

static void host_writes_submit(void *user, struct order_batch *batch)
{
    struct host_writes *host_writes = user;
    if (reads_host_data(batch) && !atomic_load(&host_writes->is_stopped))
        begin_inputs(host_writes, batch);
}

static bool is_compared(const struct host_writes *host_writes, const struct order_batch *batch)
{
    return batch->slots[USES_HOST_WRITES] && batch->predecessors_known && batch->is_replayed &&
           !batch->signals_foreign_object && atomic_load(&host_writes->kept) < BATCHES_COMPARED;
}

static void host_writes_run(void *user, struct order_batch *batch)
{
    struct host_writes *host_writes = user;
    struct submitted_inputs *inputs = batch->slots[USES_HOST_WRITES];
    struct input_search search = {.host_writes = host_writes, .inputs = inputs};
    if (!is_compared(host_writes, batch))
        return;
    for (uint32_t i = 0; i < batch->command_count; i++)
        if (batch->commands[i].captured)
            journal_walk(batch->commands[i].captured, &adds_inputs, &search);
    if (!inputs->count || unknown_is_set(&inputs->unknown))
        return;
    batch->commands[0].is_used[USES_HOST_WRITES] = true; /* one step of a walk */
    atomic_fetch_add(&host_writes->kept, 1);
    order_batch_keep(batch, USES_HOST_WRITES, inputs);
}

/* Forgets all batches for which `ends` returns true. */
static void forget_those(struct host_writes *host_writes,
                         bool (*ends)(const void *user, const struct order_batch *batch),
                         const void *user)
{
    for (struct order_batch *batch;
         (batch = batch_list_take(host_writes->batches, IN_EXECUTION_ORDER, USES_HOST_WRITES, ends,
                                  user));) {
        atomic_fetch_sub(&host_writes->kept, 1);
        order_batch_release(batch);
    }
}

static void host_writes_retire(void *user, struct order_batch *batch)
{
    struct submitted_inputs *inputs = batch->slots[USES_HOST_WRITES];
    (void)user;
    if (inputs)
        free(inputs->items);
    free(inputs);
    batch->slots[USES_HOST_WRITES] = NULL;
}

static bool batch_is_over(const void *user, const struct order_batch *batch)
{
    return execution_clock_has(user, batch->timestamp);
}

static void host_writes_deliver(void *user)
{
    struct host_writes *host_writes = user;
    struct execution_clock seen;
    if (!atomic_load(&host_writes->kept))
        return;
    execution_order_host_clock(host_writes->device->order, &seen);
    forget_those(host_writes, batch_is_over, &seen);
}

void host_writes_forget(struct host_writes *host_writes)
{
    if (host_writes && atomic_load(&host_writes->kept))
        forget_those(host_writes, NULL, NULL);
}

void host_writes_stop(struct host_writes *host_writes)
{
    if (!host_writes)
        return;
    atomic_store(&host_writes->is_stopped, true);
    host_writes_forget(host_writes);
}

/* ---- comparisons */

static bool is_changed(const struct host_writes *host_writes, const struct submitted_input *input)
{
    uint64_t now;
    return hash_input(host_writes, input, &now) && now != input->hash;
}

/* The data were read before this, so they were written before the host observed anything else. */
static bool is_pending(const struct host_writes *host_writes, const struct order_batch *batch,
                       uint64_t untracked_then)
{
    struct execution_clock seen;
    uint64_t untracked;
    return execution_order_find_observed(host_writes->device->order, &seen, &untracked) &&
           untracked == untracked_then && !execution_clock_has(&seen, batch->timestamp) &&
           !atomic_load(&host_writes->is_stopped);
}

/* From the first to the last vertex that was compared; else all bytes of the input. */
static struct hazard_bytes bytes_of(const struct submitted_input *input)
{
    const struct hazard_entry *access = input->access;
    uint64_t first = UINT32_MAX, last = 0;
    if (!journal_is_hazard_indexed(access))
        return access->bytes;
    for (uint32_t i = 0; i < input->vertex_count; i++) {
        first = input->vertices[i] < first ? input->vertices[i] : first;
        last = input->vertices[i] > last ? input->vertices[i] : last;
    }
    return (struct hazard_bytes){
        access->bytes.memory, access->bytes.begin + first * access->vertex_stride,
        access->bytes.begin + last * access->vertex_stride + access->vertex_size};
}

static void report_host_write(const struct host_writes *host_writes,
                              const struct order_batch *batch, const struct submitted_input *input,
                              uint32_t more)
{
    const struct layer_device *device = host_writes->device;
    const struct hazard_entry *access = input->access;
    const struct hazard_report hazard = {
        .hazard = {.type = READ_RACING_HOST, .bytes = bytes_of(input)},
        .write = ACCESS_KINDS,
        .later = {.command = input->command->command,
                  .is_build = true,
                  .role = (enum hazard_role)access->role,
                  .kind = (enum access_kind)access->access,
                  .info = access->info,
                  .geometry = access->geometry,
                  .type = access->object_type,
                  .object = access->object,
                  .origin = layer_origin_of(device, &batch->origin, input->journal,
                                            input->command->first_build, input->command->origin)},
        .more = more,
        .timeout = execution_order_find_timeout(device->order, batch->timed_out_waits, UINT64_MAX),
    };
    if (reporter_wants_hazard(device->instance->reporter, HAZARD_ID_HOST_WRITE))
        reporter_send_hazard(device->instance->reporter, &hazard);
}

/* Reports the first input that has changed, and how many others of its command have. */
static void compare_inputs(const struct host_writes *host_writes, const struct order_batch *batch,
                           struct submitted_inputs *inputs)
{
    const struct submitted_input *first = NULL;
    uint32_t more = 0;
    for (uint32_t i = 0; i < inputs->count; i++) {
        const struct submitted_input *input = &inputs->items[i];
        if ((first && input->command != first->command) || !is_changed(host_writes, input))
            continue;
        more += first != NULL;
        first = first ? first : input;
    }
    if (first && is_pending(host_writes, batch, inputs->untracked) &&
        !atomic_exchange(&inputs->is_reported, true))
        report_host_write(host_writes, batch, first, more);
}

void host_writes_look(struct host_writes *host_writes)
{
    if (!host_writes || !atomic_load(&host_writes->kept))
        return;
    struct batch_cursor at = {
        .list = host_writes->batches, .sequence = IN_EXECUTION_ORDER, .use = USES_HOST_WRITES};
    while (batch_cursor_step(&at)) {
        struct submitted_inputs *inputs = at.batch->slots[USES_HOST_WRITES];
        if (!atomic_load(&inputs->is_reported))
            compare_inputs(host_writes, at.batch, inputs);
    }
}

/* ---- creation */

VkResult host_writes_create(struct layer_device *device)
{
    if (!device->finds_hazards)
        return VK_SUCCESS;
    struct host_writes *host_writes = calloc(1, sizeof(*host_writes));
    if (!host_writes)
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    host_writes->device = device;
    host_writes->batches = execution_order_batches(device->order);
    host_writes->is_stopped = device->facts.newer_than_registry;
    device->host_writes = host_writes;
    return VK_SUCCESS;
}

void host_writes_destroy(struct host_writes *host_writes)
{
    host_writes_forget(host_writes);
    free(host_writes);
}

struct batch_consumer host_writes_consumer(struct host_writes *host_writes)
{
    return (struct batch_consumer){.user = host_writes,
                                   .submit = host_writes_submit,
                                   .run = host_writes_run,
                                   .retire = host_writes_retire,
                                   .deliver = host_writes_deliver};
}
