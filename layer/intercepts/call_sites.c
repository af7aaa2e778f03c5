/* SPDX-License-Identifier: Apache-2.0 */
/* Finds the call sites of build commands.
 *
 * A finding at the call takes the call site from the thread. A finding at submission or completion
 * takes it from the journal, whose entries have taken it from the thread. */
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

/* Returns the site of the call in whose message callback this one is made. */
static const struct call_site *enter(const struct layer_device *device, const void *dispatchable,
                                     const void *frame, const void *first)
{
    const struct call_site **of_thread = site_of_thread(), *outer = *of_thread;
    /* An invalid handle is reported on another device. */
    *of_thread =
        find_site(device ? device : layer_find_reporting_device(dispatchable), frame, first);
    return outer;
}

static void leave(const struct call_site *outer)
{
    *site_of_thread() = outer;
}

/* ---- intercepts */

VKAPI_ATTR void VKAPI_CALL located_CmdBuildAccelerationStructuresKHR(
    VkCommandBuffer commandBuffer, uint32_t infoCount,
    const VkAccelerationStructureBuildGeometryInfoKHR *pInfos,
    const VkAccelerationStructureBuildRangeInfoKHR *const *ppBuildRangeInfos)
{
    const struct call_site *outer =
        enter(layer_find_build_device(commandBuffer), commandBuffer, CALLER);
    assay_CmdBuildAccelerationStructuresKHR(commandBuffer, infoCount, pInfos, ppBuildRangeInfos);
    leave(outer);
}

VKAPI_ATTR void VKAPI_CALL located_CmdBuildAccelerationStructuresIndirectKHR(
    VkCommandBuffer commandBuffer, uint32_t infoCount,
    const VkAccelerationStructureBuildGeometryInfoKHR *pInfos,
    const VkDeviceAddress *pIndirectDeviceAddresses, const uint32_t *pIndirectStrides,
    const uint32_t *const *ppMaxPrimitiveCounts)
{
    const struct call_site *outer =
        enter(layer_find_build_device(commandBuffer), commandBuffer, CALLER);
    assay_CmdBuildAccelerationStructuresIndirectKHR(commandBuffer, infoCount, pInfos,
                                                    pIndirectDeviceAddresses, pIndirectStrides,
                                                    ppMaxPrimitiveCounts);
    leave(outer);
}

VKAPI_ATTR void VKAPI_CALL located_CmdBuildAccelerationStructureNV(
    VkCommandBuffer commandBuffer, const VkAccelerationStructureInfoNV *pInfo,
    VkBuffer instanceData, VkDeviceSize instanceOffset, VkBool32 update,
    VkAccelerationStructureNV dst, VkAccelerationStructureNV src, VkBuffer scratch,
    VkDeviceSize scratchOffset)
{
    const struct call_site *outer =
        enter(layer_find_build_device(commandBuffer), commandBuffer, CALLER);
    assay_CmdBuildAccelerationStructureNV(commandBuffer, pInfo, instanceData, instanceOffset,
                                          update, dst, src, scratch, scratchOffset);
    leave(outer);
}

VKAPI_ATTR VkResult VKAPI_CALL located_BuildAccelerationStructuresKHR(
    VkDevice device, VkDeferredOperationKHR deferredOperation, uint32_t infoCount,
    const VkAccelerationStructureBuildGeometryInfoKHR *pInfos,
    const VkAccelerationStructureBuildRangeInfoKHR *const *ppBuildRangeInfos)
{
    const struct call_site *outer = enter(layer_find_device_safely(device), device, CALLER);
    VkResult result = assay_BuildAccelerationStructuresKHR(device, deferredOperation, infoCount,
                                                           pInfos, ppBuildRangeInfos);
    leave(outer);
    return result;
}
