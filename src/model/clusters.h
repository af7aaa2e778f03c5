/* SPDX-License-Identifier: Apache-2.0 */
/* Builds of structures at addresses. What builds of clusters read: an array of structures, one for
 * each structure that is built, whose type the operation decides. What builds of partitioned
 * structures read: an array of operations, each of which leads to an array. */
#ifndef ASSAY_MODEL_CLUSTERS_H
#define ASSAY_MODEL_CLUSTERS_H

#include <stdbool.h>
#include <stddef.h>
#include <vulkan/vulkan_core.h>

struct cluster_op {
    const char *name; /* of the structure */
    size_t size;      /* of it, in bytes */
};

/* Returns NULL for an operation that is not known. */
static inline const struct cluster_op *cluster_op(VkClusterAccelerationStructureOpTypeNV type)
{
#define OP(op, structure)                                                                          \
    [VK_CLUSTER_ACCELERATION_STRUCTURE_OP_TYPE_##op##_NV] = {#structure, sizeof(structure)},
    static const struct cluster_op ops[] = {
        OP(MOVE_OBJECTS, VkClusterAccelerationStructureMoveObjectsInfoNV)
            OP(BUILD_CLUSTERS_BOTTOM_LEVEL,
               VkClusterAccelerationStructureBuildClustersBottomLevelInfoNV)
                OP(BUILD_TRIANGLE_CLUSTER, VkClusterAccelerationStructureBuildTriangleClusterInfoNV)
                    OP(BUILD_TRIANGLE_CLUSTER_TEMPLATE,
                       VkClusterAccelerationStructureBuildTriangleClusterTemplateInfoNV)
                        OP(INSTANTIATE_TRIANGLE_CLUSTER,
                           VkClusterAccelerationStructureInstantiateClusterInfoNV)
                            OP(GET_CLUSTER_TEMPLATE_INDICES,
                               VkClusterAccelerationStructureGetTemplateIndicesInfoNV)};
#undef OP
    return (size_t)type < sizeof(ops) / sizeof(ops[0]) ? &ops[type] : NULL;
}

/* A copy of the parameters of a build. */
struct addressed_build {
    bool is_valid; /* else the call has a mistake, and is not followed */
    bool is_partitioned;
    VkDeviceSize structure_size, scratch_size; /* that the next layer returns; 0: unknown */
    union {
        struct {
            VkClusterAccelerationStructureCommandsInfoNV info; /* without the pointers of opInput */
            /* By the operation. */
            VkClusterAccelerationStructureTriangleClusterInputNV triangles;
            VkClusterAccelerationStructureClustersBottomLevelInputNV bottom_level;
        } clusters;
        struct {
            VkBuildPartitionedAccelerationStructureInfoNV info; /* without its chain */
            bool translates;                                    /* enablePartitionTranslation */
        } partitions;
    };
};

/* Whether a build reads triangles, each of which may have a geometry of its own. */
static inline bool cluster_op_has_geometries(const struct addressed_build *build)
{
    const VkClusterAccelerationStructureOpTypeNV type = build->clusters.info.input.opType;
    return (type == VK_CLUSTER_ACCELERATION_STRUCTURE_OP_TYPE_BUILD_TRIANGLE_CLUSTER_NV ||
            type == VK_CLUSTER_ACCELERATION_STRUCTURE_OP_TYPE_BUILD_TRIANGLE_CLUSTER_TEMPLATE_NV) &&
           build->clusters.triangles.maxClusterUniqueGeometryCount > 1;
}

/* Returns where a build puts all structures that it builds or moves; 0: at several addresses, or at
 * one that is in device memory, or nowhere. */
static inline VkDeviceAddress addressed_build_dst(const struct addressed_build *build)
{
    const VkClusterAccelerationStructureCommandsInfoNV *info = &build->clusters.info;
    if (build->is_partitioned)
        return build->partitions.info.dstAccelerationStructureData;
    return info->input.opMode ==
                       VK_CLUSTER_ACCELERATION_STRUCTURE_OP_MODE_IMPLICIT_DESTINATIONS_NV &&
                   !(info->addressResolutionFlags &
                     VK_CLUSTER_ACCELERATION_STRUCTURE_ADDRESS_RESOLUTION_INDIRECTED_DST_IMPLICIT_DATA_BIT_NV)
               ? info->dstImplicitData
               : 0;
}

/* Returns how many infos a build of clusters certainly reads; 0: how many is in device memory. */
static inline uint32_t addressed_certain_infos(const struct addressed_build *build)
{
    const VkClusterAccelerationStructureCommandsInfoNV *info = &build->clusters.info;
    return build->is_partitioned || info->srcInfosCount ? 0
                                                        : info->input.maxAccelerationStructureCount;
}

/* What a build puts somewhere. */
enum place_kind {
    PLACE_BOTTOM_LEVEL,
    PLACE_CLUSTER,
    PLACE_TEMPLATE,
    PLACE_PARTITIONED,
    PLACE_KINDS /* none of these */
};
enum place_kind place_kind_of(const struct addressed_build *build);

/* The addresses that a build takes. */
enum addressed_member {
    ADDRESSED_DST, /* dstImplicitData, or dstAccelerationStructureData */
    ADDRESSED_SRC,
    ADDRESSED_SCRATCH,
    ADDRESSED_ADDRESSES, /* dstAddressesArray */
    ADDRESSED_SIZES,     /* dstSizesArray */
    ADDRESSED_INFOS,
    ADDRESSED_COUNT,
    ADDRESSED_MEMBERS,
};
/* The names of a member, and of the argument that it is of. Static text. */
const char *addressed_argument_name(bool is_partitioned);
const char *addressed_member_name(enum addressed_member member, bool is_partitioned);

/* Whether addressResolutionFlags says that the address of a member is in device memory, where the
 * member leads to. */
bool cluster_member_is_indirect(const VkClusterAccelerationStructureCommandsInfoNV *info,
                                enum addressed_member member);

/* Elements that a build accesses: `count` of `size` bytes, `stride` bytes apart. */
struct addressed_range {
    enum addressed_member member;
    bool is_written;
    VkDeviceAddress address;
    uint64_t count, stride, size;
};

/* Fills in what a build accesses if so many infos are at srcInfosArray, as far as its addresses and
 * sizes are known, and returns how many ranges that are. A build of clusters that reads no infos
 * reads the count alone. Of a dst that fewer structures than the most are built in, the first byte
 * counts. */
uint32_t addressed_ranges(const struct addressed_build *build, uint32_t infos,
                          struct addressed_range ranges[ADDRESSED_MEMBERS]);

/* The most operations that a build of a partitioned structure can have: each has its opType. One
 * more shows that there are too many. */
enum { PARTITION_OPERATIONS = 3, PARTITION_OPERATIONS_READ };

/* Returns the size of one element of the array that an operation leads to; 0: unknown. */
static inline size_t partition_argument_size(VkPartitionedAccelerationStructureOpTypeNV type)
{
    switch ((int)type) {
    case VK_PARTITIONED_ACCELERATION_STRUCTURE_OP_TYPE_WRITE_INSTANCE_NV:
        return sizeof(VkPartitionedAccelerationStructureWriteInstanceDataNV);
    case VK_PARTITIONED_ACCELERATION_STRUCTURE_OP_TYPE_UPDATE_INSTANCE_NV:
        return sizeof(VkPartitionedAccelerationStructureUpdateInstanceDataNV);
    case VK_PARTITIONED_ACCELERATION_STRUCTURE_OP_TYPE_WRITE_PARTITION_TRANSLATION_NV:
        return sizeof(VkPartitionedAccelerationStructureWritePartitionTranslationDataNV);
    default:
        return 0;
    }
}

#endif
