/* SPDX-License-Identifier: Apache-2.0 */
/* Records builds of clusters and of partitioned structures with copies of the arrays that they
 * read, and of the arrays to which those lead. An array may be at an address that is in device
 * memory itself. */
#include <stdlib.h>

#include "layer/snapshots/copies/copies.h"
#include "layer/snapshots/guard/copies.h"
#include "layer/snapshots/guard/references.h"
#include "layer/snapshots/recorder.h"
#include "observers.h"
#include "src/view/cluster_view.h"

/* The most bytes that are gathered from one array; and the least elements of 8 bytes behind each
 * address, because a single one would be an instance. */
enum { GATHERED_MAX = 1 << 22, PARTS_MIN = 2 };

/* Returns the snapshot, or NULL if nothing is copied. */
static const struct snapshot *copy_array(struct recorder *recorder, struct recorded_build *build,
                                         VkDeviceAddress address, uint64_t size)
{
    struct snapshot snapshot;
    if (!address || !size || !recorder_copy(recorder, address, size, &snapshot))
        return NULL;
    if (recorded_build_add(build, &snapshot))
        return &build->snapshots[build->snapshot_count - 1];
    recorder_fail(recorder);
    return NULL;
}

/* Copies `size` bytes behind each address, which stands at an offset in each element. Returns the
 * copies, or NULL if nothing is copied. */
static const struct snapshot *gather_arrays(struct recorder *recorder, struct recorded_build *build,
                                            const struct snapshot *elements, uint64_t stride,
                                            uint64_t offset, uint64_t size)
{
    struct gathering gathering = {.first = (uint32_t)(offset / 8),
                                  .stride = (uint32_t)(stride / 8),
                                  .parts = (uint32_t)((size + 7) / 8)};
    if (!elements || !stride || stride % 8 || !size ||
        elements->size / stride * size > GATHERED_MAX)
        return NULL;
    if (gathering.parts < PARTS_MIN)
        gathering.parts = PARTS_MIN;
    if (!recorder_gather(recorder, elements, &gathering))
        return NULL;
    const struct gathering *kept = recorded_build_add_gathering(build, &gathering);
    if (!kept)
        recorder_fail(recorder);
    return kept ? &kept->elements : NULL;
}

/* ---- clusters */

/* An array at an address, or at one that is in device memory there. */
static const struct snapshot *copy_resolved(struct recorder *recorder, struct recorded_build *build,
                                            bool is_indirect, VkDeviceAddress address,
                                            uint64_t size)
{
    return is_indirect ? gather_arrays(recorder, build,
                                       copy_array(recorder, build, address, sizeof(address)),
                                       sizeof(address), 0, size)
                       : copy_array(recorder, build, address, size);
}

static void copy_clusters(struct recorder *recorder, struct recorded_build *build)
{
    const VkClusterAccelerationStructureCommandsInfoNV *info = &build->addressed->clusters.info;
    const uint64_t count = info->input.maxAccelerationStructureCount;
    const VkStridedDeviceAddressRegionKHR *infos = &info->srcInfosArray,
                                          *addresses = &info->dstAddressesArray;
    copy_resolved(recorder, build, cluster_member_is_indirect(info, ADDRESSED_COUNT),
                  info->srcInfosCount, sizeof(uint32_t));
    if (info->input.opMode == VK_CLUSTER_ACCELERATION_STRUCTURE_OP_MODE_EXPLICIT_DESTINATIONS_NV)
        copy_resolved(recorder, build, cluster_member_is_indirect(info, ADDRESSED_ADDRESSES),
                      addresses->deviceAddress,
                      smaller_of(addresses->size, count * addresses->stride));
    const struct snapshot *copied =
        copy_resolved(recorder, build, cluster_member_is_indirect(info, ADDRESSED_INFOS),
                      infos->deviceAddress, smaller_of(infos->size, count * infos->stride));
    if (cluster_op_has_geometries(build->addressed))
        gather_arrays(recorder, build, copied, infos->stride,
                      offsetof(VkClusterAccelerationStructureBuildTriangleClusterInfoNV,
                               geometryIndexAndFlagsBuffer),
                      (uint64_t)build->addressed->clusters.triangles.maxClusterTriangleCount *
                          sizeof(VkClusterAccelerationStructureGeometryIndexAndGeometryFlagsNV));
    if (info->input.opType ==
        VK_CLUSTER_ACCELERATION_STRUCTURE_OP_TYPE_BUILD_CLUSTERS_BOTTOM_LEVEL_NV)
        gather_arrays(recorder, build, copied, infos->stride,
                      offsetof(VkClusterAccelerationStructureBuildClustersBottomLevelInfoNV,
                               clusterReferences),
                      (uint64_t)build->addressed->clusters.bottom_level
                              .maxClusterCountPerAccelerationStructure *
                          sizeof(VkDeviceAddress));
}

/* ---- partitioned structures */

static void copy_partitions(struct recorder *recorder, struct recorded_build *build)
{
    const VkBuildPartitionedAccelerationStructureInfoNV *info = &build->addressed->partitions.info;
    const uint64_t size = sizeof(VkBuildPartitionedAccelerationStructureIndirectCommandNV);
    copy_array(recorder, build, info->srcInfosCount, sizeof(uint32_t));
    const struct snapshot *copied =
        copy_array(recorder, build, info->srcInfos, PARTITION_OPERATIONS_READ * size);
    gather_arrays(recorder, build, copied, size,
                  offsetof(VkBuildPartitionedAccelerationStructureIndirectCommandNV, argData),
                  info->input.instanceCount *
                      sizeof(VkPartitionedAccelerationStructureWriteInstanceDataNV));
}

/* ---- both */

static void build_addressed(struct layer_device *device, VkCommandBuffer handle,
                            const struct addressed_build *addressed, struct guard_call *guards)
{
    struct recorder recorder;
    if (!addressed->is_valid || device->snapshots->are_for_backend ||
        !recorder_begin_other(&recorder, handle))
        return;
    struct recorded_build *build = calloc(1, sizeof(*build));
    struct addressed_build *kept = malloc(sizeof(*kept));
    if (build && kept) {
        *kept = *addressed;
        build->addressed = kept;
        build->place = (struct recorded_place){.command = addressed_build_command(addressed),
                                               .position = POSITION_OF_OTHERS};
        if (addressed->is_partitioned)
            copy_partitions(&recorder, build);
        else
            copy_clusters(&recorder, build);
        guard_call_add(guards, &recorder, build);
        build->left_out = recorder.left_out;
        recorder_keep_build(&recorder, build);
        if (recorder.left_out)
            recording_leave_out(recorder.recording, POSITION_OF_OTHERS, recorder.left_out);
    } else {
        free(build);
        free(kept);
        recorder_fail(&recorder);
    }
    recorder_end(&recorder);
    if (guards)
        guard_call_end(guards, &recorder);
    recorder_end_call(&recorder);
}

void snapshots_build_clusters(struct layer_device *device, VkCommandBuffer handle,
                              struct addressed_build *build)
{
    build_addressed(device, handle, build, NULL);
}

void snapshots_build_partitions(struct layer_device *device,
                                PFN_vkCmdBuildPartitionedAccelerationStructuresNV down,
                                VkCommandBuffer handle,
                                const VkBuildPartitionedAccelerationStructureInfoNV *info,
                                struct addressed_build *build)
{
    struct guard_call guards = {0};
    if (!build->is_valid)
        guard_warn_unguarded(device->snapshots->guard, "a call is not valid");
    build_addressed(device, handle, build, &guards);
    VkBuildPartitionedAccelerationStructureInfoNV guarded = *info;
    for (uint32_t i = 0; i < guards.count; i++) {
        guarded.srcInfos = guards.builds[i].copy.data;
        guarded.srcInfosCount = guards.builds[i].copy.range;
    }
    down(handle, guards.count ? &guarded : info);
    guard_call_release(&guards);
}
