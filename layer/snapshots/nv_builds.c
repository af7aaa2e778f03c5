/* SPDX-License-Identifier: Apache-2.0 */
/* Builds of VK_NV_ray_tracing, and the buffers that they may read. */
#include <stdlib.h>

#include "layer/snapshots/guard/copies.h"
#include "layer/snapshots/marks.h"
#include "layer/snapshots/recorder.h"
#include "layer/snapshots/snapshots.h"
#include "observers.h"
#include "src/base/array.h"
#include "src/base/chain.h"
#include "src/base/readable.h"
#include "src/model/build_parameters.h"

/* ---- buffers whose usage the layer extends */

static VkBufferUsageFlags2 usage_of(const VkBufferCreateInfo *info)
{
    const VkBufferUsageFlags2CreateInfo *flags2 =
        chain_find(info->pNext, VK_STRUCTURE_TYPE_BUFFER_USAGE_FLAGS_2_CREATE_INFO);
    return flags2 ? flags2->usage : info->usage;
}

/* Whether the layer copies from a buffer that has the usage for it. */
static bool may_copy(const VkBufferCreateInfo *info)
{
    return !(info->flags & (VK_BUFFER_CREATE_SPARSE_BINDING_BIT | VK_BUFFER_CREATE_PROTECTED_BIT));
}

/* Whether the layer may change a buffer's usage. External memory is shared with other processes,
 * and capture and replay need the same usage. */
static bool may_change_usage(const VkBufferCreateInfo *info)
{
    const VkBufferCreateFlags special = VK_BUFFER_CREATE_DEVICE_ADDRESS_CAPTURE_REPLAY_BIT |
                                        VK_BUFFER_CREATE_DESCRIPTOR_BUFFER_CAPTURE_REPLAY_BIT_EXT;
    const VkExternalMemoryBufferCreateInfo *external =
        chain_find(info->pNext, VK_STRUCTURE_TYPE_EXTERNAL_MEMORY_BUFFER_CREATE_INFO);
    return !(info->flags & special) && !(external && external->handleTypes);
}

static bool is_nv_input(const struct layer_device *device, VkBufferUsageFlags2 usage)
{
    return device->facts.extension.ray_tracing_nv &&
           (usage & VK_BUFFER_USAGE_2_SHADER_BINDING_TABLE_BIT_KHR);
}

static bool needs_usage(const struct layer_device *device, const VkBufferCreateInfo *info)
{
    VkBufferUsageFlags2 usage = usage_of(info);
    return !(usage & VK_BUFFER_USAGE_2_TRANSFER_SRC_BIT) && may_copy(info) &&
           may_change_usage(info) && is_nv_input(device, usage);
}

/* Copies the creation parameters and adds the usage. The caller ends the copy of the chain. Returns
 * false without memory. */
static bool add_usage(const VkBufferCreateInfo *info, VkBufferCreateInfo *below,
                      struct chain_copy *copy)
{
    *below = *info;
    if (chain_copy_begin(copy, info->pNext, VK_STRUCTURE_TYPE_BUFFER_USAGE_FLAGS_2_CREATE_INFO) !=
        VK_SUCCESS)
        return false;
    VkBufferUsageFlags2CreateInfo *flags2 = copy->found;
    if (flags2)
        flags2->usage |= VK_BUFFER_USAGE_2_TRANSFER_SRC_BIT;
    else
        below->usage |= VK_BUFFER_USAGE_TRANSFER_SRC_BIT;
    below->pNext = copy->first;
    return true;
}

/* ---- buffers that the layer can copy from */

static void note_copyable(struct snapshots *snapshots, VkBuffer buffer, bool is_copyable)
{
    uint64_t handle = handle_number(buffer);
    pthread_mutex_lock(&snapshots->buffers_lock);
    if (is_copyable)
        handle_table_set(&snapshots->copyable, handle, snapshots);
    else
        handle_table_remove(&snapshots->copyable, handle);
    pthread_mutex_unlock(&snapshots->buffers_lock);
}

bool snapshots_can_copy(struct snapshots *snapshots, VkBuffer buffer)
{
    if (snapshots->are_for_backend)
        return true;
    pthread_mutex_lock(&snapshots->buffers_lock);
    bool can = handle_table_find(&snapshots->copyable, handle_number(buffer));
    pthread_mutex_unlock(&snapshots->buffers_lock);
    return can;
}

static bool can_copy(const VkBufferCreateInfo *info)
{
    return (usage_of(info) & VK_BUFFER_USAGE_2_TRANSFER_SRC_BIT) && may_copy(info);
}

VkResult snapshots_create_buffer(struct layer_device *device, PFN_vkCreateBuffer create,
                                 const VkBufferCreateInfo *info,
                                 const VkAllocationCallbacks *allocator, VkBuffer *buffer)
{
    VkBufferCreateInfo below;
    struct chain_copy copy = {0};
    if (needs_usage(device, info) && add_usage(info, &below, &copy))
        info = &below;
    VkResult result = create(device->handle, info, allocator, buffer);
    if (result == VK_SUCCESS && can_copy(info))
        note_copyable(device->snapshots, *buffer, true);
    chain_copy_end(&copy);
    return result;
}

void snapshots_forget_buffer(struct layer_device *device, VkBuffer buffer)
{
    note_copyable(device->snapshots, buffer, false);
}

void snapshots_get_requirements(struct layer_device *device,
                                PFN_vkGetDeviceBufferMemoryRequirements get,
                                const VkDeviceBufferMemoryRequirements *info,
                                VkMemoryRequirements2 *requirements)
{
    VkDeviceBufferMemoryRequirements own = *info;
    VkBufferCreateInfo below;
    struct chain_copy copy = {0};
    if (needs_usage(device, info->pCreateInfo) && add_usage(info->pCreateInfo, &below, &copy))
        own.pCreateInfo = &below;
    get(device->handle, &own, requirements);
    chain_copy_end(&copy);
}

/* ---- Builds of VK_NV_ray_tracing. They name data by buffer and offset, so each buffer gets
 * made-up addresses that are valid within the build only. */

enum {
    NOWHERE = 1,         /* an address in no buffer */
    FIRST_ADDRESS = 256, /* the address of the first buffer */
    ALIGNMENT = 256,
};

struct input_buffer {
    VkBuffer handle;
    uint64_t address, size;
};

struct inputs {
    struct recorder *recorder;
    struct input_buffer *buffers;
    uint32_t count, capacity;
    uint64_t next_address;
};

static bool reserve_input(struct inputs *inputs)
{
    bool has_room = ARRAY_HAS_ROOM(inputs->buffers, inputs->count, inputs->capacity);
    if (!has_room)
        recorder_fail(inputs->recorder);
    return has_room;
}

/* Gives a buffer addresses. Returns NULL if it has no memory or was destroyed, or without memory.
 */
static const struct input_buffer *add_buffer(struct inputs *inputs, VkBuffer handle)
{
    struct resources *resources = inputs->recorder->device->resources;
    struct buffer_facts facts;
    resources_look_up_buffer(resources, handle, &facts);
    if (facts.alive != YES || facts.status != ADDRESS_IN_BUFFER ||
        facts.size > UINT64_MAX - ALIGNMENT - inputs->next_address || !reserve_input(inputs))
        return NULL;
    struct input_buffer *buffer = &inputs->buffers[inputs->count++];
    *buffer = (struct input_buffer){handle, inputs->next_address, facts.size};
    inputs->next_address += (facts.size + ALIGNMENT - 1) / ALIGNMENT * ALIGNMENT;
    return buffer;
}

static uint64_t address_of(void *context, VkBuffer handle, VkDeviceSize offset)
{
    struct inputs *inputs = context;
    const struct input_buffer *buffer = NULL;
    for (uint32_t i = 0; i < inputs->count && !buffer; i++)
        if (inputs->buffers[i].handle == handle)
            buffer = &inputs->buffers[i];
    if (!buffer)
        buffer = add_buffer(inputs, handle);
    return buffer && offset < buffer->size ? buffer->address + offset : NOWHERE;
}

static bool find_buffer_target(void *context, uint64_t address, struct buffer_target *target)
{
    const struct inputs *inputs = context;
    for (uint32_t i = 0; i < inputs->count; i++) {
        const struct input_buffer *buffer = &inputs->buffers[i];
        if (address < buffer->address || address - buffer->address >= buffer->size)
            continue;
        uint64_t offset = address - buffer->address;
        *target = (struct buffer_target){
            .buffer = buffer->handle, .offset = offset, .size = buffer->size - offset};
        return true;
    }
    return false;
}

/* Translates the parameters. Returns NULL if a parameter can't be read, or without memory. */
static struct recorded_build *translate(struct recorder *recorder,
                                        const VkAccelerationStructureInfoNV *info,
                                        const struct nv_data *data)
{
    uint32_t position = recorder->command_buffer->facts.build_index - 1;
    struct recorded_build *build = calloc(1, sizeof(*build));
    VkResult result = VK_ERROR_OUT_OF_HOST_MEMORY;
    if (build)
        result = nv_info_copy(readable_cache_of_thread(), info, data, &build->parameters);
    if (result == VK_SUCCESS) {
        build->place = (struct recorded_place){.command = COMMAND_NV, .position = position};
        return build;
    }
    if (result == VK_ERROR_OUT_OF_HOST_MEMORY)
        recorder_leave_out_build(recorder, position);
    free(build);
    return NULL;
}

/* Takes mode and structures from `build`, and the rest from `info`. */
static void record_nv_copies(struct recorder *recorder, VkCommandBuffer handle,
                             const VkAccelerationStructureInfoNV *info, struct guard_call *guards,
                             const VkAccelerationStructureBuildGeometryInfoKHR *build)
{
    struct inputs inputs = {.recorder = recorder, .next_address = FIRST_ADDRESS};
    const struct recorder_addresses addresses = {find_buffer_target, &inputs};
    const struct nv_data data = {address_of, &inputs, {guards->instances, guards->offset}};
    if (!recorder_begin_builds(recorder, handle))
        return;
    recorder->addresses = &addresses;
    recorder->guards = guards;
    struct recorded_build *recorded = translate(recorder, info, &data);
    if (recorded) {
        VkAccelerationStructureBuildGeometryInfoKHR *own = &recorded->parameters.info;
        own->mode = build->mode;
        own->dstAccelerationStructure = build->dstAccelerationStructure;
        own->srcAccelerationStructure = build->srcAccelerationStructure;
        recorder_add_build(recorder, recorded);
    }
    recorder_end(recorder);
    guard_call_end(guards, recorder);
    free(inputs.buffers);
}

VKAPI_ATTR void VKAPI_CALL snapshots_CmdBuildAccelerationStructureNV(
    VkCommandBuffer commandBuffer, const VkAccelerationStructureInfoNV *pInfo,
    VkBuffer instanceData, VkDeviceSize instanceOffset, VkBool32 update,
    VkAccelerationStructureNV dst, VkAccelerationStructureNV src, VkBuffer scratch,
    VkDeviceSize scratchOffset)
{
    struct snapshots *snapshots = snapshots_of_recording(commandBuffer);
    if (!snapshots)
        return;
    const VkAccelerationStructureBuildGeometryInfoKHR build = {
        .mode = update ? VK_BUILD_ACCELERATION_STRUCTURE_MODE_UPDATE_KHR
                       : VK_BUILD_ACCELERATION_STRUCTURE_MODE_BUILD_KHR,
        .dstAccelerationStructure = (VkAccelerationStructureKHR)dst,
        .srcAccelerationStructure = (VkAccelerationStructureKHR)src,
    };
    struct guard_call guards = {.instances = instanceData, .offset = instanceOffset};
    struct recorder recorder;
    record_nv_copies(&recorder, commandBuffer, pInfo, &guards, &build);
    if (guards.count) {
        instanceData = guards.builds[0].copy.buffer;
        instanceOffset = guards.builds[0].copy.offset;
    }
    snapshots->down.CmdBuildAccelerationStructureNV(commandBuffer, pInfo, instanceData,
                                                    instanceOffset, update, dst, src, scratch,
                                                    scratchOffset);
    guard_call_release(&guards);
    recorder_end_call(&recorder);
}
