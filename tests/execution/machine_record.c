/* SPDX-License-Identifier: Apache-2.0 */
/* What the machine's command buffers record. */
#include <string.h>

#include "machine.h"
#include "tests/fixture/copies.h"

static void push_label(struct machine *machine, VkCommandBuffer command_buffer, const char *name)
{
    machine->vk->CmdBeginDebugUtilsLabelEXT(command_buffer,
                                            &MAKE(VkDebugUtilsLabelEXT, .pLabelName = name));
}

static void begin(struct machine *machine, const struct step *step)
{
    static const VkCommandBufferUsageFlags flags[] = {
        [USE_AGAIN] = 0,
        [USE_ONCE] = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT,
        [USE_SIMULTANEOUS] = VK_COMMAND_BUFFER_USAGE_SIMULTANEOUS_USE_BIT,
    };
    scene_begin(machine->scene, machine->command_buffers[step->object], flags[step->detail]);
    machine->positions[step->object] = 0;
}

void machine_barrier(const struct machine *machine, VkCommandBuffer command_buffer)
{
    const STRUCT(VkMemoryBarrier, memory_barrier,
                 .srcAccessMask = VK_ACCESS_ACCELERATION_STRUCTURE_WRITE_BIT_KHR |
                                  VK_ACCESS_ACCELERATION_STRUCTURE_READ_BIT_KHR,
                 .dstAccessMask = VK_ACCESS_ACCELERATION_STRUCTURE_READ_BIT_KHR |
                                  VK_ACCESS_ACCELERATION_STRUCTURE_WRITE_BIT_KHR);
    machine->vk->CmdPipelineBarrier(command_buffer,
                                    VK_PIPELINE_STAGE_ACCELERATION_STRUCTURE_BUILD_BIT_KHR,
                                    VK_PIPELINE_STAGE_ACCELERATION_STRUCTURE_BUILD_BIT_KHR, 0, 1,
                                    &memory_barrier, 0, NULL, 0, NULL);
}

static void record_indirect(struct machine *machine, VkCommandBuffer command_buffer,
                            const struct shape_arguments *arguments)
{
    const struct test_buffer *ranges = &machine->scene->indirect;
    const uint32_t stride = sizeof(arguments->ranges[0]);
    memcpy(ranges->host, arguments->ranges, sizeof(arguments->ranges));
    machine->vk->CmdBuildAccelerationStructuresIndirectKHR(
        command_buffer, 1, &arguments->info, &ranges->address, &stride, &arguments->count_pointer);
}

void machine_fill_build(struct machine *machine, struct shape_arguments *arguments,
                        uint32_t command_buffer, uint32_t dst, const struct shape *shape)
{
    shape_fill(arguments, machine->scene, shape, false);
    arguments->info.dstAccelerationStructure = machine->structures[dst].handle;
    arguments->info.scratchData.deviceAddress =
        machine->scratch.address + (VkDeviceSize)command_buffer * 2 * MACHINE_ACCEL_SIZE;
}

const struct shape *machine_shape(const struct machine *machine, const struct step *step)
{
    return step->detail == BAD ? &machine->bad : &machine->good;
}

void machine_begin_build(struct machine *machine, const struct step *step)
{
    const VkCommandBuffer command_buffer = machine->command_buffers[step->object];
    const bool is_update = step->action == ACTION_UPDATE;
    const struct place place = {step->object, machine->positions[step->object]++};

    machine->last_build = place;
    if (is_update)
        machine->last_update = place;
    else if (step->detail == BAD)
        machine->last_bad = place;
    push_label(machine, command_buffer, "frame");
    push_label(machine, command_buffer, is_update ? "refit" : "build");
}

void machine_end_build(struct machine *machine, const struct step *step)
{
    const VkCommandBuffer command_buffer = machine->command_buffers[step->object];
    machine->vk->CmdEndDebugUtilsLabelEXT(command_buffer);
    machine->vk->CmdEndDebugUtilsLabelEXT(command_buffer);
    machine_barrier(machine, command_buffer);
}

static void build(struct machine *machine, const struct step *step)
{
    const VkCommandBuffer command_buffer = machine->command_buffers[step->object];
    const bool is_update = step->action == ACTION_UPDATE;
    struct shape_arguments arguments;

    machine_begin_build(machine, step);
    machine_fill_build(machine, &arguments, step->object, step->dst, machine_shape(machine, step));
    if (is_update) {
        arguments.info.mode = VK_BUILD_ACCELERATION_STRUCTURE_MODE_UPDATE_KHR;
        arguments.info.srcAccelerationStructure = machine->structures[step->src].handle;
    }
    if ((is_update ? machine->update_command : machine->build_command) == COMMAND_INDIRECT)
        record_indirect(machine, command_buffer, &arguments);
    else
        machine->vk->CmdBuildAccelerationStructuresKHR(command_buffer, 1, &arguments.info,
                                                       &arguments.range_pointer);
    machine_end_build(machine, step);
}

static void build_pair(struct machine *machine, const struct step *step)
{
    const struct shape *shape = machine_shape(machine, step);
    struct shape_arguments arguments[2];
    machine_fill_build(machine, &arguments[0], step->object, step->dst, shape);
    machine_fill_build(machine, &arguments[1], step->object, step->src, shape);
    arguments[1].info.scratchData.deviceAddress += MACHINE_ACCEL_SIZE;
    const VkAccelerationStructureBuildGeometryInfoKHR infos[2] = {arguments[0].info,
                                                                  arguments[1].info};
    const VkAccelerationStructureBuildRangeInfoKHR *const ranges[2] = {arguments[0].ranges,
                                                                       arguments[1].ranges};
    machine_begin_build(machine, step);
    const uint32_t second = machine->positions[step->object]++;
    if (step->detail == BAD)
        machine->last_bad = (struct place){step->object, second};
    machine->vk->CmdBuildAccelerationStructuresKHR(machine->command_buffers[step->object], 2, infos,
                                                   ranges);
    machine_end_build(machine, step);
}

VkCopyAccelerationStructureInfoKHR machine_copy(const struct machine *machine,
                                                const struct step *step)
{
    const bool compacts = step->action == ACTION_COMPACT || step->action == ACTION_HOST_COMPACT;
    return copy_info(machine->structures[step->src].handle, machine->structures[step->dst].handle,
                     compacts ? VK_COPY_ACCELERATION_STRUCTURE_MODE_COMPACT_KHR
                              : VK_COPY_ACCELERATION_STRUCTURE_MODE_CLONE_KHR);
}

static void copy(struct machine *machine, VkCommandBuffer command_buffer, const struct step *step)
{
    const VkCopyAccelerationStructureInfoKHR info = machine_copy(machine, step);
    machine->vk->CmdCopyAccelerationStructureKHR(command_buffer, &info);
    machine_barrier(machine, command_buffer);
}

static void fill(struct machine *machine, VkCommandBuffer command_buffer, const struct step *step)
{
    const VkCopyMemoryToAccelerationStructureInfoKHR info =
        deserialize_info(machine->blob.address, machine->structures[step->dst].handle);
    machine->vk->CmdCopyMemoryToAccelerationStructureKHR(command_buffer, &info);
    machine_barrier(machine, command_buffer);
}

/* ---- events */

/* What sets an event comes before it, and what is behind a wait after it, whether the device sets
 * the event or the host. */
static const STRUCT(VkMemoryBarrier2, builds,
                    .srcStageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT |
                                    VK_PIPELINE_STAGE_2_HOST_BIT,
                    .srcAccessMask = VK_ACCESS_2_MEMORY_WRITE_BIT,
                    .dstStageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT,
                    .dstAccessMask = VK_ACCESS_2_MEMORY_READ_BIT | VK_ACCESS_2_MEMORY_WRITE_BIT);
static const STRUCT(VkDependencyInfo, dependency, .memoryBarrierCount = 1,
                    .pMemoryBarriers = &builds);

static void set_event(const struct machine *machine, VkCommandBuffer command_buffer, VkEvent event,
                      enum command_name name)
{
    const VkuDeviceDispatchTable *vk = machine->vk;
    if (name == NAME)
        vk->CmdSetEvent(command_buffer, event, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT);
    else
        (name == NAME_2 ? vk->CmdSetEvent2 : vk->CmdSetEvent2KHR)(command_buffer, event,
                                                                  &dependency);
}

static void reset_event(const struct machine *machine, VkCommandBuffer command_buffer,
                        VkEvent event, enum command_name name)
{
    const VkuDeviceDispatchTable *vk = machine->vk;
    if (name == NAME)
        vk->CmdResetEvent(command_buffer, event, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT);
    else
        (name == NAME_2 ? vk->CmdResetEvent2 : vk->CmdResetEvent2KHR)(
            command_buffer, event, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT);
}

static void wait_event(const struct machine *machine, VkCommandBuffer command_buffer, VkEvent event,
                       enum command_name name)
{
    const VkuDeviceDispatchTable *vk = machine->vk;
    const STRUCT(VkMemoryBarrier, barrier, .srcAccessMask = (VkAccessFlags)builds.srcAccessMask,
                 .dstAccessMask = (VkAccessFlags)builds.dstAccessMask);
    if (name == NAME)
        vk->CmdWaitEvents(command_buffer, 1, &event, (VkPipelineStageFlags)builds.srcStageMask,
                          (VkPipelineStageFlags)builds.dstStageMask, 1, &barrier, 0, NULL, 0, NULL);
    else
        (name == NAME_2 ? vk->CmdWaitEvents2 : vk->CmdWaitEvents2KHR)(command_buffer, 1, &event,
                                                                      &dependency);
}

static void use_event(struct machine *machine, const struct step *step)
{
    const VkCommandBuffer command_buffer = machine->command_buffers[step->object];
    const VkEvent event = machine->events[step->dst];
    const enum command_name name = (enum command_name)step->detail;
    if (step->action == ACTION_SET_EVENT)
        set_event(machine, command_buffer, event, name);
    else if (step->action == ACTION_RESET_EVENT)
        reset_event(machine, command_buffer, event, name);
    else
        wait_event(machine, command_buffer, event, name);
}

/* ---- all of it */

void machine_record(struct machine *machine, const struct step *step)
{
    const VkCommandBuffer command_buffer = machine->command_buffers[step->object];
    switch (step->action) {
    case ACTION_BEGIN:
        begin(machine, step);
        break;
    case ACTION_END:
        scene_end(machine->scene, command_buffer);
        break;
    case ACTION_BUILD_PAIR:
        build_pair(machine, step);
        break;
    case ACTION_CLONE:
    case ACTION_COMPACT:
        copy(machine, command_buffer, step);
        break;
    case ACTION_FILL:
        fill(machine, command_buffer, step);
        break;
    case ACTION_EXECUTE:
        machine->positions[step->object] += machine->positions[step->dst];
        machine->vk->CmdExecuteCommands(command_buffer, 1, &machine->command_buffers[step->dst]);
        break;
    case ACTION_RESET_QUERIES:
        machine->vk->CmdResetQueryPool(command_buffer, machine->queries, 0, QUERIES);
        break;
    case ACTION_QUERY:
        machine->vk->CmdWriteAccelerationStructuresPropertiesKHR(
            command_buffer, 1, &machine->structures[step->src].handle,
            VK_QUERY_TYPE_ACCELERATION_STRUCTURE_COMPACTED_SIZE_KHR, machine->queries, step->dst);
        break;
    case ACTION_SET_EVENT:
    case ACTION_RESET_EVENT:
    case ACTION_WAIT_EVENT:
        use_event(machine, step);
        break;
    case ACTION_RESET:
        MACHINE_CALL(machine, ResetCommandBuffer, command_buffer, 0);
        break;
    case ACTION_RESET_POOL:
        MACHINE_CALL(machine, ResetCommandPool, machine->device, machine->pools[step->object], 0);
        break;
    case ACTION_REALLOCATE:
        machine->vk->FreeCommandBuffers(machine->device, machine->pools[step->object], 1,
                                        &command_buffer);
        machine_allocate(machine, step->object);
        break;
    case ACTION_DESTROY_POOL:
        scene_destroy(machine->scene, (uint64_t)machine->pools[step->object]);
        machine_create_pool(machine, step->object);
        break;
    default:
        build(machine, step);
    }
}
