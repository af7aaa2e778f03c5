/* SPDX-License-Identifier: Apache-2.0 */
/* Adds accesses to journals; images and render passes by handle; journals of host commands. */
#include "layer/hazards/recording.h"

#include <stdlib.h>
#include <string.h>

#include "layer/hazards/pipelines.h"
#include "layer/intercepts/intercepts.h"
#include "src/base/handle_table.h"
#include "src/base/reader_lock.h"
#include "src/state/commands/journal.h"
#include "src/state/resources/descriptors.h"

bool hazard_recording_start(struct hazard_recording *recording, VkCommandBuffer handle)
{
    struct layer_device *device = layer_find_build_device(handle);
    if (!device || !device->finds_hazards)
        return false;
    struct command_buffer *command_buffer = layer_find_recording(device, handle);
    if (!command_buffer)
        return false;
    *recording = (struct hazard_recording){
        .device = device, .command_buffer = command_buffer, .journal = command_buffer->journal};
    return true;
}

void hazard_recording_command(struct hazard_recording *recording, const char *name,
                              const struct call_site *site)
{
    const struct command_buffer *command_buffer = recording->command_buffer;
    struct hazard_entry *command = hazard_add(recording->journal, HAZARD_COMMAND);
    recording->command = command;
    if (!command)
        return;
    command->command = name;
    command->origin = journal_note_origin(recording->journal,
                                          command_buffer ? &command_buffer->labels : NULL, site);
}

bool hazard_recording_begin(struct hazard_recording *recording, VkCommandBuffer handle,
                            const char *name)
{
    if (!hazard_recording_start(recording, handle))
        return false;
    hazard_recording_command(recording, name, NULL);
    return true;
}

struct hazard_entry *hazard_recording_add_entry(struct hazard_recording *recording,
                                                enum journal_kind kind,
                                                const struct hazard_use *use)
{
    struct hazard_entry *entry = hazard_add(recording->journal, kind);
    if (!entry)
        return NULL;
    entry->access = (unsigned char)use->kind;
    entry->role = (unsigned char)use->role;
    entry->info = use->info;
    entry->geometry = use->geometry;
    entry->index_size = use->index_size;
    return entry;
}

void hazard_recording_add(struct hazard_recording *recording, const struct hazard_use *use,
                          VkObjectType type, uint64_t object, const struct hazard_bytes *bytes)
{
    if (!bytes->memory && access_is_write(use->kind))
        hazard_recording_add_anywhere(recording, use);
    if (!bytes->memory || bytes->begin >= bytes->end)
        return;
    struct hazard_entry *access = hazard_recording_add_entry(recording, HAZARD_ACCESS, use);
    if (!access)
        return;
    access->object = object;
    access->object_type = type;
    access->bytes = *bytes;
}

void hazard_recording_add_anywhere(struct hazard_recording *recording, const struct hazard_use *use)
{
    hazard_recording_add_entry(recording, HAZARD_ACCESS, use);
}

static inline uint64_t memory_id(const struct hazard_recording *recording, VkDeviceMemory memory)
{
    return hazard_memory_id(recording->journal, recording->device->resources, memory);
}

void hazards_access_buffer(struct hazard_recording *recording, enum access_kind kind,
                           enum hazard_role role, VkBuffer buffer, VkDeviceSize offset,
                           VkDeviceSize size)
{
    const struct hazard_use use = {.kind = kind, .role = role};
    struct memory_bytes all;
    if (!resources_find_buffer_bytes(recording->device->resources, buffer, &all))
        all = (struct memory_bytes){.size = VK_WHOLE_SIZE};
    if (offset >= all.size)
        return;
    VkDeviceSize begin = all.begin + offset;
    const struct hazard_bytes bytes = {all.memory_id, begin,
                                       begin + smaller_of(size, all.size - offset)};
    hazard_recording_add(recording, &use, VK_OBJECT_TYPE_BUFFER, handle_number(buffer), &bytes);
}

void hazard_recording_add_address(struct hazard_recording *recording, const struct hazard_use *use,
                                  const struct address_facts *facts, VkDeviceSize begin,
                                  VkDeviceSize end)
{
    if (facts->status != ADDRESS_IN_BUFFER) {
        hazard_recording_add(recording, use, VK_OBJECT_TYPE_BUFFER, 0, &(struct hazard_bytes){0});
        return;
    }
    const struct hazard_bytes bytes = {memory_id(recording, facts->memory),
                                       facts->begin + smaller_of(begin, facts->bytes_left),
                                       facts->begin + smaller_of(end, facts->bytes_left)};
    hazard_recording_add(recording, use, VK_OBJECT_TYPE_BUFFER, handle_number(facts->buffer),
                         &bytes);
}

void hazard_recording_add_accel(struct hazard_recording *recording, const struct hazard_use *use,
                                const struct accel_facts *facts, VkDeviceSize size)
{
    const struct hazard_bytes bytes = {facts->is_sparse ? 0 : memory_id(recording, facts->memory),
                                       facts->begin, facts->begin + smaller_of(size, facts->size)};
    hazard_recording_add(recording, use, VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR,
                         handle_number(facts->handle), &bytes);
}

void hazard_recording_add_nv(struct hazard_recording *recording, const struct hazard_use *use,
                             const struct nv_accel_facts *facts)
{
    const struct hazard_bytes bytes = {memory_id(recording, facts->span.memory), facts->span.begin,
                                       facts->span.end};
    hazard_recording_add(recording, use, VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_NV,
                         handle_number(facts->handle), &bytes);
}

/* ---- images and render passes by handle */

struct render_pass {
    uint32_t count;
    struct subpass_dependency dependencies[];
};

struct image {
    VkFormat format;
};

struct hazard_objects {
    struct reader_lock lock;
    struct handle_table images, render_passes;
    struct descriptor_sets sets;
    struct shader_pipelines pipelines;
};

struct hazard_objects *hazard_objects_create(void)
{
    return calloc(1, sizeof(struct hazard_objects));
}

void hazard_objects_destroy(struct hazard_objects *objects)
{
    if (!objects)
        return;
    handle_table_drop(&objects->images, free);
    handle_table_drop(&objects->render_passes, free);
    descriptor_sets_end(&objects->sets);
    shader_pipelines_end(&objects->pipelines);
    free(objects);
}

struct descriptor_sets *hazard_objects_sets(struct hazard_objects *objects)
{
    return objects ? &objects->sets : NULL;
}

struct shader_pipelines *hazard_objects_pipelines(struct hazard_objects *objects)
{
    return objects ? &objects->pipelines : NULL;
}

/* Takes over the record, which may be NULL: then the handle is removed. */
static void set_record(struct hazard_objects *objects, struct handle_table *table, uint64_t handle,
                       void *record)
{
    reader_lock_write(&objects->lock);
    void *old = handle_table_remove(table, handle);
    bool is_kept = record && handle_table_set(table, handle, record);
    reader_lock_write_done(&objects->lock);
    free(old);
    if (!is_kept)
        free(record);
}

void hazard_objects_add_image(struct hazard_objects *objects, VkImage image, VkFormat format)
{
    if (!objects)
        return;
    struct image *record = malloc(sizeof(*record));
    if (record)
        record->format = format;
    set_record(objects, &objects->images, handle_number(image), record);
}

void hazard_objects_remove_image(struct hazard_objects *objects, VkImage image)
{
    if (objects && image)
        set_record(objects, &objects->images, handle_number(image), NULL);
}

VkFormat hazard_objects_format(struct hazard_objects *objects, VkImage image)
{
    if (!objects)
        return VK_FORMAT_UNDEFINED;
    unsigned stripe = reader_lock_enter(&objects->lock);
    const struct image *record = handle_table_find(&objects->images, handle_number(image));
    VkFormat format = record ? record->format : VK_FORMAT_UNDEFINED;
    reader_lock_leave(&objects->lock, stripe);
    return format;
}

void hazard_objects_add_render_pass(struct hazard_objects *objects, VkRenderPass render_pass,
                                    const struct subpass_dependency *dependencies, uint32_t count)
{
    if (!objects)
        return;
    struct render_pass *record = malloc(sizeof(*record) + count * sizeof(*dependencies));
    if (record)
        record->count = count;
    if (record && count)
        memcpy(record->dependencies, dependencies, count * sizeof(*dependencies));
    set_record(objects, &objects->render_passes, handle_number(render_pass), record);
}

void hazard_objects_remove_render_pass(struct hazard_objects *objects, VkRenderPass render_pass)
{
    if (objects && render_pass)
        set_record(objects, &objects->render_passes, handle_number(render_pass), NULL);
}

const struct subpass_dependency *hazard_objects_dependencies(struct hazard_objects *objects,
                                                             VkRenderPass render_pass,
                                                             uint32_t *count)
{
    if (!objects)
        return NULL;
    unsigned stripe = reader_lock_enter(&objects->lock);
    const struct render_pass *record =
        handle_table_find(&objects->render_passes, handle_number(render_pass));
    reader_lock_leave(&objects->lock, stripe);
    if (!record)
        return NULL;
    *count = record->count;
    return record->dependencies;
}

/* ---- records what host commands access */

bool hazards_start_host(struct hazard_recording *recording, struct layer_device *device,
                        const char *name)
{
    if (!device->finds_hazards)
        return false;
    *recording =
        (struct hazard_recording){.device = device, .journal = journal_create(VK_NULL_HANDLE)};
    if (!recording->journal)
        return false;
    host_work_set_journal(recording->journal);
    hazard_recording_command(recording, name, NULL);
    return true;
}

/* Spans of mapped memory behind a pointer; more than these are not recorded. */
struct host_spans {
    struct memory_span spans[4];
    uint32_t count;
};

static void keep_span(void *user, const struct memory_span *span)
{
    struct host_spans *kept = user;
    if (span->memory != memory_of_host() && kept->count < 4)
        kept->spans[kept->count++] = *span;
}

void hazards_add_host(struct hazard_recording *recording, const struct hazard_use *use,
                      const void *pointer, uint64_t size)
{
    struct host_spans kept = {.count = 0};
    struct resources *resources = recording->device->resources;
    if (!pointer || !size)
        return;
    resources_find_host_pieces(resources, pointer, size, keep_span, &kept);
    for (uint32_t i = 0; i < kept.count; i++) {
        const struct memory_span *span = &kept.spans[i];
        const struct hazard_bytes bytes = {
            hazard_memory_id(recording->journal, resources, span->memory), span->begin, span->end};
        hazard_recording_add(recording, use, VK_OBJECT_TYPE_UNKNOWN, 0, &bytes);
    }
}
