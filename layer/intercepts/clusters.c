/* SPDX-License-Identifier: Apache-2.0 */
/* Builds of clusters and of partitioned structures, and queries of their sizes. */
#include "layer/intercepts/intercepts.h"

#include <string.h>

#include "observers.h"
#include "src/base/chain.h"
#include "src/base/readable.h"
#include "src/view/cluster_view.h"

void note_cluster_sizes(struct layer_device *device,
                        const VkClusterAccelerationStructureInputInfoNV *info)
{
    if (info->opType <= VK_CLUSTER_ACCELERATION_STRUCTURE_OP_TYPE_GET_CLUSTER_TEMPLATE_INDICES_NV)
        size_queries_note_count(device->size_queries,
                                (enum asked_count)(ASKED_CLUSTERS + info->opType),
                                info->maxAccelerationStructureCount);
}

void note_partition_sizes(struct layer_device *device,
                          const VkPartitionedAccelerationStructureInstancesInputNV *info)
{
    struct size_queries *queries = device->size_queries;
    size_queries_note_count(queries, ASKED_INSTANCES, info->instanceCount);
    size_queries_note_count(queries, ASKED_INSTANCES_PER_PARTITION,
                            info->maxInstancePerPartitionCount);
    size_queries_note_count(queries, ASKED_PARTITIONS, info->partitionCount);
    size_queries_note_count(queries, ASKED_GLOBAL_INSTANCES,
                            info->maxInstanceInGlobalPartitionCount);
}

struct size_facts find_addressed_sizes(const struct layer_device *device, const void *input)
{
    const VkuDeviceDispatchTable *vk = &device->vk;
    VkAccelerationStructureBuildSizesInfoKHR found = {
        .sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_BUILD_SIZES_INFO_KHR};
    const bool is_of_clusters = *(const VkStructureType *)input ==
                                VK_STRUCTURE_TYPE_CLUSTER_ACCELERATION_STRUCTURE_INPUT_INFO_NV;
    if (is_of_clusters && vk->GetClusterAccelerationStructureBuildSizesNV)
        vk->GetClusterAccelerationStructureBuildSizesNV(device->handle, input, &found);
    else if (!is_of_clusters && vk->GetPartitionedAccelerationStructuresBuildSizesNV)
        vk->GetPartitionedAccelerationStructuresBuildSizesNV(device->handle, input, &found);
    else
        return (struct size_facts){0};
    return (struct size_facts){.known = true,
                               .acceleration_structure = found.accelerationStructureSize,
                               .build_scratch = found.buildScratchSize,
                               .update_scratch = found.updateScratchSize};
}

/* ---- builds */

static void find_sizes(const struct layer_device *device, const void *input,
                       struct addressed_build *build)
{
    const struct size_facts sizes = find_addressed_sizes(device, input);
    build->structure_size = sizes.acceleration_structure;
    build->scratch_size = sizes.build_scratch;
}

static bool moves_structures(const struct addressed_build *build)
{
    const VkClusterAccelerationStructureInputInfoNV *input = &build->clusters.info.input;
    return !build->is_partitioned &&
           input->opType == VK_CLUSTER_ACCELERATION_STRUCTURE_OP_TYPE_MOVE_OBJECTS_NV &&
           input->opMode != VK_CLUSTER_ACCELERATION_STRUCTURE_OP_MODE_COMPUTE_SIZES_NV;
}

/* Notes where a build may place structures. */
static void note_places(const struct layer_device *device, VkCommandBuffer handle,
                        const struct addressed_build *build)
{
    const struct command_buffer *recording = layer_find_recording(device, handle);
    struct placed placed = {.kind = place_kind_of(build),
                            .address = addressed_build_dst(build),
                            .size = build->is_partitioned ? 1 : build->structure_size};
    if (placed.kind == PLACE_TEMPLATE)
        placed.format = build->clusters.triangles.vertexFormat;
    if (!placed.size || placed.kind == PLACE_KINDS)
        placed.address = 0;
    if (moves_structures(build))
        places_add_moves(device->places);
    if (placed.address)
        places_add(device->places, &placed);
    else if (placed.kind < PLACE_KINDS)
        places_add_unknown(device->places, placed.kind);
    if (recording)
        journal_add_place(recording->journal, &placed);
}

/* Notes the buffers that a build uses. */
static void note_buffers(const struct layer_device *device, VkCommandBuffer handle,
                         const struct addressed_build *build)
{
    const struct command_buffer *recording = layer_find_recording(device, handle);
    struct addressed_range ranges[ADDRESSED_MEMBERS];
    const uint32_t count = addressed_ranges(build, 1, ranges);
    for (uint32_t i = 0; recording && i < count; i++) {
        struct address_facts facts;
        struct journal_input *input = journal_begin_inputs(recording->journal);
        resources_look_up_address(device->resources, ranges[i].address, &facts);
        if (!input || facts.status != ADDRESS_IN_BUFFER ||
            !journal_notes_buffer(recording->journal, facts.buffer_id))
            continue;
        *input = journal_input_of(INPUT_ROLES, (unsigned char)addressed_build_command(build), 0,
                                  facts.buffer_id);
        input->info = ranges[i].member;
        input->address = ranges[i].address;
        journal_end_inputs(recording->journal, input + 1);
    }
}

/* Returns false if the structure that the operation takes is not readable. */
static bool keep_input(const VkClusterAccelerationStructureInputInfoNV *input,
                       struct addressed_build *build)
{
    struct readable_cache *cache = readable_cache_of_thread();
    const void *given = input->opInput.pTriangleClusters;
    void *kept = &build->clusters.triangles;
    size_t size = sizeof(build->clusters.triangles);
    if (input->opType == VK_CLUSTER_ACCELERATION_STRUCTURE_OP_TYPE_MOVE_OBJECTS_NV)
        return true;
    if (input->opType == VK_CLUSTER_ACCELERATION_STRUCTURE_OP_TYPE_BUILD_CLUSTERS_BOTTOM_LEVEL_NV) {
        kept = &build->clusters.bottom_level;
        size = sizeof(build->clusters.bottom_level);
    }
    if (!readable(cache, given, size))
        return false;
    memcpy(kept, given, size);
    return true;
}

struct addressed_build
record_cluster_build(struct layer_device *device, VkCommandBuffer handle,
                     const VkClusterAccelerationStructureCommandsInfoNV *info)
{
    struct addressed_build build = {.clusters.info = *info};
    build.is_valid =
        !check_has_found() && device->facts.clusters.feature && keep_input(&info->input, &build);
    if (build.is_valid)
        find_sizes(device, &info->input, &build);
    note_places(device, handle, &build);
    note_buffers(device, handle, &build);
    return build;
}

struct addressed_build
record_partition_build(struct layer_device *device, VkCommandBuffer handle,
                       const VkBuildPartitionedAccelerationStructureInfoNV *info)
{
    const VkPartitionedAccelerationStructureFlagsNV *flags = chain_find(
        info->input.pNext, VK_STRUCTURE_TYPE_PARTITIONED_ACCELERATION_STRUCTURE_FLAGS_NV);
    struct addressed_build build = {
        .is_partitioned = true,
        .partitions = {.info = *info, .translates = flags && flags->enablePartitionTranslation}};
    build.is_valid = !check_has_found() && device->facts.partitions.feature;
    if (build.is_valid)
        find_sizes(device, &info->input, &build);
    note_places(device, handle, &build);
    note_buffers(device, handle, &build);
    return build;
}
