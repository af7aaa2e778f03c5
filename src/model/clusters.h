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
