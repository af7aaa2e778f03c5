/* SPDX-License-Identifier: Apache-2.0 */
/* Host copies, and properties that the host reads. */
#include "src/cpu/host.h"

#include <stdlib.h>
#include <string.h>

#include "src/cpu/deferred.h"
#include "src/cpu/trees/bytes.h"
#include "src/cpu/trees/make.h"
#include "src/cpu/trees/property.h"

/* A copy; its work has one part. */
struct copy_call {
    struct cpu_device *device;
    VkCopyAccelerationStructureModeKHR mode;
    uint64_t src, dst;
    void *to;      /* serialization: destination */
    uint64_t from; /* deserialization: source address */
};

static VkResult start(const struct copy_call *copy, uint64_t operation,
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
static VkResult settle(const struct copy_call *call, VkResult result, struct cpu_tree *tree)
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
    return settle(call, cpu_make_by_copy(call->device, call->mode, source, size, tree), tree);
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
    return start(&call, operation, run_copy);
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
    return start(&call, operation, run_serialize);
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
    return settle(call, result, tree);
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
    return start(&call, operation, run_deserialize);
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
