/* SPDX-License-Identifier: Apache-2.0 */
/* Intercepts of the build commands: observe, check, forward; the NV one is in nv.c. */
#include <stdatomic.h>

#include "layer/intercepts/intercepts.h"
#include "observers.h"
#include "src/base/readable.h"
#include "src/base/recording_path.h"

ON_RECORDING_PATH static void find_sizes(void *user,
                                         const VkAccelerationStructureBuildGeometryInfoKHR *info,
                                         const uint32_t *counts,
                                         VkAccelerationStructureBuildTypeKHR build_type,
                                         struct size_facts *sizes)
{
    layer_find_build_sizes(((struct build_call *)user)->device, info, counts, build_type, sizes);
}

static void find_size_query(void *user, const VkAccelerationStructureBuildGeometryInfoKHR *info,
                            const uint32_t *counts, VkAccelerationStructureBuildTypeKHR build_type,
                            enum queried_size which, VkDeviceSize size,
                            struct size_differences *differences)
{
    const struct build_call *call = user;
    size_queries_find(call->device->size_queries, info, counts, build_type, which, size,
                      differences);
}

void note_size_query(struct layer_device *device, VkAccelerationStructureBuildTypeKHR build_type,
                     const VkAccelerationStructureBuildGeometryInfoKHR *info,
                     const uint32_t *counts, VkAccelerationStructureBuildSizesInfoKHR *sizes)
{
    if (device->level >= LEVEL_STATE && (!info->geometryCount || counts))
        size_queries_add(device->size_queries, info, counts, build_type, sizes);
}

/* ---- the calls */

/* Calls with more builds need a sweep. They often follow each other, so the device keeps a sweep
 * for each stripe of threads. */
enum { LARGE_CALL = 16 };

static struct sweep *_Atomic *spare_of_thread(const struct build_call *call)
{
    return &call->device->spare_sweeps[reader_lock_stripe()].sweep;
}

static struct sweep *take_sweep(const struct build_call *call)
{
    struct sweep *spare = atomic_exchange(spare_of_thread(call), NULL);
    return spare ? spare : check_make_sweep();
}

static void give_back_sweep(const struct build_call *call, struct sweep *sweep)
{
    check_free_sweep(atomic_exchange(spare_of_thread(call), sweep));
}

static const struct check_hooks hooks = {
    .found = build_call_found,
    .find_sizes = find_sizes,
    .find_size_query = find_size_query,
    .vertex_format_supported = build_call_vertex_format_supported,
    .radius_format_supported = build_call_radius_format_supported,
    .of_another_device = build_call_of_another_device,
};

/* Inlined, because most of it fills in values that are constant for each command. */
static inline __attribute__((always_inline)) void run_checks(struct build_call *call,
                                                             struct readable_cache *readable)
{
    const struct layer_device *device = call->device;
    struct size_differences queried; /* not set, since few calls need it */
    struct check_context context = {
        .hooks = &hooks,
        /* Below level EXECUTION backend cpu has a journal too, but views have no state. */
        .recorder = call->journal ? device->build_recorder : NULL,
        .user = call,
        .level = device->level,
        .active = device->active_rules[call->view.command],
        .readable = readable,
        .resources = device->resources,
        .queried = &queried,
        .sweep = call->view.info_count > LARGE_CALL ? take_sweep(call) : NULL,
        .structures = device->structures,
        .point = call->point,
    };
    check_builds(&context, &call->view);
    if (context.sweep)
        give_back_sweep(call, context.sweep);
    build_call_settle_journal(call);
}

/* With this many builds or more, probing the call's arrays anew costs little. Smaller calls trust
 * probes of the last milliseconds: docs/costs.md has the figures. */
enum { PROBED_ANEW = 64 };

static inline struct readable_cache *readable_cache_for(uint32_t builds)
{
    struct readable_cache *cache = readable_cache_of_thread();
    if (builds >= PROBED_ANEW)
        readable_forget(cache);
    return cache;
}

/* Host builds read much more than arrays of parameters, and are rare enough to probe all of it
 * anew. */
static inline struct readable_cache *readable_cache_for_host(void)
{
    struct readable_cache *cache = readable_cache_of_thread();
    readable_forget(cache);
    return cache;
}

ON_RECORDING_PATH VKAPI_ATTR void VKAPI_CALL assay_CmdBuildAccelerationStructuresKHR(
    VkCommandBuffer commandBuffer, uint32_t infoCount,
    const VkAccelerationStructureBuildGeometryInfoKHR *pInfos,
    const VkAccelerationStructureBuildRangeInfoKHR *const *ppBuildRangeInfos)
{
    struct layer_device *device = layer_find_build_device(commandBuffer);
    struct build_call call;
    if (!device) {
        build_call_report_command_buffer(COMMAND_DEVICE, commandBuffer);
        return;
    }
    build_call_start_recorded(&call, device, COMMAND_DEVICE, commandBuffer);
    call.view.info_count = infoCount;
    call.view.infos = pInfos;
    call.view.build_ranges = ppBuildRangeInfos;
    run_checks(&call, readable_cache_for(infoCount));
    if (call.skip)
        return;
    build_call_count_builds(&call, infoCount);
    device->vk.CmdBuildAccelerationStructuresKHR(commandBuffer, infoCount, pInfos,
                                                 ppBuildRangeInfos);
}

VKAPI_ATTR void VKAPI_CALL assay_CmdBuildAccelerationStructuresIndirectKHR(
    VkCommandBuffer commandBuffer, uint32_t infoCount,
    const VkAccelerationStructureBuildGeometryInfoKHR *pInfos,
    const VkDeviceAddress *pIndirectDeviceAddresses, const uint32_t *pIndirectStrides,
    const uint32_t *const *ppMaxPrimitiveCounts)
{
    struct layer_device *device = layer_find_build_device(commandBuffer);
    struct build_call call;
    if (!device) {
        build_call_report_command_buffer(COMMAND_INDIRECT, commandBuffer);
        return;
    }
    build_call_start_recorded(&call, device, COMMAND_INDIRECT, commandBuffer);
    call.view.info_count = infoCount;
    call.view.infos = pInfos;
    call.view.max_primitive_counts = ppMaxPrimitiveCounts;
    call.view.indirect_addresses = pIndirectDeviceAddresses;
    call.view.indirect_strides = pIndirectStrides;
    run_checks(&call, readable_cache_for(infoCount));
    if (call.skip)
        return;
    build_call_count_builds(&call, infoCount);
    device->vk.CmdBuildAccelerationStructuresIndirectKHR(commandBuffer, infoCount, pInfos,
                                                         pIndirectDeviceAddresses, pIndirectStrides,
                                                         ppMaxPrimitiveCounts);
}

/* The execution point of a host build, at which its instances refer to structures. A structure that
 * is being written at that time must not be referenced. Returns false if the point is unknown. */
static bool find_execution_point(const struct layer_device *device, struct execution_point *point)
{
    *point = (struct execution_point){.is_unordered = true};
    return structures_find_serial(device->structures, &point->serial) &&
           execution_order_host_is_current(device->order, &point->follows);
}

VKAPI_ATTR VkResult VKAPI_CALL assay_BuildAccelerationStructuresKHR(
    VkDevice device, VkDeferredOperationKHR deferredOperation, uint32_t infoCount,
    const VkAccelerationStructureBuildGeometryInfoKHR *pInfos,
    const VkAccelerationStructureBuildRangeInfoKHR *const *ppBuildRangeInfos)
{
    struct layer_device *state = layer_find_device_safely(device);
    if (!state) {
        build_call_report_device(COMMAND_HOST, device);
        return VK_ERROR_VALIDATION_FAILED_EXT;
    }
    struct build_call call;
    build_call_start(&call, state, COMMAND_HOST);
    reporter_begin_call();
    struct execution_point point;
    call.point = find_execution_point(state, &point) ? &point : NULL;
    call.view.device_argument = device;
    call.view.deferred = host_work_operation_facts(state, deferredOperation);
    call.view.info_count = infoCount;
    call.view.infos = pInfos;
    call.view.build_ranges = ppBuildRangeInfos;
    struct host_work work = host_work_begin(state);
    call.journal = work.journal;
    run_checks(&call, readable_cache_for_host());
    if (host_work_prepare(&work, call.skip))
        return VK_ERROR_VALIDATION_FAILED_EXT;
    VkResult result = state->vk.BuildAccelerationStructuresKHR(device, deferredOperation, infoCount,
                                                               pInfos, ppBuildRangeInfos);
    return host_work_finish(&work, deferredOperation, result);
}
