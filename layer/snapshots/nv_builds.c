/* SPDX-License-Identifier: Apache-2.0 */
/* Builds of VK_NV_ray_tracing. They name data by buffer and offset, so each buffer gets made-up
 * addresses that are valid within the build only. */
#include <stdlib.h>

#include "layer/snapshots/guard/calls.h"
#include "layer/snapshots/marks.h"
#include "layer/snapshots/recorder.h"
#include "observers.h"
#include "src/base/array.h"
#include "src/base/readable.h"
#include "src/snapshots/nv_info.h"

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

static bool reserve(struct inputs *inputs)
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
    resources_ask_buffer(resources, handle, &facts);
    if (facts.alive != YES || facts.status != ADDRESS_IN_BUFFER ||
        facts.size > UINT64_MAX - ALIGNMENT - inputs->next_address || !reserve(inputs))
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

static bool find(void *context, uint64_t address, struct buffer_target *target)
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
static void record(struct recorder *recorder, VkCommandBuffer handle,
                   const VkAccelerationStructureInfoNV *info, struct guard_call *guards,
                   const VkAccelerationStructureBuildGeometryInfoKHR *build)
{
    struct inputs inputs = {.recorder = recorder, .next_address = FIRST_ADDRESS};
    const struct recorder_addresses addresses = {find, &inputs};
    const struct nv_data data = {address_of, &inputs, guards->instances, guards->offset};
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
    record(&recorder, commandBuffer, pInfo, &guards, &build);
    if (guards.count) {
        instanceData = guards.builds[0].copy.buffer;
        instanceOffset = guards.builds[0].copy.offset;
    }
    snapshots->below.CmdBuildAccelerationStructureNV(commandBuffer, pInfo, instanceData,
                                                     instanceOffset, update, dst, src, scratch,
                                                     scratchOffset);
    guard_call_release(&guards);
    recorder_end_call(&recorder);
}
