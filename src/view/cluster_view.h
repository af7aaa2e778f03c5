/* SPDX-License-Identifier: Apache-2.0 */
/* The views of builds of structures at addresses: of clusters and what they are part of
 * (VK_NV_cluster_acceleration_structure), and of partitioned structures
 * (VK_NV_partitioned_acceleration_structure). */
#ifndef ASSAY_VIEW_CLUSTER_VIEW_H
#define ASSAY_VIEW_CLUSTER_VIEW_H

#include "src/model/clusters.h"
#include "src/state/builds/places.h"
#include "src/view/finding.h"
#include "src/view/view.h"

/* The command that makes such a build. */
static inline enum build_command addressed_build_command(const struct addressed_build *build)
{
    return build->is_partitioned ? COMMAND_CmdBuildPartitionedAccelerationStructuresNV
                                 : COMMAND_CmdBuildClusterAccelerationStructureIndirectNV;
}
static inline bool addressed_command_is_partitioned(enum build_command command)
{
    return command == COMMAND_CmdBuildPartitionedAccelerationStructuresNV;
}
/* Returns the rule about the buffer that a member leads to; RULE_COUNT: no sentence asks for one.
 */
enum rule addressed_buffer_rule(enum build_command command, enum addressed_member member);

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

/* ---- what the device has read, at level CONTENT */

/* What a build of clusters has read as a whole. */
struct cluster_read_view {
    const struct call_view *call;
    const struct addressed_build *build;
    bool has_count;
    uint32_t count; /* at srcInfosCount */
    uint32_t infos; /* that are built: the count, or maxAccelerationStructureCount at most */
    /* How many references all bottom-level structures have, and the structure that has most. */
    uint64_t references;
    uint32_t most_references, most_index;
    bool has_vertices; /* a template has */
    /* The first address of dstAddressesArray that is wrong; NULL: none. */
    const struct cluster_dst {
        uint32_t index, same; /* `same`: the index of an earlier one that is equal; or `index` */
        struct address_facts facts;
    } * misaligned, *unusable, *repeated, *in_scratch;
    uint32_t alignment;
};

/* One structure of srcInfosArray; the operation decides which member is set. A cluster is what a
 * template begins with. */
struct cluster_info_view {
    const struct call_view *call;
    const struct addressed_build *build;
    const VkClusterAccelerationStructureBuildTriangleClusterTemplateInfoNV *triangles;
    /* The first wrong element of the triangles' geometryIndexAndFlagsBuffer; NULL: none. */
    const struct triangle_geometry {
        uint32_t triangle;
        VkClusterAccelerationStructureGeometryIndexAndGeometryFlagsNV geometry;
    } * wrong_index, *wrong_reserved;
    const VkClusterAccelerationStructureInstantiateClusterInfoNV *instance;
    struct template_facts template; /* of the instance */
    const VkClusterAccelerationStructureBuildClustersBottomLevelInfoNV *bottom_level;
    struct address_facts references; /* of bottom_level; unknown if a buffer was destroyed since */
    /* Two references that are equal; the same index: there are none. */
    uint32_t first_same, second_same;
    /* Addresses of what the operation takes, at which no command that was recorded builds it. */
    VkDeviceAddress unbuilt_move, unbuilt_template;
};

/* What a build of a partitioned structure has read as a whole. */
struct partition_read_view {
    const struct call_view *call;
    const struct addressed_build *build;
    uint32_t count;             /* at srcInfosCount */
    struct address_facts infos; /* unknown if a buffer was destroyed since */
    bool src_is_unbuilt;        /* no command that was recorded builds at src */
    bool repeats_operation, repeats_instance;
    uint32_t operation; /* the opType that is repeated */
    uint32_t instance;  /* the index that is */
};

/* An element of the array that an operation leads to; its opType decides which member is set. */
struct partition_operation_view {
    const struct call_view *call;
    const struct addressed_build *build;
    const VkPartitionedAccelerationStructureWriteInstanceDataNV *write;
    const VkPartitionedAccelerationStructureUpdateInstanceDataNV *update;
    bool updates_fixed_instance; /* certainly */
    const VkPartitionedAccelerationStructureWritePartitionTranslationDataNV *translation;
};

#endif
