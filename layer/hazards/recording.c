/* SPDX-License-Identifier: Apache-2.0 */
/* Adds accesses to journals. */
#include "layer/hazards/recording.h"

#include "layer/intercepts/journal_access.h"

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

void hazard_recording_add(struct hazard_recording *recording, const struct hazard_use *use,
                          VkObjectType type, uint64_t object, const struct hazard_bytes *bytes)
{
    if (!bytes->memory || bytes->begin >= bytes->end)
        return;
    struct hazard_entry *access = hazard_add(recording->journal, HAZARD_ACCESS);
    if (access)
        *access = (struct hazard_entry){.kind = access->kind,
                                        .size = access->size,
                                        .access = (unsigned char)use->kind,
                                        .role = (unsigned char)use->role,
                                        .info = use->info,
                                        .geometry = use->geometry,
                                        .object = object,
                                        .object_type = type,
                                        .bytes = *bytes};
}

static inline VkDeviceSize smaller_of(VkDeviceSize a, VkDeviceSize b)
{
    return a < b ? a : b;
}

static inline uint64_t memory_id(const struct hazard_recording *recording, VkDeviceMemory memory)
{
    return hazard_memory_id(recording->journal, recording->device->resources, memory);
}

void hazard_recording_add_buffer(struct hazard_recording *recording, enum access_kind kind,
                                 enum hazard_role role, VkBuffer buffer, VkDeviceSize offset,
                                 VkDeviceSize size)
{
    const struct hazard_use use = {.kind = kind, .role = role};
    struct memory_bytes all;
    if (!resources_find_buffer_bytes(recording->device->resources, buffer, &all) ||
        offset >= all.size)
        return;
    VkDeviceSize begin = all.begin + offset;
    const struct hazard_bytes bytes = {all.memory_id, begin,
                                       begin + smaller_of(size, all.size - offset)};
    hazard_recording_add(recording, &use, VK_OBJECT_TYPE_BUFFER, (uint64_t)(uintptr_t)buffer,
                         &bytes);
}

void hazard_recording_add_address(struct hazard_recording *recording, const struct hazard_use *use,
                                  const struct address_facts *facts, VkDeviceSize begin,
                                  VkDeviceSize end)
{
    if (facts->status != ADDRESS_IN_BUFFER)
        return;
    const struct hazard_bytes bytes = {memory_id(recording, facts->memory),
                                       facts->begin + smaller_of(begin, facts->bytes_left),
                                       facts->begin + smaller_of(end, facts->bytes_left)};
    hazard_recording_add(recording, use, VK_OBJECT_TYPE_BUFFER, (uint64_t)(uintptr_t)facts->buffer,
                         &bytes);
}

void hazard_recording_add_accel(struct hazard_recording *recording, const struct hazard_use *use,
                                const struct accel_facts *facts, VkDeviceSize size)
{
    const struct hazard_bytes bytes = {memory_id(recording, facts->memory), facts->begin,
                                       facts->begin + smaller_of(size, facts->size)};
    if (!facts->is_sparse)
        hazard_recording_add(recording, use, VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR,
                             (uint64_t)(uintptr_t)facts->handle, &bytes);
}

void hazard_recording_add_nv(struct hazard_recording *recording, const struct hazard_use *use,
                             const struct nv_accel_facts *facts)
{
    const struct hazard_bytes bytes = {memory_id(recording, facts->span.memory), facts->span.begin,
                                       facts->span.end};
    hazard_recording_add(recording, use, VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_NV,
                         (uint64_t)(uintptr_t)facts->handle, &bytes);
}
