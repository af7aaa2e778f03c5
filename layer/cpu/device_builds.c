/* SPDX-License-Identifier: Apache-2.0 */
/* Commands of backend cpu: builds of command buffers. What they read is copied at that point of the
 * command buffer; the trees are made when somebody asks for them. */
#include <stdlib.h>

#include "cpu/commands.h"
#include "cpu/gather.h"
#include "cpu/input.h"
#include "cpu/recorder.h"

/* Memory that can't be read yet: what the builder will ask for is copied. */
struct copied_memory {
    struct cpu_recorder *recorder;
    struct cpu_recorded_build *build;
    bool to_the_end; /* of each buffer, for the ranges aren't known yet */
};

static void keep_snapshot(const struct cpu_recorder *recorder, struct cpu_recorded_build *build,
                          const struct cpu_snapshot *snapshot)
{
    if (!cpu_recorded_build_add(build, snapshot))
        cpu_recorder_lose(recorder);
}

static uint64_t copy(void *context, uint64_t address, uint64_t size, const void **bytes)
{
    const struct copied_memory *memory = context;
    struct cpu_snapshot snapshot;
    const struct cpu_snapshot *there =
        cpu_snapshot_find(memory->build->snapshots, memory->build->snapshot_count, address);
    *bytes = NULL;
    if (memory->to_the_end)
        size = UINT64_MAX;
    if (there && (memory->to_the_end || size <= there->size - (address - there->address)))
        return 0;
    if (cpu_recorder_copy(memory->recorder, address, size, &snapshot))
        keep_snapshot(memory->recorder, memory->build, &snapshot);
    return 0;
}

/* What an array of pointers points to; of an indirect build, whose offset and count aren't known
 * yet, all that the snapshot has. */
static void gather_instances(struct cpu_recorder *recorder, struct cpu_recorded_build *build)
{
    const struct cpu_build_info *parameters = &build->parameters;
    if (parameters->info.geometryCount != 1 ||
        parameters->geometries[0].geometryType != VK_GEOMETRY_TYPE_INSTANCES_KHR ||
        !parameters->geometries[0].geometry.instances.arrayOfPointers)
        return;
    const struct cpu_snapshot *addresses =
        cpu_snapshot_find(build->snapshots, build->snapshot_count,
                          parameters->geometries[0].geometry.instances.data.deviceAddress);
    struct cpu_gathering gathering = {.is_typed = parameters->info.flags &
                                                  VK_BUILD_ACCELERATION_STRUCTURE_MOTION_BIT_NV};
    if (addresses && cpu_recorder_gather(recorder, addresses, &gathering))
        build->gathering = gathering;
}

static void copy_inputs(struct cpu_recorder *recorder, struct cpu_recorded_build *build)
{
    struct copied_memory copied = {recorder, build, build->is_indirect};
    struct cpu_memory memory = {copy, &copied};
    struct cpu_input input;
    if (build->is_indirect) {
        uint64_t count = build->parameters.info.geometryCount;
        struct cpu_snapshot ranges;
        uint64_t size =
            (count - 1) * build->indirect_stride + sizeof(VkAccelerationStructureBuildRangeInfoKHR);
        if (count && cpu_recorder_copy(recorder, build->indirect_address, size, &ranges))
            keep_snapshot(recorder, build, &ranges);
    }
    if (cpu_input_open(&build->parameters, &memory, &input) == VK_SUCCESS)
        cpu_input_close(&input);
    else
        cpu_recorder_lose(recorder);
    gather_instances(recorder, build);
}

void cpu_recorder_add_build(struct cpu_recorder *recorder, struct cpu_recorded_build *build)
{
    const VkAccelerationStructureBuildGeometryInfoKHR *info = &build->parameters.info;
    copy_inputs(recorder, build);
    const struct cpu_item item = {
        .kind = info->mode == VK_BUILD_ACCELERATION_STRUCTURE_MODE_UPDATE_KHR ? CPU_ITEM_UPDATE
                                                                              : CPU_ITEM_BUILD,
        .dst = (uint64_t)info->dstAccelerationStructure,
        .src = (uint64_t)info->srcAccelerationStructure,
        .build = build,
    };
    cpu_recorder_add(recorder, &item);
}

/* NULL where a parameter can't be read, or without memory: then nothing is built. */
static struct cpu_recorded_build *
copy_parameters(const struct cpu_recorder *recorder,
                const VkAccelerationStructureBuildGeometryInfoKHR *info,
                const VkAccelerationStructureBuildRangeInfoKHR *ranges)
{
    struct cpu_recorded_build *build = calloc(1, sizeof(*build));
    VkResult result = VK_ERROR_OUT_OF_HOST_MEMORY;
    if (build)
        result = cpu_build_info_copy(&recorder->command_buffer->readable, info, ranges,
                                     &build->parameters);
    if (result == VK_SUCCESS)
        return build;
    if (result == VK_ERROR_OUT_OF_HOST_MEMORY)
        cpu_recorder_lose(recorder);
    free(build);
    return NULL;
}

VKAPI_ATTR void VKAPI_CALL cpu_CmdBuildAccelerationStructuresKHR(
    VkCommandBuffer commandBuffer, uint32_t infoCount,
    const VkAccelerationStructureBuildGeometryInfoKHR *pInfos,
    const VkAccelerationStructureBuildRangeInfoKHR *const *ppBuildRangeInfos)
{
    struct cpu_recorder recorder;
    if (!cpu_recorder_begin(&recorder, commandBuffer) ||
        !readable(&recorder.command_buffer->readable, ppBuildRangeInfos,
                  infoCount * sizeof(*ppBuildRangeInfos)))
        return;
    for (uint32_t i = 0; i < infoCount; i++) {
        struct cpu_recorded_build *build =
            copy_parameters(&recorder, &pInfos[i], ppBuildRangeInfos[i]);
        if (!build)
            continue;
        cpu_recorded_build_normalize(build);
        cpu_recorder_add_build(&recorder, build);
    }
    cpu_recorder_end(&recorder);
}

static bool arrays_are_readable(const struct cpu_recorder *recorder, uint32_t count,
                                const VkDeviceAddress *addresses, const uint32_t *strides,
                                const uint32_t *const *counts)
{
    struct readable_cache *cache = &recorder->command_buffer->readable;
    return readable(cache, addresses, count * sizeof(*addresses)) &&
           readable(cache, strides, count * sizeof(*strides)) &&
           readable(cache, counts, count * sizeof(*counts));
}

static bool copy_counts(const struct cpu_recorder *recorder, const uint32_t *counts,
                        struct cpu_recorded_build *build)
{
    uint32_t count = build->parameters.info.geometryCount;
    if (!readable(&recorder->command_buffer->readable, counts, count * sizeof(*counts)))
        return false;
    for (uint32_t i = 0; i < count; i++)
        build->parameters.ranges[i].primitiveCount = counts[i];
    return true;
}

VKAPI_ATTR void VKAPI_CALL cpu_CmdBuildAccelerationStructuresIndirectKHR(
    VkCommandBuffer commandBuffer, uint32_t infoCount,
    const VkAccelerationStructureBuildGeometryInfoKHR *pInfos,
    const VkDeviceAddress *pIndirectDeviceAddresses, const uint32_t *pIndirectStrides,
    const uint32_t *const *ppMaxPrimitiveCounts)
{
    struct cpu_recorder recorder;
    if (!cpu_recorder_begin(&recorder, commandBuffer) ||
        !arrays_are_readable(&recorder, infoCount, pIndirectDeviceAddresses, pIndirectStrides,
                             ppMaxPrimitiveCounts))
        return;
    for (uint32_t i = 0; i < infoCount; i++) {
        struct cpu_recorded_build *build = copy_parameters(&recorder, &pInfos[i], NULL);
        if (!build)
            continue;
        build->is_indirect = true;
        build->indirect_address = pIndirectDeviceAddresses[i];
        build->indirect_stride = pIndirectStrides[i];
        if (!copy_counts(&recorder, ppMaxPrimitiveCounts[i], build)) {
            cpu_recorded_build_free(build);
            continue;
        }
        cpu_recorder_add_build(&recorder, build);
    }
    cpu_recorder_end(&recorder);
}
