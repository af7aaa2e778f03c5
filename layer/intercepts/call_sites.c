/* SPDX-License-Identifier: Apache-2.0 */
/* Finds the call sites of build commands.
 *
 * A finding at the call takes the call site from the thread. A finding at submission or completion
 * takes it from the journal, in which the call is noted before its builds. */
#include "layer/intercepts/call_sites.h"

#include <string.h>

#include "observers.h"
#include "src/state/commands/call_sites.h"

/* Noinline, so that the thread-local variable is located once per call. */
__attribute__((noinline)) static const struct call_site **site_of_thread(void)
{
    static _Thread_local const struct call_site *of_thread;
    return &of_thread;
}

const struct call_site *call_site_of_thread(void)
{
    return *site_of_thread();
}

void call_sites_enable(struct layer_device *device)
{
    switch (reporter_settings(device->instance->reporter)->call_sites) {
    case CALL_SITES_OFF:
        break;
    case CALL_SITES_FRAMES:
        device->call_sites = call_sites_create(CALL_STACK_BY_FRAMES);
        break;
    case CALL_SITES_FULL:
        device->call_sites = call_sites_create(CALL_STACK_BY_TABLES);
        break;
    }
}

/* ---- one call */

struct located_call {
    const struct call_site *outer; /* of a call in whose message callback this one is made */
    struct journal *journal;       /* in which the call is noted, or NULL */
    const struct command_buffer *command_buffer;
    struct journal_mark mark; /* the journal's end before the note */
    uint32_t position;
};

/* The frame and the return address of an intercept; see call_stack_walk_frames(). */
#define CALLER __builtin_frame_address(0), __builtin_return_address(0)

static const struct call_site *find_site(const struct layer_device *device, const void *frame,
                                         const void *first)
{
    struct call_stack stack;
    if (!device || !device->call_sites)
        return NULL;
    if (call_sites_kind(device->call_sites) == CALL_STACK_BY_FRAMES)
        call_stack_walk_frames(frame, first, &stack);
    else
        call_stack_walk_tables(frame, first, &stack);
    return call_sites_find(device->call_sites, &stack);
}

static struct located_call enter(const struct call_site *site)
{
    const struct call_site **of_thread = site_of_thread();
    struct located_call call = {.outer = *of_thread};
    *of_thread = site;
    return call;
}

/* A call that was skipped, or has no builds, leaves no note: the next call begins at its position.
 */
static void leave(const struct located_call *call)
{
    *site_of_thread() = call->outer;
    if (call->journal && call->command_buffer->facts.build_index == call->position)
        journal_take_back(call->journal, &call->mark);
}

/* An invalid handle is reported on another device. */
static struct located_call enter_recorded(VkCommandBuffer handle, const void *frame,
                                          const void *first)
{
    struct layer_device *device = layer_find_build_device(handle);
    struct command_buffer *command_buffer =
        device ? command_buffers_find(device->command_buffers, handle) : NULL;
    const struct call_site *site =
        find_site(device ? device : layer_find_reporting_device(handle), frame, first);
    struct located_call call = enter(site);
    if (!command_buffer || !command_buffer->journal || device->level < LEVEL_EXECUTION)
        return call;
    call.command_buffer = command_buffer;
    call.journal = command_buffer->journal;
    call.position = command_buffer->facts.build_index;
    call.mark = journal_mark(call.journal);
    journal_note_call(call.journal, call.position, site);
    return call;
}

static struct located_call enter_host(VkDevice handle, const void *frame, const void *first)
{
    const struct layer_device *device = layer_find_device_safely(handle);
    return enter(find_site(device ? device : layer_find_reporting_device(handle), frame, first));
}

/* ---- intercepts */

VKAPI_ATTR void VKAPI_CALL located_CmdBuildAccelerationStructuresKHR(
    VkCommandBuffer commandBuffer, uint32_t infoCount,
    const VkAccelerationStructureBuildGeometryInfoKHR *pInfos,
    const VkAccelerationStructureBuildRangeInfoKHR *const *ppBuildRangeInfos)
{
    struct located_call call = enter_recorded(commandBuffer, CALLER);
    assay_CmdBuildAccelerationStructuresKHR(commandBuffer, infoCount, pInfos, ppBuildRangeInfos);
    leave(&call);
}

VKAPI_ATTR void VKAPI_CALL located_CmdBuildAccelerationStructuresIndirectKHR(
    VkCommandBuffer commandBuffer, uint32_t infoCount,
    const VkAccelerationStructureBuildGeometryInfoKHR *pInfos,
    const VkDeviceAddress *pIndirectDeviceAddresses, const uint32_t *pIndirectStrides,
    const uint32_t *const *ppMaxPrimitiveCounts)
{
    struct located_call call = enter_recorded(commandBuffer, CALLER);
    assay_CmdBuildAccelerationStructuresIndirectKHR(commandBuffer, infoCount, pInfos,
                                                    pIndirectDeviceAddresses, pIndirectStrides,
                                                    ppMaxPrimitiveCounts);
    leave(&call);
}

VKAPI_ATTR void VKAPI_CALL located_CmdBuildAccelerationStructureNV(
    VkCommandBuffer commandBuffer, const VkAccelerationStructureInfoNV *pInfo,
    VkBuffer instanceData, VkDeviceSize instanceOffset, VkBool32 update,
    VkAccelerationStructureNV dst, VkAccelerationStructureNV src, VkBuffer scratch,
    VkDeviceSize scratchOffset)
{
    struct located_call call = enter_recorded(commandBuffer, CALLER);
    assay_CmdBuildAccelerationStructureNV(commandBuffer, pInfo, instanceData, instanceOffset,
                                          update, dst, src, scratch, scratchOffset);
    leave(&call);
}

VKAPI_ATTR VkResult VKAPI_CALL located_BuildAccelerationStructuresKHR(
    VkDevice device, VkDeferredOperationKHR deferredOperation, uint32_t infoCount,
    const VkAccelerationStructureBuildGeometryInfoKHR *pInfos,
    const VkAccelerationStructureBuildRangeInfoKHR *const *ppBuildRangeInfos)
{
    struct located_call call = enter_host(device, CALLER);
    VkResult result = assay_BuildAccelerationStructuresKHR(device, deferredOperation, infoCount,
                                                           pInfos, ppBuildRangeInfos);
    leave(&call);
    return result;
}
