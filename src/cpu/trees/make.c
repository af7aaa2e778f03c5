/* SPDX-License-Identifier: Apache-2.0 */
/* Makes trees with the reference builder. */
#include "src/cpu/trees/trees.h"

#include "src/cpu/device.h"
#include "src/cpu/trees/tree.h"
#include "src/snapshots/build_input.h"

VkResult cpu_result(enum builder_result result)
{
    return result == BUILDER_OK ? VK_SUCCESS : VK_ERROR_VALIDATION_FAILED;
}

/* ---- builds and updates */

struct sizes {
    uint64_t tree, scratch;
};

static VkResult find_sizes(const struct cpu_making *making, const struct builder_input *input,
                           struct sizes *sizes)
{
    struct builder_sizes found;
    enum builder_result result = builder_get_sizes(input, NULL, &found);
    sizes->tree = making->source ? builder_size(making->source) : found.structure;
    sizes->scratch = making->source ? found.update_scratch : found.build_scratch;
    return sizes->tree <= making->size_max ? cpu_result(result) : VK_ERROR_VALIDATION_FAILED;
}

static VkResult run_builder(const struct cpu_making *making, const struct builder_input *input,
                            const struct sizes *sizes, void *tree)
{
    struct cpu_scratch scratch;
    VkResult taken = cpu_scratch_take(&making->device->scratch_claims, making->scratch,
                                      sizes->scratch, &scratch);
    if (taken != VK_SUCCESS)
        return taken;
    struct builder_report report;
    enum builder_result result =
        making->source
            ? builder_refit(input, making->source, tree, sizes->tree, scratch.bytes, scratch.size,
                            &report)
            : builder_build(input, tree, sizes->tree, scratch.bytes, scratch.size, &report);
    cpu_count(&making->device->counters.matrix_products, report.transformed);
    if (making->scratch && scratch.owned)
        cpu_count(&making->device->counters.own_scratch, 1);
    cpu_scratch_return(&scratch);
    return cpu_result(result);
}

static void count_build(const struct cpu_making *making, const struct sizes *sizes)
{
    struct cpu_counters *counters = &making->device->counters;
    uint64_t primitives = 0;
    for (uint32_t i = 0; i < making->build->info.geometryCount; i++)
        primitives += making->build->ranges[i].primitiveCount;
    cpu_count(making->source ? &counters->updates : &counters->builds, 1);
    cpu_count(&counters->primitives, primitives);
    cpu_count(&counters->bytes_built, sizes->tree);
}

static VkResult make_micromap(const struct cpu_making *making, const struct micromap_input *input,
                              struct cpu_tree *tree)
{
    struct sizes sizes = {0};
    VkResult result = cpu_result(micromap_get_size(input, &sizes.tree));
    if (result != VK_SUCCESS || making->source || sizes.tree > making->size_max)
        return VK_ERROR_VALIDATION_FAILED;
    void *bytes = cpu_tree_allocate(tree, sizes.tree);
    if (!bytes)
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    result = cpu_result(micromap_build(input, bytes, sizes.tree));
    if (result == VK_SUCCESS)
        count_build(making, &sizes);
    return result;
}

static VkResult make_structure(const struct cpu_making *making, struct build_input *input,
                               struct cpu_tree *tree)
{
    struct sizes sizes;
    input->input.resolver = making->resolver;
    input->input.micromaps = making->micromaps;
    input->input.team = making->team;
    if (making->source && micromap_is(making->source))
        return VK_ERROR_VALIDATION_FAILED;
    VkResult result = find_sizes(making, &input->input, &sizes);
    if (result == VK_SUCCESS) {
        void *bytes = cpu_tree_allocate(tree, sizes.tree);
        result =
            bytes ? run_builder(making, &input->input, &sizes, bytes) : VK_ERROR_OUT_OF_HOST_MEMORY;
    }
    if (result == VK_SUCCESS)
        count_build(making, &sizes);
    return result;
}

VkResult cpu_make_by_build(const struct cpu_making *making, struct cpu_tree *tree)
{
    struct build_input input;
    VkResult result = build_input_open(making->build, &making->memory, &input);
    if (result == VK_SUCCESS)
        result = input.is_micromap ? make_micromap(making, &input.micromap, tree)
                                   : make_structure(making, &input, tree);
    build_input_close(&input);
    return result;
}

/* ---- copies */

static VkResult count_copy(struct cpu_device *device, enum builder_result result, uint64_t size)
{
    if (result == BUILDER_OK) {
        cpu_count(&device->counters.copies, 1);
        cpu_count(&device->counters.bytes_built, size);
    }
    return cpu_result(result);
}

VkResult cpu_make_by_copy(struct cpu_device *device, VkCopyAccelerationStructureModeKHR mode,
                          const void *source, uint64_t size_max, struct cpu_tree *tree)
{
    bool compacts = mode == VK_COPY_ACCELERATION_STRUCTURE_MODE_COMPACT_KHR;
    if (!compacts && mode != VK_COPY_ACCELERATION_STRUCTURE_MODE_CLONE_KHR)
        return VK_ERROR_VALIDATION_FAILED;
    uint64_t size = compacts ? bytes_compacted_size(source) : bytes_size(source);
    if (size > size_max)
        return VK_ERROR_VALIDATION_FAILED;
    void *bytes = cpu_tree_allocate(tree, size);
    if (!bytes)
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    return count_copy(
        device, compacts ? bytes_compact(source, bytes, size) : bytes_clone(source, bytes, size),
        size);
}

VkResult cpu_make_by_deserializing(struct cpu_device *device, const struct input_memory *memory,
                                   uint64_t address, uint64_t size_max, struct cpu_tree *tree)
{
    const void *bytes;
    struct builder_serialized header;
    if (memory->find(memory->context, address, BUILDER_SERIALIZED_HEADER, &bytes) <
            BUILDER_SERIALIZED_HEADER ||
        !builder_read_header(bytes, &device->uuids, &header) ||
        memory->find(memory->context, address, header.size, &bytes) < header.size ||
        header.structure_size > size_max)
        return VK_ERROR_VALIDATION_FAILED;
    uint64_t size = header.structure_size;
    void *to = cpu_tree_allocate(tree, size);
    if (!to)
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    return count_copy(device,
                      micromap_is_serialized(bytes, header.size)
                          ? micromap_deserialize(bytes, header.size, &device->uuids, to, size)
                          : builder_deserialize(bytes, header.size, &device->uuids, to, size),
                      size);
}
