/* SPDX-License-Identifier: Apache-2.0 */
/* Makes the records of a batch from its journals. What a journal does not say, such as the memory
 * of a structure, is looked up when the batch executes: the structure must exist then. */
#include "layer/execution/build_records.h"

#include "layer/layer.h"
#include "src/check/content/content.h"
#include "src/report/log/lines.h"
#include "src/state/resources/nv_shape.h"

struct writer {
    const struct layer_device *device;
    const struct record_sink *sink;
    struct log_record record; /* with the members that are the same for the whole batch */
    const struct journal_entry *figures; /* of the next build; or NULL */
};

/* ---- structures */

static void describe_accel(const struct writer *writer, const struct journal_entry *entry,
                           struct log_record *record)
{
    struct accel_facts accel;
    record->object_type = VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR;
    resources_look_up_accel(writer->device->resources,
                            (VkAccelerationStructureKHR)(uintptr_t)entry->dst, &accel);
    if (accel.id != entry->dst_id || !accel.details_known)
        return;
    record->type = record_type_name(accel.type);
    record->size = accel.size;
    record->memory = accel.memory;
    record->memory_offset = accel.begin;
}

static void describe_nv(const struct writer *writer, const struct journal_entry *entry,
                        struct log_record *record)
{
    struct nv_accel_facts accel;
    record->object_type = VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_NV;
    resources_look_up_nv_accel(writer->device->resources,
                               (VkAccelerationStructureNV)(uintptr_t)entry->dst, &accel);
    if (accel.id == entry->dst_id && accel.created)
        record->type = record_type_name(accel.created->type);
    nv_shape_release(accel.created);
    if (accel.id != entry->dst_id)
        return;
    if (accel.sizes.known) {
        record->size = accel.sizes.object;
        record->scratch_size = journal_is_update(entry) ? accel.sizes.update_scratch
                               : journal_is_copy(entry) ? 0
                                                        : accel.sizes.build_scratch;
    }
    record->memory = accel.span.memory;
    record->memory_offset = accel.span.begin;
}

static struct log_record begin_record(const struct journal_walk *walk,
                                      const struct journal_entry *entry, enum record_kind kind,
                                      const char *mode)
{
    const struct writer *writer = walk->user;
    struct log_record record = writer->record;
    record.command_buffer = walk->journal->command_buffer;
    record.kind = kind;
    record.mode = mode;
    record.dst = entry->dst;
    record.src = entry->src;
    return record;
}

static struct log_record describe_entry(const struct journal_walk *walk,
                                        const struct journal_entry *entry, enum record_kind kind,
                                        const char *mode)
{
    const struct writer *writer = walk->user;
    struct log_record record = begin_record(walk, entry, kind, mode);
    record.type = "unknown";
    if (journal_entry_type(entry) == VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_NV)
        describe_nv(writer, entry, &record);
    else
        describe_accel(writer, entry, &record);
    return record;
}

/* ---- entries */

static void add_to_record(const struct journal_walk *walk, const struct journal_entry *entry,
                          const struct log_record *record)
{
    const struct writer *writer = walk->user;
    writer->sink->add(writer->sink->user, walk->journal, entry, record);
}

static void note_figures(struct journal_walk *walk, const struct journal_entry *entry)
{
    struct writer *writer = walk->user;
    writer->figures = entry;
}

static void add_build(struct journal_walk *walk, const struct journal_entry *entry)
{
    struct writer *writer = walk->user;
    struct log_record record =
        describe_entry(walk, entry, RECORD_BUILD, journal_is_update(entry) ? "update" : "build");
    record.has_position = true;
    record.position = entry->built.position;
    if (entry->built.state == BUILT_BEFORE) {
        record.type = record_type_name(entry->built.type);
        record.has_geometries = true;
        record.geometries = entry->built.geometry_count;
        record.flags = entry->built.flags;
    }
    if (writer->figures) {
        record.has_primitives = writer->figures->info;
        record.primitives = writer->figures->number;
        if (writer->figures->dst)
            record.scratch_size = writer->figures->dst;
    }
    writer->figures = NULL;
    add_to_record(walk, entry, &record);
}

static void add_copy(struct journal_walk *walk, const struct journal_entry *entry)
{
    const struct log_record record = describe_entry(
        walk, entry, RECORD_COPY, journal_entry_compacts(entry) ? "compact" : "clone");
    add_to_record(walk, entry, &record);
}

/* A deserialization, or a write of a VkMicromapEXT. */
static void add_fill(struct journal_walk *walk, const struct journal_entry *entry)
{
    static const char *const modes[] = {
        [FILL_READS_ACCEL] = "deserialize",    [FILL_BUILDS_MICROMAP] = "build",
        [FILL_CLONES_MICROMAP] = "clone",      [FILL_COMPACTS_MICROMAP] = "compact",
        [FILL_READS_MICROMAP] = "deserialize",
    };
    const enum record_kind kind = entry->info == FILL_BUILDS_MICROMAP ? RECORD_BUILD : RECORD_COPY;
    struct log_record record;
    if (entry->info == FILL_READS_ACCEL) {
        record = describe_entry(walk, entry, kind, modes[entry->info]);
    } else {
        record = begin_record(walk, entry, kind, modes[entry->info]);
        record.type = "micromap";
        record.object_type = VK_OBJECT_TYPE_MICROMAP_EXT;
    }
    add_to_record(walk, entry, &record);
}

/* A build that writes no structure that is known. */
static void add_inputs(struct journal_walk *walk, const struct journal_entry *entry)
{
    struct log_record record = begin_record(walk, entry, RECORD_BUILD, "build");
    record.type = "unknown";
    record.has_position = true;
    record.position = entry->built.position;
    add_to_record(walk, entry, &record);
}

static void add_read(struct journal_walk *walk, const struct journal_entry *entry)
{
    struct log_record record = begin_record(walk, entry, RECORD_QUERY, NULL);
    record.dst = 0; /* the query pool */
    record.object_type = journal_entry_type(entry);
    if (journal_entry_is_query(entry))
        add_to_record(walk, entry, &record);
}

#define RECORDS                                                                                    \
    .primitives = note_figures, ON_BUILDS(add_build), .copy = add_copy, .fill = add_fill,          \
    .execute = journal_walk_secondary
static const struct journal_events records = {RECORDS};
static const struct journal_events captured_records = {RECORDS, .read = add_read,
                                                       .inputs = add_inputs};

/* ---- batches */

static void add_submission(const struct layer_device *device, const struct order_batch *batch)
{
    reporter_record(device->instance->reporter, &(struct log_record){
                                                    .kind = RECORD_SUBMISSION,
                                                    .device = device->handle,
                                                    .submission = batch->origin,
                                                    .commands = batch->commands,
                                                    .command_count = batch->command_count,
                                                });
}

/* Sparse bindings are in the order, too. */
static bool is_sparse_binding(const struct order_batch *batch)
{
    const struct journal *journal = batch->command_count ? batch->commands[0].captured : NULL;
    return journal && journal->binds;
}

/* Work of the host is recorded when it has ended. */
static bool is_recorded(const struct order_batch *batch)
{
    return batch->is_replayed && batch->work != WORK_BEGINS && batch->work != WORK_FAILS &&
           batch->work != WORK_SYNC && !is_sparse_binding(batch);
}

static void walk_command(const struct layer_device *device, const struct order_batch *batch,
                         uint32_t command, const struct record_sink *sink,
                         const struct journal_events *events)
{
    struct writer writer = {
        .device = device,
        .sink = sink,
        .record = {.device = device->handle, .submission = batch->origin, .names = device->names}};
    if (batch->commands[command].captured)
        journal_walk(batch->commands[command].captured, events, &writer);
}

void build_records_walk(const struct layer_device *device, const struct order_batch *batch,
                        uint32_t command, const struct record_sink *sink)
{
    if (is_recorded(batch))
        walk_command(device, batch, command, sink, &captured_records);
}

static void add_to_log(void *user, const struct journal *journal, const struct journal_entry *entry,
                       const struct log_record *record)
{
    const struct layer_device *device = user;
    (void)journal;
    (void)entry;
    reporter_record(device->instance->reporter, record);
}

static void build_records_run(void *user, struct order_batch *batch)
{
    const struct layer_device *device = user;
    const struct record_sink sink = {add_to_log, user};
    if (!is_recorded(batch))
        return;
    if (batch->work == WORK_OF_QUEUE)
        add_submission(device, batch);
    for (uint32_t i = 0; i < batch->command_count; i++)
        walk_command(device, batch, i, &sink, &records);
}

struct batch_consumer build_records_consumer(struct layer_device *device)
{
    return (struct batch_consumer){.user = device, .run = build_records_run};
}

void build_records_add_size(const struct layer_device *device, VkAccelerationStructureKHR structure,
                            VkDeviceSize compacted_size)
{
    reporter_record(device->instance->reporter,
                    &(struct log_record){
                        .kind = RECORD_SIZE,
                        .device = device->handle,
                        .names = device->names,
                        .object_type = VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR,
                        .dst = handle_number(structure),
                        .compacted_size = compacted_size,
                    });
}

void build_records_add_destroyed(const struct layer_device *device, VkObjectType type,
                                 uint64_t structure)
{
    if (device->records_builds && structure)
        reporter_record(device->instance->reporter, &(struct log_record){
                                                        .kind = RECORD_DESTROYED,
                                                        .device = device->handle,
                                                        .names = device->names,
                                                        .object_type = type,
                                                        .dst = structure,
                                                    });
}

/* More do not fit into a line for certain. */
enum { REFERENCES_SHOWN = 128 };

void build_records_add_instances(const struct recorded_instances *instances,
                                 const struct instance_uses *uses)
{
    const struct layer_device *device = instances->device;
    struct log_reference references[REFERENCES_SHOWN];
    struct log_record record = {
        .kind = RECORD_INSTANCES,
        .device = device->handle,
        .submission = instances->batch->origin,
        .names = device->names,
        .object_type = VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR,
        .dst = handle_number(instances->dst),
        .command_buffer = instances->command_buffer,
        .position = instances->position,
        .references = references,
    };
    for (uint32_t i = 0; i < uses->count; i++) {
        const struct instance_use *use = &uses->items[i];
        if (!use->count)
            continue;
        if (record.reference_total++ < REFERENCES_SHOWN)
            references[record.reference_count++] =
                (struct log_reference){handle_number(use->referenced.handle), use->count};
    }
    if (record.reference_total)
        reporter_record(device->instance->reporter, &record);
}
