/* SPDX-License-Identifier: Apache-2.0 */
/* The views of builds of structures at addresses: of clusters and what they are part of
 * (VK_NV_cluster_acceleration_structure), and of partitioned structures
 * (VK_NV_partitioned_acceleration_structure). */
#ifndef ASSAY_VIEW_CLUSTER_VIEW_H
#define ASSAY_VIEW_CLUSTER_VIEW_H

#include "src/view/finding.h"
#include "src/view/view.h"

/* A VkClusterAccelerationStructureInputInfoNV, of a build or of a query of its sizes. */
struct cluster_input_view {
    const struct call_view *call;
    const VkClusterAccelerationStructureInputInfoNV *info;
};

/* The triangles that it is about. */
struct cluster_triangles_view {
    const struct call_view *call;
    const VkClusterAccelerationStructureTriangleClusterInputNV *input;
    enum tristate vertex_format_supported;
};

/* An address that a build takes. */
struct built_address {
    const char *field;
    VkDeviceAddress address;
    bool is_ignored;            /* in this mode */
    bool is_indirect;           /* the address is in device memory, which `address` leads to */
    struct address_facts facts; /* from level STATE on; unknown if it is ignored or indirect */
};

struct cluster_build_view {
    const struct call_view *call;
    const VkClusterAccelerationStructureCommandsInfoNV *info;
    struct size_facts sizes;
    uint32_t asked; /* the greatest maxAccelerationStructureCount for which the application has
                     * queried sizes of this opType; 0: it has queried none */
    struct built_address dst, scratch, addresses, dst_sizes, infos, count;
};

/* A VkPartitionedAccelerationStructureInstancesInputNV, of a build or of a query of its sizes. */
struct partition_input_view {
    const struct call_view *call;
    const VkPartitionedAccelerationStructureInstancesInputNV *info;
};

struct partition_build_view {
    const struct call_view *call;
    const VkBuildPartitionedAccelerationStructureInfoNV *info;
    struct size_facts sizes;
    /* The greatest counts of queries of the application; zeros: it has queried none. */
    struct {
        uint32_t instances, instances_per_partition, partitions, global_instances;
    } asked;
    struct built_address src, dst, scratch, infos, count;
};

/* A write of descriptors of partitioned structures, or one of their addresses. */
struct partition_descriptors_view {
    const struct call_view *call;
    const VkWriteDescriptorSet *write;
    const VkWriteDescriptorSetPartitionedAccelerationStructureNV *info;
};
struct partition_descriptor_view {
    const struct call_view *call;
    struct address_facts facts;
};

#endif
