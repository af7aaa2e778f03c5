/* SPDX-License-Identifier: Apache-2.0 */
/* Host builds. Each build of a call is one part of its work. */
#include "src/cpu/host.h"

#include <stdlib.h>
#include <string.h>

#include "src/cpu/deferred.h"
#include "src/cpu/trees/blas_references.h"
#include "src/cpu/trees/make.h"
#include "src/snapshots/micromap_info.h"
#include "src/state/builds/build_info.h"

struct build_call {
    struct cpu_device *device;
    struct host_memory memory;
    struct builder_team team; /* the joining threads; open if is_deferred */
    bool is_deferred;
    uint32_t count;
    struct build_parameters builds[]; /* zero until copied */
};

/* ---- one build */

static VkResult make_tree(struct build_call *call, const struct build_parameters *build,
                          uint64_t size_max, const void *source, struct cpu_tree *tree)
{
    struct blas_references references;
    blas_references_init(&references, call->device->structures);
    const struct cpu_making making = {
        .device = call->device,
        .build = build,
        .memory = host_memory_of(&call->memory),
        .resolver = blas_references_resolver(&references),
        .micromaps = blas_references_micromaps(&references),
        .source = source,
        .size_max = size_max,
        .scratch = build->info.scratchData.hostAddress,
        .team = call->is_deferred ? &call->team : NULL,
    };
    VkResult result = cpu_make_by_build(&making, tree);
    if (references.out_of_memory)
        result = VK_ERROR_OUT_OF_HOST_MEMORY;
    blas_references_release(&references);
    return result;
}

static VkResult build_into(struct build_call *call, const struct build_parameters *build,
                           uint64_t size_max, const void *source)
{
    struct cpu_tree *tree = cpu_tree_create();
    if (!tree)
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    VkResult result = make_tree(call, build, size_max, source, tree);
    if (result != VK_SUCCESS) {
        cpu_tree_release(tree);
        return result;
    }
    uint64_t dst = (uint64_t)build->info.dstAccelerationStructure;
    return cpu_structures_set_tree(call->device->structures, dst, tree)
               ? VK_SUCCESS
               : VK_ERROR_VALIDATION_FAILED;
}

static VkResult run(void *context, uint32_t part)
{
    struct build_call *call = context;
    const struct build_parameters *build = &call->builds[part];
    struct cpu_structures *structures = call->device->structures;
    struct cpu_structure_info dst;
    if (!cpu_structures_find(structures, (uint64_t)build->info.dstAccelerationStructure, &dst))
        return VK_ERROR_VALIDATION_FAILED;
    if (!build_is_update(&build->info))
        return build_into(call, build, dst.size, NULL);
    struct cpu_tree *source =
        cpu_structures_tree(structures, (uint64_t)build->info.srcAccelerationStructure);
    const void *bytes = source ? cpu_tree_read(source) : NULL;
    VkResult result = bytes ? build_into(call, build, dst.size, bytes) : VK_ERROR_VALIDATION_FAILED;
    cpu_tree_release(source);
    return result;
}

/* ---- the call */

static void help(void *context)
{
    builder_team_help_for_now(&((struct build_call *)context)->team);
}

static void finish(void *context)
{
    builder_team_close(&((struct build_call *)context)->team);
}

static void release(void *context)
{
    struct build_call *call = context;
    if (call->is_deferred)
        builder_team_destroy(&call->team);
    for (uint32_t i = 0; i < call->count; i++)
        build_parameters_release(&call->builds[i]);
    host_memory_release(&call->memory);
    free(call);
}

static VkResult copy_parameters(struct build_call *call,
                                const VkAccelerationStructureBuildGeometryInfoKHR *infos,
                                const VkAccelerationStructureBuildRangeInfoKHR *const *ranges)
{
    struct readable_cache *cache = &call->memory.readable;
    for (uint32_t i = 0; i < call->count; i++) {
        const VkAccelerationStructureBuildRangeInfoKHR *own;
        memcpy(&own, &ranges[i], sizeof(own)); /* the array may be misaligned */
        VkResult result = build_parameters_copy(cache, &infos[i], own, &call->builds[i]);
        if (result != VK_SUCCESS)
            return result;
        if (!own && build_parameters_take_ranges(&call->builds[i]))
            return VK_ERROR_VALIDATION_FAILED;
    }
    return VK_SUCCESS;
}

enum { PRIMITIVES_PER_THREAD = 16384 };

/* Returns the number of threads that can help all builds of the call at the same time. */
static uint32_t concurrency(const struct build_call *call)
{
    uint64_t threads = 0;
    for (uint32_t i = 0; i < call->count; i++) {
        uint64_t primitives = 0;
        for (uint32_t j = 0; j < call->builds[i].info.geometryCount; j++)
            primitives += call->builds[i].ranges[j].primitiveCount;
        threads += 1 + primitives / PRIMITIVES_PER_THREAD;
    }
    return threads < UINT32_MAX ? (uint32_t)threads : UINT32_MAX;
}

static VkResult do_now(struct build_call *call)
{
    const struct cpu_work work = {
        .part_count = call->count, .run = run, .release = release, .context = call};
    return cpu_work_do(&work);
}

static VkResult defer(struct build_call *call, uint64_t operation)
{
    const struct cpu_work work = {
        .part_count = call->count,
        .concurrency = concurrency(call),
        .run = run,
        .help = help,
        .finish = finish,
        .release = release,
        .context = call,
    };
    call->is_deferred = true;
    builder_team_open(&call->team);
    return cpu_deferred_start(call->device->deferred, operation, &work);
}

/* Returns NULL if memory runs out. */
static struct build_call *create(struct cpu_device *device, uint32_t count,
                                 const struct readable_cache *cache)
{
    struct build_call *call = calloc(1, sizeof(*call) + sizeof(call->builds[0]) * (size_t)count);
    if (!call)
        return NULL;
    call->device = device;
    call->count = count;
    host_memory_init(&call->memory);
    call->memory.readable = *cache;
    return call;
}

/* `copied`: the result of copying the parameters. */
static VkResult start(struct build_call *call, uint64_t operation, VkResult copied)
{
    if (copied != VK_SUCCESS) {
        release(call);
        return copied;
    }
    return operation ? defer(call, operation) : do_now(call);
}

VkResult cpu_host_build(struct cpu_device *device, uint64_t operation, uint32_t count,
                        const VkAccelerationStructureBuildGeometryInfoKHR *infos,
                        const VkAccelerationStructureBuildRangeInfoKHR *const *ranges)
{
    struct readable_cache cache = {0};
    if (count == 0)
        return operation ? VK_OPERATION_NOT_DEFERRED_KHR : VK_SUCCESS;
    if (!readable(&cache, infos, sizeof(*infos) * (size_t)count) ||
        !readable(&cache, ranges, sizeof(*ranges) * (size_t)count))
        return VK_ERROR_VALIDATION_FAILED;
    struct build_call *call = create(device, count, &cache);
    return call ? start(call, operation, copy_parameters(call, infos, ranges))
                : VK_ERROR_OUT_OF_HOST_MEMORY;
}

VkResult cpu_host_build_micromaps(struct cpu_device *device, uint64_t operation, uint32_t count,
                                  const VkMicromapBuildInfoEXT *infos)
{
    struct readable_cache cache = {0};
    VkResult result = VK_SUCCESS;
    if (count == 0)
        return operation ? VK_OPERATION_NOT_DEFERRED_KHR : VK_SUCCESS;
    if (!readable(&cache, infos, sizeof(*infos) * (size_t)count))
        return VK_ERROR_VALIDATION_FAILED;
    struct build_call *call = create(device, count, &cache);
    if (!call)
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    for (uint32_t i = 0; i < count && result == VK_SUCCESS; i++)
        result = micromap_info_copy(&call->memory.readable, &infos[i], &call->builds[i]);
    return start(call, operation, result);
}
