/* SPDX-License-Identifier: Apache-2.0 */
/* Host builds and copies, and properties that the host reads. Each build of a call is one part of
 * its work. */
#include "src/cpu/host.h"

#include <stdlib.h>
#include <string.h>

#include "src/cpu/deferred.h"
#include "src/cpu/trees/tree.h"
#include "src/cpu/trees/trees.h"
#include "src/model/build_parameters.h"
#include "src/model/geometry.h"

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

static VkResult build_part(void *context, uint32_t part)
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

static void help_builds(void *context)
{
    builder_team_help_for_now(&((struct build_call *)context)->team);
}

static void finish_call(void *context)
{
    builder_team_close(&((struct build_call *)context)->team);
}

static void release_call(void *context)
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
static uint32_t concurrency_of(const struct build_call *call)
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
        .part_count = call->count, .run = build_part, .release = release_call, .context = call};
    return cpu_work_do(&work);
}

static VkResult defer_builds(struct build_call *call, uint64_t operation)
{
    const struct cpu_work work = {
        .part_count = call->count,
        .concurrency = concurrency_of(call),
        .run = build_part,
        .help = help_builds,
        .finish = finish_call,
        .release = release_call,
        .context = call,
    };
    call->is_deferred = true;
    builder_team_open(&call->team);
    return cpu_deferred_start(call->device->deferred, operation, &work);
}

/* Returns NULL if memory runs out. */
static struct build_call *create_call(struct cpu_device *device, uint32_t count,
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
static VkResult start_call(struct build_call *call, uint64_t operation, VkResult copied)
{
    if (copied != VK_SUCCESS) {
        release_call(call);
        return copied;
    }
    return operation ? defer_builds(call, operation) : do_now(call);
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
    struct build_call *call = create_call(device, count, &cache);
    return call ? start_call(call, operation, copy_parameters(call, infos, ranges))
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
    struct build_call *call = create_call(device, count, &cache);
    if (!call)
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    for (uint32_t i = 0; i < count && result == VK_SUCCESS; i++)
        result = micromap_info_copy(&call->memory.readable, &infos[i], &call->builds[i]);
    return start_call(call, operation, result);
}

/* ---- host copies, and properties that the host reads */

/* A copy; its work has one part. */
struct copy_call {
    struct cpu_device *device;
    VkCopyAccelerationStructureModeKHR mode;
    uint64_t src, dst;
    void *to;      /* serialization: destination */
    uint64_t from; /* deserialization: source address */
};

static VkResult start_copy(const struct copy_call *copy, uint64_t operation,
                           VkResult (*run)(void *context, uint32_t part))
{
    struct copy_call *call = malloc(sizeof(*call));
    if (!call)
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    *call = *copy;
    const struct cpu_work work = {
        .part_count = 1, .concurrency = 1, .run = run, .release = free, .context = call};
    return operation ? cpu_deferred_start(copy->device->deferred, operation, &work)
                     : cpu_work_do(&work);
}

/* Sets the tree of dst if `result` is VK_SUCCESS. Takes over the reference. */
static VkResult finish_copy(const struct copy_call *call, VkResult result, struct cpu_tree *tree)
{
    if (result != VK_SUCCESS) {
        cpu_tree_release(tree);
        return result;
    }
    return cpu_structures_set_tree(call->device->structures, call->dst, tree)
               ? VK_SUCCESS
               : VK_ERROR_VALIDATION_FAILED;
}

/* Creates a tree for dst, without bytes; `size` is the size of dst. */
static VkResult create_for_dst(const struct copy_call *call, struct cpu_tree **tree, uint64_t *size)
{
    struct cpu_structure_info dst;
    if (!cpu_structures_find(call->device->structures, call->dst, &dst))
        return VK_ERROR_VALIDATION_FAILED;
    *size = dst.size;
    *tree = cpu_tree_create();
    return *tree ? VK_SUCCESS : VK_ERROR_OUT_OF_HOST_MEMORY;
}

/* Calls `use` with the bytes of src. */
static VkResult with_source(const struct copy_call *call,
                            VkResult (*use)(const struct copy_call *call, const void *source))
{
    struct cpu_tree *source = cpu_structures_tree(call->device->structures, call->src);
    const void *bytes = source ? cpu_tree_read(source) : NULL;
    VkResult result = bytes ? use(call, bytes) : VK_ERROR_VALIDATION_FAILED;
    cpu_tree_release(source);
    return result;
}

/* ---- between structures */

static VkResult copy_tree(const struct copy_call *call, const void *source)
{
    struct cpu_tree *tree;
    uint64_t size;
    VkResult result = create_for_dst(call, &tree, &size);
    if (result != VK_SUCCESS)
        return result;
    return finish_copy(call, cpu_make_by_copy(call->device, call->mode, source, size, tree), tree);
}

static VkResult run_copy(void *context, uint32_t part)
{
    (void)part;
    return with_source(context, copy_tree);
}

VkResult cpu_host_copy(struct cpu_device *device, uint64_t operation,
                       const VkCopyAccelerationStructureInfoKHR *info)
{
    const struct copy_call call = {.device = device,
                                   .mode = info->mode,
                                   .src = (uint64_t)info->src,
                                   .dst = (uint64_t)info->dst};
    return start_copy(&call, operation, run_copy);
}

/* ---- to memory */

static VkResult write_tree(const struct copy_call *call, const void *source)
{
    uint64_t size = bytes_serialized_size(source);
    if (!memory_is_writable(call->to, size))
        return VK_ERROR_VALIDATION_FAILED;
    enum builder_result result = bytes_serialize(source, &call->device->uuids, call->to, size);
    cpu_count(&call->device->counters.copies, 1);
    cpu_count(&call->device->counters.bytes_serialized, size);
    return cpu_result(result);
}

static VkResult run_serialize(void *context, uint32_t part)
{
    (void)part;
    return with_source(context, write_tree);
}

VkResult cpu_host_serialize(struct cpu_device *device, uint64_t operation,
                            const VkCopyAccelerationStructureToMemoryInfoKHR *info)
{
    if (info->mode != VK_COPY_ACCELERATION_STRUCTURE_MODE_SERIALIZE_KHR)
        return VK_ERROR_VALIDATION_FAILED;
    const struct copy_call call = {
        .device = device, .src = (uint64_t)info->src, .to = info->dst.hostAddress};
    return start_copy(&call, operation, run_serialize);
}

/* ---- from memory */

static VkResult read_tree(const struct copy_call *call, const struct input_memory *memory)
{
    struct cpu_tree *tree;
    uint64_t size;
    VkResult result = create_for_dst(call, &tree, &size);
    if (result != VK_SUCCESS)
        return result;
    result = cpu_make_by_deserializing(call->device, memory, call->from, size, tree);
    return finish_copy(call, result, tree);
}

static VkResult run_deserialize(void *context, uint32_t part)
{
    const struct copy_call *call = context;
    (void)part;
    struct host_memory host;
    host_memory_init(&host);
    struct input_memory memory = host_memory_of(&host);
    VkResult result = read_tree(call, &memory);
    host_memory_release(&host);
    return result;
}

VkResult cpu_host_deserialize(struct cpu_device *device, uint64_t operation,
                              const VkCopyMemoryToAccelerationStructureInfoKHR *info)
{
    if (info->mode != VK_COPY_ACCELERATION_STRUCTURE_MODE_DESERIALIZE_KHR)
        return VK_ERROR_VALIDATION_FAILED;
    const struct copy_call call = {
        .device = device, .dst = (uint64_t)info->dst, .from = (uintptr_t)info->src.hostAddress};
    return start_copy(&call, operation, run_deserialize);
}

/* ---- properties */

static VkResult find_property(struct cpu_device *device, uint64_t handle, VkQueryType type,
                              uint64_t *value)
{
    struct cpu_tree *tree = cpu_structures_tree(device->structures, handle);
    const void *bytes = tree ? cpu_tree_read(tree) : NULL;
    bool is_known = bytes && cpu_property(bytes, type, value);
    cpu_tree_release(tree);
    return is_known ? VK_SUCCESS : VK_ERROR_VALIDATION_FAILED;
}

VkResult cpu_host_write_properties(struct cpu_device *device, uint32_t count,
                                   const VkAccelerationStructureKHR *structures, VkQueryType type,
                                   size_t size, void *data, size_t stride)
{
    struct readable_cache cache = {0};
    VkResult result = VK_SUCCESS;
    if (!readable(&cache, structures, sizeof(*structures) * (size_t)count) ||
        !memory_is_writable(data, size))
        return VK_ERROR_VALIDATION_FAILED;
    for (uint32_t i = 0; i < count; i++) {
        uint64_t value = 0, at;
        if (__builtin_mul_overflow(i, stride, &at) || size < sizeof(value) ||
            at > size - sizeof(value))
            return VK_ERROR_VALIDATION_FAILED;
        VkResult found = find_property(device, (uint64_t)structures[i], type, &value);
        result = result == VK_SUCCESS ? found : result;
        memcpy((char *)data + at, &value, sizeof(value));
    }
    return result;
}
