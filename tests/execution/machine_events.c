/* SPDX-License-Identifier: Apache-2.0 */
/* The machine's events, as command buffers use them. */
#include "machine.h"

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

MACHINE_DESTROYS(Event)

void machine_create_events(struct machine *machine)
{
    for (uint32_t i = 0; i < EVENTS; i++) {
        const STRUCT(VkEventCreateInfo, info,
                     .flags = i == G ? VK_EVENT_CREATE_DEVICE_ONLY_BIT : 0);
        MACHINE_CREATE(machine, Event, &info, &machine->events[i]);
    }
}

static void set(const struct machine *machine, VkCommandBuffer command_buffer, VkEvent event,
                enum command_name name)
{
    const VkuDeviceDispatchTable *vk = machine->vk;
    if (name == NAME)
        vk->CmdSetEvent(command_buffer, event, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT);
    else
        (name == NAME_2 ? vk->CmdSetEvent2 : vk->CmdSetEvent2KHR)(command_buffer, event,
                                                                  &dependency);
}

static void reset(const struct machine *machine, VkCommandBuffer command_buffer, VkEvent event,
                  enum command_name name)
{
    const VkuDeviceDispatchTable *vk = machine->vk;
    if (name == NAME)
        vk->CmdResetEvent(command_buffer, event, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT);
    else
        (name == NAME_2 ? vk->CmdResetEvent2 : vk->CmdResetEvent2KHR)(
            command_buffer, event, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT);
}

static void wait(const struct machine *machine, VkCommandBuffer command_buffer, VkEvent event,
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

void machine_use_event(struct machine *machine, const struct step *step)
{
    const VkCommandBuffer command_buffer = machine->command_buffers[step->object];
    const VkEvent event = machine->events[step->dst];
    const enum command_name name = (enum command_name)step->detail;
    if (step->action == ACTION_SET_EVENT)
        set(machine, command_buffer, event, name);
    else if (step->action == ACTION_RESET_EVENT)
        reset(machine, command_buffer, event, name);
    else
        wait(machine, command_buffer, event, name);
}
