/* SPDX-License-Identifier: Apache-2.0 */
/* What builds of clusters read: an array of structures, one for each structure that is built, whose
 * type the operation decides. */
#ifndef ASSAY_MODEL_CLUSTERS_H
#define ASSAY_MODEL_CLUSTERS_H

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

#endif
