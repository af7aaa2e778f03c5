/* SPDX-License-Identifier: Apache-2.0 */
/* Records builds of command buffers, and commands that read serialized data, with copies of their
 * inputs just before each. */
#include <stdlib.h>

#include <string.h>

#include "layer/snapshots/copies/copies.h"
#include "layer/snapshots/guard/copies.h"
#include "layer/snapshots/marks.h"
#include "layer/snapshots/recorder.h"
#include "observers.h"
#include "src/base/readable.h"
#include "src/model/build_parameters.h"
#include "src/model/inputs.h"
#include "src/snapshots/build_input.h"

/* Memory that cannot be read yet: each request of the builder's input becomes a copy. */
struct copied_memory {
    struct recorder *recorder;
    struct recorded_build *build;
    /* Copy to the end of each buffer, because the ranges are unknown yet. */
    bool to_the_end;
};

static void keep_snapshot(struct recorder *recorder, struct recorded_build *build,
                          const struct snapshot *snapshot)
{
    if (!recorded_build_add(build, snapshot))
        recorder_fail(recorder);
}

static uint64_t bytes_left(const struct recorder *recorder, uint64_t address)
{
    struct buffer_target target;
    return recorder_find(recorder, address, &target) ? target.size : 0;
}

static uint64_t request_copy(void *context, uint64_t address, uint64_t size, const void **bytes)
{
    const struct copied_memory *memory = context;
    struct snapshot snapshot;
    const struct snapshot *there =
        snapshot_find(memory->build->snapshots, memory->build->snapshot_count, address);
    *bytes = NULL;
    if (memory->to_the_end)
        size = UINT64_MAX;
    else if (size == UINT64_MAX)
        size = bytes_left(memory->recorder, address);
    if (there && (memory->to_the_end || size <= there->size - (address - there->address)))
        return 0;
    if (recorder_copy(memory->recorder, address, size, &snapshot))
        keep_snapshot(memory->recorder, memory->build, &snapshot);
    return 0;
}

/* Copies the instances to which an array of pointers points. The offset and count of an indirect
 * build are unknown yet, so all addresses of the snapshot count. */
static void gather_instances(struct recorder *recorder, struct recorded_build *build)
{
    const struct build_parameters *parameters = &build->parameters;
    if (parameters->info.geometryCount != 1 || !has_instance_pointers(&parameters->geometries[0]))
        return;
    const struct snapshot *addresses =
        snapshot_find(build->snapshots, build->snapshot_count,
                      input_address(&parameters->geometries[0], INPUT_INSTANCES));
    struct gathering gathering = {.is_typed = parameters->info.flags &
                                              VK_BUILD_ACCELERATION_STRUCTURE_MOTION_BIT_NV,
                                  GATHERING_OF_POINTERS};
    if (addresses && recorder_gather(recorder, addresses, &gathering))
        build->gathering = gathering;
}

/* Measures the data of a micromap, because a rule compares its size with the triangles. */
static void measure_data(struct recorder *recorder, struct recorded_build *build)
{
    const struct build_parameters *parameters = &build->parameters;
    struct snapshot snapshot;
    if (parameters->chained &&
        (int)parameters->info.type == VK_ACCELERATION_STRUCTURE_TYPE_OPACITY_MICROMAP_KHR &&
        recorder_measure(recorder, parameters->chained[0].micromap.data.deviceAddress, &snapshot))
        keep_snapshot(recorder, build, &snapshot);
}

static struct input_memory memory_of(struct copied_memory *copied)
{
    return (struct input_memory){.find = request_copy,
                                 .context = copied,
                                 .is_later = true,
                                 .is_for_rules =
                                     copied->recorder->device->snapshots->are_for_rules};
}

static void copy_inputs(struct recorder *recorder, struct recorded_build *build)
{
    struct copied_memory copied = {recorder, build, build->is_indirect};
    const struct input_memory memory = memory_of(&copied);
    struct build_input input;
    if (build->is_indirect) {
        uint64_t count = build->parameters.info.geometryCount;
        struct snapshot ranges;
        uint64_t size =
            (count - 1) * build->indirect_stride + sizeof(VkAccelerationStructureBuildRangeInfoKHR);
        if (count && recorder_copy(recorder, build->indirect_address, size, &ranges))
            keep_snapshot(recorder, build, &ranges);
    }
    measure_data(recorder, build);
    if (build_input_open(&build->parameters, &memory, &input) == VK_SUCCESS)
        build_input_close(&input);
    else
        recorder_fail(recorder);
    gather_instances(recorder, build);
}

void recorder_add_build(struct recorder *recorder, struct recorded_build *build)
{
    recorder->left_out = LEFT_OUT_NOTHING;
    copy_inputs(recorder, build);
    guard_call_add(recorder->guards, recorder, build);
    build->left_out = recorder->left_out;
    const uint32_t position = build->place.position;
    recorder_keep_build(recorder, build);
    if (recorder->left_out)
        recording_leave_out(recorder->recording, position, recorder->left_out);
}

void recorder_leave_out_build(struct recorder *recorder, uint32_t position)
{
    recorder_fail(recorder);
    recording_leave_out(recorder->recording, position, recorder->left_out);
}

/* Copies the parameters of one build. build_index already includes the call's `count` builds.
 * Returns NULL if a parameter can't be read, or without memory. */
static struct recorded_build *
copy_parameters(struct recorder *recorder, enum build_command command, uint32_t count,
                uint32_t index, const VkAccelerationStructureBuildGeometryInfoKHR *info,
                const VkAccelerationStructureBuildRangeInfoKHR *ranges)
{
    uint32_t position = recorder->command_buffer->facts.build_index - count + index;
    struct recorded_build *build = calloc(1, sizeof(*build));
    VkResult result = VK_ERROR_OUT_OF_HOST_MEMORY;
    if (build)
        result =
            build_parameters_copy(readable_cache_of_thread(), info, ranges, &build->parameters);
    if (result == VK_SUCCESS && command == COMMAND_DEVICE && !recorded_build_normalize(build))
        result = VK_ERROR_OUT_OF_HOST_MEMORY;
    if (result != VK_SUCCESS) {
        recorded_build_free(build);
        if (result == VK_ERROR_OUT_OF_HOST_MEMORY)
            recorder_leave_out_build(recorder, position);
        return NULL;
    }
    VkAccelerationStructureBuildGeometryInfoKHR given; /* may be misaligned */
    memcpy(&given, info, sizeof(given));
    build->place = (struct recorded_place){
        .command = command,
        .info = index,
        .position = position,
        .geometry_by_pointer = !given.pGeometries && given.ppGeometries,
    };
    return build;
}

static void record_copies(struct recorder *recorder, VkCommandBuffer handle, uint32_t count,
                          const VkAccelerationStructureBuildGeometryInfoKHR *infos,
                          const VkAccelerationStructureBuildRangeInfoKHR *const *ranges,
                          struct guard_call *guards)
{
    struct readable_cache *cache = readable_cache_of_thread();
    if (!recorder_begin_builds(recorder, handle) ||
        !readable(cache, infos, count * sizeof(*infos)) ||
        !readable(cache, ranges, count * sizeof(*ranges)))
        return;
    recorder->guards = guards;
    for (uint32_t i = 0; i < count; i++) {
        const VkAccelerationStructureBuildRangeInfoKHR *own;
        memcpy(&own, &ranges[i], sizeof(own)); /* the array may be misaligned */
        struct recorded_build *build =
            copy_parameters(recorder, COMMAND_DEVICE, count, i, &infos[i], own);
        if (build)
            recorder_add_build(recorder, build);
    }
    recorder_end(recorder);
    guard_call_end(guards, recorder);
}

VKAPI_ATTR void VKAPI_CALL snapshots_CmdBuildAccelerationStructuresKHR(
    VkCommandBuffer commandBuffer, uint32_t infoCount,
    const VkAccelerationStructureBuildGeometryInfoKHR *pInfos,
    const VkAccelerationStructureBuildRangeInfoKHR *const *ppBuildRangeInfos)
{
    struct snapshots *snapshots = snapshots_of_recording(commandBuffer);
    if (!snapshots)
        return;
    struct guard_call guards = {0};
    struct recorder recorder;
    record_copies(&recorder, commandBuffer, infoCount, pInfos, ppBuildRangeInfos, &guards);
    guard_call_direct(&guards, infoCount, &pInfos, &ppBuildRangeInfos);
    snapshots->down.CmdBuildAccelerationStructuresKHR(commandBuffer, infoCount, pInfos,
                                                      ppBuildRangeInfos);
    guard_call_release(&guards);
    recorder_end_call(&recorder);
}

static bool arrays_are_readable(uint32_t count,
                                const VkAccelerationStructureBuildGeometryInfoKHR *infos,
                                const VkDeviceAddress *addresses, const uint32_t *strides,
                                const uint32_t *const *counts)
{
    struct readable_cache *cache = readable_cache_of_thread();
    return readable(cache, infos, count * sizeof(*infos)) &&
           readable(cache, addresses, count * sizeof(*addresses)) &&
           readable(cache, strides, count * sizeof(*strides)) &&
           readable(cache, counts, count * sizeof(*counts));
}

static bool copy_counts(const uint32_t *counts, struct recorded_build *build)
{
    uint32_t count = build->parameters.info.geometryCount;
    if (!readable(readable_cache_of_thread(), counts, count * sizeof(*counts)))
        return false;
    for (uint32_t i = 0; i < count; i++)
        if (!type_is_dense(build->parameters.geometries[i].geometryType))
            memcpy(&build->parameters.ranges[i].primitiveCount, &counts[i], sizeof(*counts));
    return true;
}

static void record_indirect(struct recorder *recorder, VkCommandBuffer handle, uint32_t info_count,
                            const VkAccelerationStructureBuildGeometryInfoKHR *infos,
                            const VkDeviceAddress *addresses, const uint32_t *strides,
                            const uint32_t *const *counts, struct guard_call *guards)
{
    if (!recorder_begin_builds(recorder, handle) ||
        !arrays_are_readable(info_count, infos, addresses, strides, counts))
        return;
    recorder->guards = guards;
    for (uint32_t i = 0; i < info_count; i++) {
        struct recorded_build *build =
            copy_parameters(recorder, COMMAND_INDIRECT, info_count, i, &infos[i], NULL);
        if (!build)
            continue;
        const uint32_t *own_counts; /* the arrays may be misaligned */
        uint32_t own_stride;
        build->is_indirect = true;
        memcpy(&build->indirect_address, &addresses[i], sizeof(*addresses));
        memcpy(&own_stride, &strides[i], sizeof(own_stride));
        build->indirect_stride = own_stride;
        memcpy(&own_counts, &counts[i], sizeof(own_counts));
        if (!copy_counts(own_counts, build)) {
            recorded_build_free(build);
            continue;
        }
        recorder_add_build(recorder, build);
    }
    recorder_end(recorder);
    guard_call_end(guards, recorder);
}

VKAPI_ATTR void VKAPI_CALL snapshots_CmdBuildAccelerationStructuresIndirectKHR(
    VkCommandBuffer commandBuffer, uint32_t infoCount,
    const VkAccelerationStructureBuildGeometryInfoKHR *pInfos,
    const VkDeviceAddress *pIndirectDeviceAddresses, const uint32_t *pIndirectStrides,
    const uint32_t *const *ppMaxPrimitiveCounts)
{
    struct snapshots *snapshots = snapshots_of_recording(commandBuffer);
    if (!snapshots)
        return;
    struct guard_call guards = {0};
    struct recorder recorder;
    record_indirect(&recorder, commandBuffer, infoCount, pInfos, pIndirectDeviceAddresses,
                    pIndirectStrides, ppMaxPrimitiveCounts, &guards);
    guard_call_indirect(&guards, infoCount, &pInfos, &pIndirectDeviceAddresses);
    snapshots->down.CmdBuildAccelerationStructuresIndirectKHR(
        commandBuffer, infoCount, pInfos, pIndirectDeviceAddresses, pIndirectStrides,
        ppMaxPrimitiveCounts);
    guard_call_release(&guards);
    recorder_end_call(&recorder);
}

/* ---- builds of micromaps (VK_EXT_opacity_micromap) */

/* Returns NULL if a parameter can't be read, or without memory. */
static struct recorded_build *copy_micromap_parameters(const VkMicromapBuildInfoEXT *info,
                                                       uint32_t index)
{
    struct recorded_build *build = calloc(1, sizeof(*build));
    if (!build ||
        micromap_info_copy(readable_cache_of_thread(), info, &build->parameters) != VK_SUCCESS) {
        free(build);
        return NULL;
    }
    build->place = recorded_place_of_micromap(index);
    return build;
}

static void copy_micromap(struct recorder *recorder, struct recorded_build *build)
{
    struct copied_memory copied = {recorder, build, false};
    const struct input_memory memory = memory_of(&copied);
    struct micromap_input input;
    build_input_find_micromap(&build->parameters, &memory, &input);
}

/* Timestamps mark calls of builds of structures only. */
void snapshots_build_micromaps(struct layer_device *device, VkCommandBuffer handle, uint32_t count,
                               const VkMicromapBuildInfoEXT *infos)
{
    struct recorder recorder;
    if (device->snapshots->are_for_backend || !recorder_begin_other(&recorder, handle))
        return;
    for (uint32_t i = 0; i < count; i++) {
        struct recorded_build *build = copy_micromap_parameters(&infos[i], i);
        if (!build)
            continue;
        recorder.left_out = LEFT_OUT_NOTHING;
        copy_micromap(&recorder, build);
        build->left_out = recorder.left_out;
        recorder_keep_build(&recorder, build);
        if (recorder.left_out)
            recording_leave_out(recorder.recording, POSITION_OF_OTHERS, recorder.left_out);
    }
    recorder.build_count = 0;
    recorder_end(&recorder);
    recorder_end_call(&recorder);
}

/* ---- serialized data */

/* Bytes that rules may read: the header, and what its blocks say of some hundred micromaps. What is
 * beyond is unknown. */
enum { COPIED_MAX = 4096 };

static struct recorded_build *create_build(enum build_command command,
                                           const struct deserialization *from)
{
    struct recorded_build *build = calloc(1, sizeof(*build));
    struct deserialization *deserialization = malloc(sizeof(*deserialization));
    if (!build || !deserialization) {
        free(build);
        free(deserialization);
        return NULL;
    }
    *deserialization = *from;
    build->deserialization = deserialization;
    build->place = (struct recorded_place){.command = command, .position = POSITION_OF_OTHERS};
    return build;
}

static void copy_deserialized(struct layer_device *device, VkCommandBuffer handle,
                              enum build_command command,
                              const struct deserialization *deserialization)
{
    struct recorder recorder;
    struct snapshot snapshot;
    if (device->snapshots->are_for_backend || !recorder_begin_other(&recorder, handle))
        return;
    struct recorded_build *build = create_build(command, deserialization);
    if (build) {
        if (recorder_copy(&recorder, deserialization->address, COPIED_MAX, &snapshot) &&
            !recorded_build_add(build, &snapshot))
            recorder_fail(&recorder);
        recorder_keep_build(&recorder, build);
    }
    recorder_end(&recorder);
    recorder_end_call(&recorder);
}

void snapshots_copy_serialized(struct layer_device *device, VkCommandBuffer handle,
                               const VkCopyMemoryToAccelerationStructureInfoKHR *info)
{
    struct accel_facts dst;
    resources_look_up_accel(device->resources, info->dst, &dst);
    const struct deserialization deserialization = {
        .dst = handle_number(info->dst),
        .dst_size = dst.details_known ? dst.size : 0,
        .address = info->src.deviceAddress,
    };
    copy_deserialized(device, handle, COMMAND_CmdCopyMemoryToAccelerationStructureKHR,
                      &deserialization);
}

void snapshots_copy_serialized_micromap(struct layer_device *device, VkCommandBuffer handle,
                                        const VkCopyMemoryToMicromapInfoEXT *info)
{
    const struct deserialization deserialization = {
        .dst = handle_number(info->dst),
        .address = info->src.deviceAddress,
    };
    copy_deserialized(device, handle, COMMAND_CmdCopyMemoryToMicromapEXT, &deserialization);
}
