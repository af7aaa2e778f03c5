/* SPDX-License-Identifier: Apache-2.0 */
#include "src/model/clusters.h"

enum place_kind place_kind_of(const struct addressed_build *build)
{
    if (build->is_partitioned)
        return PLACE_PARTITIONED;
    if (build->clusters.info.input.opMode ==
        VK_CLUSTER_ACCELERATION_STRUCTURE_OP_MODE_COMPUTE_SIZES_NV)
        return PLACE_KINDS;
    switch ((int)build->clusters.info.input.opType) {
    case VK_CLUSTER_ACCELERATION_STRUCTURE_OP_TYPE_BUILD_CLUSTERS_BOTTOM_LEVEL_NV:
        return PLACE_BOTTOM_LEVEL;
    case VK_CLUSTER_ACCELERATION_STRUCTURE_OP_TYPE_BUILD_TRIANGLE_CLUSTER_TEMPLATE_NV:
        return PLACE_TEMPLATE;
    case VK_CLUSTER_ACCELERATION_STRUCTURE_OP_TYPE_BUILD_TRIANGLE_CLUSTER_NV:
    case VK_CLUSTER_ACCELERATION_STRUCTURE_OP_TYPE_INSTANTIATE_TRIANGLE_CLUSTER_NV:
        return PLACE_CLUSTER;
    default:
        return PLACE_KINDS;
    }
}

const char *addressed_argument_name(bool is_partitioned)
{
    return is_partitioned ? "pBuildInfo" : "pCommandInfos";
}

const char *addressed_member_name(enum addressed_member member, bool is_partitioned)
{
    static const char *const names[ADDRESSED_MEMBERS][2] = {
        [ADDRESSED_DST] = {"dstImplicitData", "dstAccelerationStructureData"},
        [ADDRESSED_SRC] = {NULL, "srcAccelerationStructureData"},
        [ADDRESSED_SCRATCH] = {"scratchData", "scratchData"},
        [ADDRESSED_ADDRESSES] = {"dstAddressesArray.deviceAddress"},
        [ADDRESSED_SIZES] = {"dstSizesArray.deviceAddress"},
        [ADDRESSED_INFOS] = {"srcInfosArray.deviceAddress", "srcInfos"},
        [ADDRESSED_COUNT] = {"srcInfosCount", "srcInfosCount"},
    };
    return names[member][is_partitioned];
}

/* Ranges that are being filled in. */
struct filling {
    struct addressed_range *ranges;
    uint32_t count;
};

static void add(struct filling *filling, const struct addressed_range *range)
{
    if (range->address && range->count && range->size)
        filling->ranges[filling->count++] = *range;
}

static void add_memory(struct filling *filling, enum addressed_member member, bool is_written,
                       VkDeviceAddress address, VkDeviceSize size)
{
    add(filling, &(struct addressed_range){.member = member,
                                           .is_written = is_written,
                                           .address = address,
                                           .count = 1,
                                           .size = size});
}

static void add_array(struct filling *filling, enum addressed_member member, bool is_written,
                      const VkStridedDeviceAddressRegionKHR *array, uint32_t count, uint64_t size)
{
    add(filling, &(struct addressed_range){.member = member,
                                           .is_written = is_written,
                                           .address = array->deviceAddress,
                                           .count = count,
                                           .stride = array->stride,
                                           .size = size});
}

bool cluster_member_is_indirect(const VkClusterAccelerationStructureCommandsInfoNV *info,
                                enum addressed_member member)
{
#define BIT(name) VK_CLUSTER_ACCELERATION_STRUCTURE_ADDRESS_RESOLUTION_INDIRECTED_##name##_BIT_NV
    static const VkClusterAccelerationStructureAddressResolutionFlagsNV bits[ADDRESSED_MEMBERS] = {
        [ADDRESSED_DST] = BIT(DST_IMPLICIT_DATA),       [ADDRESSED_SCRATCH] = BIT(SCRATCH_DATA),
        [ADDRESSED_ADDRESSES] = BIT(DST_ADDRESS_ARRAY), [ADDRESSED_SIZES] = BIT(DST_SIZES_ARRAY),
        [ADDRESSED_INFOS] = BIT(SRC_INFOS_ARRAY),       [ADDRESSED_COUNT] = BIT(SRC_INFOS_COUNT),
    };
#undef BIT
    return info->addressResolutionFlags & bits[member];
}

static void add_clusters(struct filling *filling, const struct addressed_build *build,
                         uint32_t infos)
{
    const VkClusterAccelerationStructureCommandsInfoNV *info = &build->clusters.info;
    const struct cluster_op *op = cluster_op(info->input.opType);
    const VkClusterAccelerationStructureOpModeNV mode = info->input.opMode;
    const bool is_full = infos == info->input.maxAccelerationStructureCount;
    if (!cluster_member_is_indirect(info, ADDRESSED_COUNT))
        add_memory(filling, ADDRESSED_COUNT, false, info->srcInfosCount, sizeof(uint32_t));
    if (!infos)
        return;
    if (!cluster_member_is_indirect(info, ADDRESSED_INFOS) && op)
        add_array(filling, ADDRESSED_INFOS, false, &info->srcInfosArray, infos, op->size);
    if (!cluster_member_is_indirect(info, ADDRESSED_ADDRESSES) &&
        mode != VK_CLUSTER_ACCELERATION_STRUCTURE_OP_MODE_COMPUTE_SIZES_NV)
        add_array(filling, ADDRESSED_ADDRESSES,
                  mode == VK_CLUSTER_ACCELERATION_STRUCTURE_OP_MODE_IMPLICIT_DESTINATIONS_NV,
                  &info->dstAddressesArray, infos, sizeof(VkDeviceAddress));
    if (!cluster_member_is_indirect(info, ADDRESSED_SIZES))
        add_array(filling, ADDRESSED_SIZES, true, &info->dstSizesArray, infos, sizeof(uint32_t));
    if (!cluster_member_is_indirect(info, ADDRESSED_SCRATCH))
        add_memory(filling, ADDRESSED_SCRATCH, true, info->scratchData, build->scratch_size);
    add_memory(filling, ADDRESSED_DST, true, addressed_build_dst(build),
               is_full || !build->structure_size ? build->structure_size : 1);
}

static void add_partitions(struct filling *filling, const struct addressed_build *build,
                           uint32_t infos)
{
    const VkBuildPartitionedAccelerationStructureInfoNV *info = &build->partitions.info;
    add_memory(filling, ADDRESSED_COUNT, false, info->srcInfosCount, sizeof(uint32_t));
    add_memory(filling, ADDRESSED_INFOS, false, info->srcInfos,
               infos * sizeof(VkBuildPartitionedAccelerationStructureIndirectCommandNV));
    add_memory(filling, ADDRESSED_SRC, false, info->srcAccelerationStructureData,
               build->structure_size);
    add_memory(filling, ADDRESSED_DST, true, info->dstAccelerationStructureData,
               build->structure_size);
    add_memory(filling, ADDRESSED_SCRATCH, true, info->scratchData, build->scratch_size);
}

uint32_t addressed_ranges(const struct addressed_build *build, uint32_t infos,
                          struct addressed_range ranges[ADDRESSED_MEMBERS])
{
    struct filling filling = {.ranges = ranges};
    if (build->is_valid && build->is_partitioned)
        add_partitions(&filling, build, infos);
    else if (build->is_valid)
        add_clusters(&filling, build, infos);
    return filling.count;
}
