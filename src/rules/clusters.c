/* SPDX-License-Identifier: Apache-2.0 */
/* Rules about builds of clusters and of partitioned structures, except for what the device reads.
 */
#include "src/model/clusters.h"
#include "src/rules/predicates.h"
#include "src/view/names.h"
#include "src/view/phrases.h"

enum rule addressed_buffer_rule(enum build_command command, enum addressed_member member)
{
    static const enum rule rules[ADDRESSED_MEMBERS][2] = {
        [ADDRESSED_DST] = {RULE_cluster_dst_has_storage_usage,
                           RULE_partition_structures_have_storage_usage},
        [ADDRESSED_SRC] = {RULE_COUNT, RULE_partition_structures_have_storage_usage},
        [ADDRESSED_SCRATCH] = {RULE_cluster_scratch_has_storage_usage,
                               RULE_partition_scratch_has_storage_usage},
        [ADDRESSED_ADDRESSES] = {RULE_cluster_addresses_are_in_a_storage_buffer, RULE_COUNT},
        [ADDRESSED_SIZES] = {RULE_COUNT, RULE_COUNT},
        [ADDRESSED_INFOS] = {RULE_cluster_infos_are_in_an_input_buffer,
                             RULE_partition_inputs_have_input_usage},
        [ADDRESSED_COUNT] = {RULE_cluster_count_has_input_usage,
                             RULE_partition_inputs_have_input_usage},
    };
    return rules[member][addressed_command_is_partitioned(command)];
}

/* ---- addresses */

static bool is_in_buffer(const struct built_address *address)
{
    return address->facts.status == ADDRESS_IN_BUFFER;
}

static bool leads_nowhere(const struct built_address *address)
{
    return address->facts.status == ADDRESS_NOWHERE;
}

static struct value buffer_of(const struct built_address *address)
{
    return object(VK_OBJECT_TYPE_BUFFER, handle_number(address->facts.buffer));
}

static bool violated_by_nowhere(struct finding *finding, const struct built_address *address)
{
    return violated(finding, address->field, "{} is in no buffer whose address was retrieved",
                    address_of_missing(VK_OBJECT_TYPE_BUFFER, address->address));
}

static bool has_usage(const struct built_address *address, VkBufferUsageFlags2 usage,
                      const char *name, struct finding *finding)
{
    return !is_in_buffer(address) || address->facts.usage & usage ||
           violated(finding, address->field,
                    "{} is in {}, which was created with usage {}, without {}",
                    hex(address->address), buffer_of(address), buffer_usage(address->facts.usage),
                    phrase(name));
}

#define HAS_USAGE(address, usage, finding)                                                         \
    has_usage(address, VK_BUFFER_USAGE_2_##usage, "VK_BUFFER_USAGE_" #usage, finding)

static bool has_room(const struct built_address *address, VkDeviceSize needed, const char *name,
                     struct finding *finding)
{
    return !is_in_buffer(address) || address->facts.bytes_left >= needed ||
           violated(finding, address->field, "{} leaves {} to the end of {}, less than {} ({})",
                    hex(address->address), count_of(address->facts.bytes_left, "byte"),
                    buffer_of(address), phrase(name), number(needed));
}

/* An alignment of 0 is unknown. */
static bool is_aligned(const struct built_address *address, uint32_t alignment, const char *name,
                       struct finding *finding)
{
    return address->is_ignored || address->is_indirect || !alignment ||
           address->address % alignment == 0 ||
           violated(finding, address->field, "{} is not a multiple of {} ({})",
                    hex(address->address), phrase(name), number(alignment));
}

static bool is_aligned_to(const struct built_address *address, uint32_t bytes,
                          struct finding *finding)
{
    return address_is_aligned(finding, address->field, address->address, bytes);
}

/* Whether two ranges certainly share bytes: of one memory, or else of the address space. */
static bool share_bytes(const struct built_address *a, VkDeviceSize a_size,
                        const struct built_address *b, VkDeviceSize b_size)
{
    const bool has_memory =
        a->facts.memory && b->facts.memory && !a->facts.is_sparse && !b->facts.is_sparse;
    const uint64_t a_begin = has_memory ? a->facts.begin : a->address,
                   b_begin = has_memory ? b->facts.begin : b->address;
    if (!is_in_buffer(a) || !is_in_buffer(b) || (has_memory && a->facts.memory != b->facts.memory))
        return false;
    return a_begin < b_begin ? b_size && b_begin - a_begin < a_size
                             : a_size && a_begin - b_begin < b_size;
}

static bool are_apart(const struct built_address *a, VkDeviceSize a_size,
                      const struct built_address *b, VkDeviceSize b_size, struct finding *finding)
{
    return !share_bytes(a, a_size, b, b_size) ||
           violated(finding, a->field, "{} has {} that overlap {} of {} {}", hex(a->address),
                    count_of(a_size, "byte"), count_of(b_size, "byte"), phrase(b->field),
                    hex(b->address));
}

static bool scratch_is_given(const struct built_address *scratch, const struct size_facts *sizes,
                             struct finding *finding)
{
    if (!sizes->known || !sizes->build_scratch)
        return true;
    if (scratch->facts.status == ADDRESS_NULL)
        return violated(finding, scratch->field, "is 0, but buildScratchSize is {}",
                        number(sizes->build_scratch));
    return !leads_nowhere(scratch) || violated_by_nowhere(finding, scratch);
}

static bool is_within_query(struct finding *finding, const char *field, uint32_t count,
                            uint32_t asked, const char *command)
{
    return !asked || count <= asked ||
           violated(finding, field, "{} is greater than {}, the greatest that was passed to {}()",
                    number(count), number(asked), phrase(command));
}

static bool feature_is_enabled(struct finding *finding, bool feature, const char *name)
{
    return feature ||
           violated(finding, "", "requires {}, which is not enabled for the device", phrase(name));
}

/* ---- what clusters are built of */

bool cluster_feature_is_enabled(const struct cluster_input_view *cluster_input,
                                struct finding *finding)
{
    return feature_is_enabled(
        finding, cluster_input->call->device->clusters.feature,
        "VkPhysicalDeviceClusterAccelerationStructureFeaturesNV::clusterAccelerationStructure");
}

bool cluster_vertex_format_is_supported(const struct cluster_triangles_view *cluster_triangles,
                                        struct finding *finding)
{
    return cluster_triangles->vertex_format_supported != NO ||
           violated(
               finding, "vertexFormat",
               "{} does not support VK_FORMAT_FEATURE_ACCELERATION_STRUCTURE_VERTEX_BUFFER_BIT_KHR",
               format(cluster_triangles->input->vertexFormat));
}

static bool is_within(struct finding *finding, const char *field, uint32_t count, uint32_t limit,
                      const char *name)
{
    return count <= limit || violated(finding, field, "{} is greater than {} ({})", number(count),
                                      phrase(name), number(limit));
}

bool cluster_triangle_count_is_within_limit(const struct cluster_triangles_view *cluster_triangles,
                                            struct finding *finding)
{
    return is_within(finding, "maxClusterTriangleCount",
                     cluster_triangles->input->maxClusterTriangleCount,
                     cluster_triangles->call->device->clusters.limits.maxTrianglesPerCluster,
                     "maxTrianglesPerCluster");
}

bool cluster_vertex_count_is_within_limit(const struct cluster_triangles_view *cluster_triangles,
                                          struct finding *finding)
{
    return is_within(finding, "maxClusterVertexCount",
                     cluster_triangles->input->maxClusterVertexCount,
                     cluster_triangles->call->device->clusters.limits.maxVerticesPerCluster,
                     "maxVerticesPerCluster");
}

bool cluster_position_truncate_bits_are_within_32(
    const struct cluster_triangles_view *cluster_triangles, struct finding *finding)
{
    const uint32_t bits = cluster_triangles->input->minPositionTruncateBitCount;
    return bits <= 32 ||
           violated(finding, "minPositionTruncateBitCount", "{} is greater than 32", number(bits));
}

bool cluster_count_is_within_the_query(const struct cluster_build_view *cluster_build,
                                       struct finding *finding)
{
    return is_within_query(finding, "input.maxAccelerationStructureCount",
                           cluster_build->info->input.maxAccelerationStructureCount,
                           cluster_build->asked, "vkGetClusterAccelerationStructureBuildSizesNV");
}

/* ---- dstImplicitData */

static VkClusterAccelerationStructureOpTypeNV op_of(const struct cluster_build_view *build)
{
    return build->info->input.opType;
}

static bool has_mode(const struct cluster_build_view *build,
                     VkClusterAccelerationStructureOpModeNV mode)
{
    return build->info->input.opMode == mode;
}

bool cluster_dst_is_given(const struct cluster_build_view *cluster_build, struct finding *finding)
{
    const struct built_address *dst = &cluster_build->dst;
    if (dst->is_ignored)
        return true;
    if (leads_nowhere(dst))
        return violated_by_nowhere(finding, dst) ||
               is_reported_with(
                   finding,
                   RULE_VkClusterAccelerationStructureCommandsInfoNV_dstImplicitData_parameter);
    return dst->address ||
           violated_plainly(finding, dst->field,
                            "is 0, but opMode is "
                            "VK_CLUSTER_ACCELERATION_STRUCTURE_OP_MODE_IMPLICIT_DESTINATIONS_NV");
}

bool cluster_dst_is_large_enough(const struct cluster_build_view *cluster_build,
                                 struct finding *finding)
{
    return !cluster_build->sizes.known ||
           op_of(cluster_build) == VK_CLUSTER_ACCELERATION_STRUCTURE_OP_TYPE_MOVE_OBJECTS_NV ||
           has_room(&cluster_build->dst, cluster_build->sizes.acceleration_structure,
                    "accelerationStructureSize", finding);
}

bool cluster_dst_has_storage_usage(const struct cluster_build_view *cluster_build,
                                   struct finding *finding)
{
    return HAS_USAGE(&cluster_build->dst, ACCELERATION_STRUCTURE_STORAGE_BIT_KHR, finding);
}

static bool dst_is_aligned(const struct cluster_build_view *build,
                           VkClusterAccelerationStructureOpTypeNV type, uint32_t alignment,
                           const char *name, struct finding *finding)
{
    return op_of(build) != type || is_aligned(&build->dst, alignment, name, finding);
}

bool cluster_dst_is_aligned(const struct cluster_build_view *cluster_build, struct finding *finding)
{
    return dst_is_aligned(cluster_build,
                          VK_CLUSTER_ACCELERATION_STRUCTURE_OP_TYPE_BUILD_TRIANGLE_CLUSTER_NV,
                          cluster_build->call->device->clusters.limits.clusterByteAlignment,
                          "clusterByteAlignment", finding);
}

bool cluster_template_dst_is_aligned(const struct cluster_build_view *cluster_build,
                                     struct finding *finding)
{
    return dst_is_aligned(
        cluster_build, VK_CLUSTER_ACCELERATION_STRUCTURE_OP_TYPE_BUILD_TRIANGLE_CLUSTER_TEMPLATE_NV,
        cluster_build->call->device->clusters.limits.clusterTemplateByteAlignment,
        "clusterTemplateByteAlignment", finding);
}

bool cluster_instance_dst_is_aligned(const struct cluster_build_view *cluster_build,
                                     struct finding *finding)
{
    return dst_is_aligned(cluster_build,
                          VK_CLUSTER_ACCELERATION_STRUCTURE_OP_TYPE_INSTANTIATE_TRIANGLE_CLUSTER_NV,
                          cluster_build->call->device->clusters.limits.clusterByteAlignment,
                          "clusterByteAlignment", finding);
}

/* The size of what is moved is unknown. */
bool cluster_dst_and_scratch_are_apart(const struct cluster_build_view *cluster_build,
                                       struct finding *finding)
{
    const struct size_facts *sizes = &cluster_build->sizes;
    const bool moves =
        op_of(cluster_build) == VK_CLUSTER_ACCELERATION_STRUCTURE_OP_TYPE_MOVE_OBJECTS_NV;
    return !sizes->known ||
           are_apart(&cluster_build->dst, moves ? 1 : sizes->acceleration_structure,
                     &cluster_build->scratch, sizes->build_scratch, finding);
}

/* ---- scratchData */

bool cluster_scratch_is_given(const struct cluster_build_view *cluster_build,
                              struct finding *finding)
{
    const struct built_address *scratch = &cluster_build->scratch;
    if (scratch_is_given(scratch, &cluster_build->sizes, finding))
        return true;
    return leads_nowhere(scratch) &&
           is_reported_with(
               finding, RULE_VkClusterAccelerationStructureCommandsInfoNV_scratchData_parameter);
}

bool cluster_scratch_is_large_enough(const struct cluster_build_view *cluster_build,
                                     struct finding *finding)
{
    return !cluster_build->sizes.known ||
           has_room(&cluster_build->scratch, cluster_build->sizes.build_scratch, "buildScratchSize",
                    finding);
}

bool cluster_scratch_has_storage_usage(const struct cluster_build_view *cluster_build,
                                       struct finding *finding)
{
    return HAS_USAGE(&cluster_build->scratch, STORAGE_BUFFER_BIT, finding);
}

static bool scratch_is_aligned(const struct cluster_build_view *build, struct finding *finding)
{
    return is_aligned(&build->scratch,
                      build->call->device->clusters.limits.clusterScratchByteAlignment,
                      "clusterScratchByteAlignment", finding);
}

bool cluster_scratch_is_aligned(const struct cluster_build_view *cluster_build,
                                struct finding *finding)
{
    return scratch_is_aligned(cluster_build, finding) ||
           also_violates(finding, RULE_cluster_scratch_is_aligned_by_type);
}

bool cluster_scratch_is_aligned_by_type(const struct cluster_build_view *cluster_build,
                                        struct finding *finding)
{
    return scratch_is_aligned(cluster_build, finding) ||
           is_reported_with(finding, RULE_cluster_scratch_is_aligned);
}

/* ---- arrays */

static bool has_stride(const struct built_address *array, VkDeviceSize stride, size_t least,
                       const char *what, struct finding *finding)
{
    return array->is_ignored || stride >= least ||
           violated(finding, array->field, "has stride {}, less than the size of {} ({})",
                    number(stride), phrase(what), number(least));
}

bool cluster_addresses_have_a_stride(const struct cluster_build_view *cluster_build,
                                     struct finding *finding)
{
    return has_stride(&cluster_build->addresses, cluster_build->info->dstAddressesArray.stride,
                      sizeof(VkDeviceAddress), "VkDeviceAddress", finding);
}

bool cluster_sizes_have_a_stride(const struct cluster_build_view *cluster_build,
                                 struct finding *finding)
{
    return has_stride(&cluster_build->dst_sizes, cluster_build->info->dstSizesArray.stride,
                      sizeof(uint32_t), "uint32_t", finding);
}

static bool array_is_given(const struct built_address *array, const char *mode,
                           struct finding *finding)
{
    if (!array->address && !array->is_ignored)
        return violated(finding, array->field, "has address 0, but opMode is {}", phrase(mode));
    return !leads_nowhere(array) || violated_by_nowhere(finding, array);
}

bool cluster_addresses_are_given(const struct cluster_build_view *cluster_build,
                                 struct finding *finding)
{
    return !has_mode(cluster_build,
                     VK_CLUSTER_ACCELERATION_STRUCTURE_OP_MODE_EXPLICIT_DESTINATIONS_NV) ||
           array_is_given(&cluster_build->addresses,
                          "VK_CLUSTER_ACCELERATION_STRUCTURE_OP_MODE_EXPLICIT_DESTINATIONS_NV",
                          finding) ||
           also_violates(finding, RULE_cluster_addresses_are_in_a_storage_buffer);
}

bool cluster_sizes_are_given(const struct cluster_build_view *cluster_build,
                             struct finding *finding)
{
    return !has_mode(cluster_build, VK_CLUSTER_ACCELERATION_STRUCTURE_OP_MODE_COMPUTE_SIZES_NV) ||
           array_is_given(&cluster_build->dst_sizes,
                          "VK_CLUSTER_ACCELERATION_STRUCTURE_OP_MODE_COMPUTE_SIZES_NV", finding);
}

/* The range of an array has buffers under all its bytes. */
static bool is_a_range(const struct built_address *array, VkDeviceSize size,
                       struct finding *finding)
{
    if (array->facts.status == ADDRESS_NULL)
        return violated_plainly(finding, array->field, "has address 0");
    if (leads_nowhere(array))
        return violated_by_nowhere(finding, array);
    return has_room(array, size, "its size", finding);
}

bool cluster_addresses_are_in_a_storage_buffer(const struct cluster_build_view *cluster_build,
                                               struct finding *finding)
{
    const struct built_address *array = &cluster_build->addresses;
    if (!cluster_addresses_are_given(cluster_build, finding))
        return is_reported_with(finding, RULE_cluster_addresses_are_given);
    return is_a_range(array, cluster_build->info->dstAddressesArray.size, finding) &&
           HAS_USAGE(array, STORAGE_BUFFER_BIT, finding);
}

bool cluster_infos_are_in_an_input_buffer(const struct cluster_build_view *cluster_build,
                                          struct finding *finding)
{
    const struct built_address *array = &cluster_build->infos;
    return is_a_range(array, cluster_build->info->srcInfosArray.size, finding) &&
           HAS_USAGE(array, ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_BIT_KHR, finding);
}

bool cluster_infos_have_a_stride(const struct cluster_build_view *cluster_build,
                                 struct finding *finding)
{
    const struct cluster_op *op = cluster_op(op_of(cluster_build));
    return !op || has_stride(&cluster_build->infos, cluster_build->info->srcInfosArray.stride,
                             op->size, op->name, finding);
}

/* Without a count in device memory, a build of one structure or more reads one info or more. */
static bool infos_have_room(const struct cluster_build_view *build,
                            VkClusterAccelerationStructureOpTypeNV type, struct finding *finding)
{
    const struct cluster_op *op = cluster_op(type);
    const VkClusterAccelerationStructureCommandsInfoNV *info = build->info;
    return op_of(build) != type || info->srcInfosCount ||
           !info->input.maxAccelerationStructureCount || info->srcInfosArray.size >= op->size ||
           violated(finding, build->infos.field, "has {}, less than one {} ({})",
                    count_of(info->srcInfosArray.size, "byte"), phrase(op->name), number(op->size));
}

#define HAVE_ROOM(name, op)                                                                        \
    bool name(const struct cluster_build_view *cluster_build, struct finding *finding)             \
    {                                                                                              \
        return infos_have_room(cluster_build, VK_CLUSTER_ACCELERATION_STRUCTURE_OP_TYPE_##op##_NV, \
                               finding);                                                           \
    }
HAVE_ROOM(cluster_moves_have_room, MOVE_OBJECTS)
HAVE_ROOM(cluster_bottom_levels_have_room, BUILD_CLUSTERS_BOTTOM_LEVEL)
HAVE_ROOM(cluster_triangles_have_room, BUILD_TRIANGLE_CLUSTER)
HAVE_ROOM(cluster_templates_have_room, BUILD_TRIANGLE_CLUSTER_TEMPLATE)
HAVE_ROOM(cluster_instances_have_room, INSTANTIATE_TRIANGLE_CLUSTER)
HAVE_ROOM(cluster_template_indices_have_room, GET_CLUSTER_TEMPLATE_INDICES)

bool cluster_count_is_aligned(const struct cluster_build_view *cluster_build,
                              struct finding *finding)
{
    return is_aligned_to(&cluster_build->count, sizeof(uint32_t), finding);
}

bool cluster_count_has_input_usage(const struct cluster_build_view *cluster_build,
                                   struct finding *finding)
{
    return HAS_USAGE(&cluster_build->count, ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_BIT_KHR,
                     finding);
}

/* ---- partitioned structures */

enum { PARTITION_ALIGNMENT = 256 };

bool partition_feature_is_enabled(const struct partition_input_view *partition_input,
                                  struct finding *finding)
{
    return feature_is_enabled(finding, partition_input->call->device->partitions.feature,
                              "VkPhysicalDevicePartitionedAccelerationStructureFeaturesNV::"
                              "partitionedAccelerationStructure");
}

bool partition_count_is_within_limit(const struct partition_input_view *partition_input,
                                     struct finding *finding)
{
    const VkPartitionedAccelerationStructureInstancesInputNV *info = partition_input->info;
    const uint32_t limit = partition_input->call->device->partitions.maximum;
    return (uint64_t)info->partitionCount + info->maxInstanceInGlobalPartitionCount <= limit ||
           violated(
               finding, "partitionCount",
               "{} and maxInstanceInGlobalPartitionCount {} are more than maxPartitionCount ({})",
               number(info->partitionCount), number(info->maxInstanceInGlobalPartitionCount),
               number(limit));
}

#define WITHIN_QUERY(name, member, asked_member)                                                   \
    bool name(const struct partition_build_view *partition_build, struct finding *finding)         \
    {                                                                                              \
        return is_within_query(finding, "input." #member, partition_build->info->input.member,     \
                               partition_build->asked.asked_member,                                \
                               "vkGetPartitionedAccelerationStructuresBuildSizesNV");              \
    }
WITHIN_QUERY(partition_instances_are_within_the_query, instanceCount, instances)
WITHIN_QUERY(partition_instances_per_partition_are_within_the_query, maxInstancePerPartitionCount,
             instances_per_partition)
WITHIN_QUERY(partitions_are_within_the_query, partitionCount, partitions)
WITHIN_QUERY(partition_global_instances_are_within_the_query, maxInstanceInGlobalPartitionCount,
             global_instances)

bool partition_scratch_is_given(const struct partition_build_view *partition_build,
                                struct finding *finding)
{
    return scratch_is_given(&partition_build->scratch, &partition_build->sizes, finding);
}

static bool scratch_has_room(const struct partition_build_view *build, struct finding *finding)
{
    return !build->sizes.known ||
           has_room(&build->scratch, build->sizes.build_scratch, "buildScratchSize", finding);
}

bool partition_scratch_is_large_enough(const struct partition_build_view *partition_build,
                                       struct finding *finding)
{
    return scratch_has_room(partition_build, finding) ||
           also_violates(finding, RULE_partition_scratch_has_the_queried_size);
}

bool partition_scratch_has_the_queried_size(const struct partition_build_view *partition_build,
                                            struct finding *finding)
{
    return scratch_has_room(partition_build, finding) ||
           is_reported_with(finding, RULE_partition_scratch_is_large_enough);
}

bool partition_scratch_is_aligned(const struct partition_build_view *partition_build,
                                  struct finding *finding)
{
    return is_aligned_to(&partition_build->scratch, PARTITION_ALIGNMENT, finding);
}

bool partition_scratch_has_storage_usage(const struct partition_build_view *partition_build,
                                         struct finding *finding)
{
    return HAS_USAGE(&partition_build->scratch, STORAGE_BUFFER_BIT, finding);
}

static bool dst_has_room(const struct partition_build_view *build, struct finding *finding)
{
    return !build->sizes.known || has_room(&build->dst, build->sizes.acceleration_structure,
                                           "accelerationStructureSize", finding);
}

bool partition_dst_is_large_enough(const struct partition_build_view *partition_build,
                                   struct finding *finding)
{
    return dst_has_room(partition_build, finding) ||
           also_violates(finding, RULE_partition_dst_has_the_queried_size);
}

bool partition_dst_has_the_queried_size(const struct partition_build_view *partition_build,
                                        struct finding *finding)
{
    return dst_has_room(partition_build, finding) ||
           is_reported_with(finding, RULE_partition_dst_is_large_enough);
}

bool partition_src_is_aligned(const struct partition_build_view *partition_build,
                              struct finding *finding)
{
    return is_aligned_to(&partition_build->src, PARTITION_ALIGNMENT, finding);
}

bool partition_dst_is_aligned(const struct partition_build_view *partition_build,
                              struct finding *finding)
{
    return is_aligned_to(&partition_build->dst, PARTITION_ALIGNMENT, finding);
}

bool partition_structures_have_storage_usage(const struct partition_build_view *partition_build,
                                             struct finding *finding)
{
    return HAS_USAGE(&partition_build->src, ACCELERATION_STRUCTURE_STORAGE_BIT_KHR, finding) &&
           HAS_USAGE(&partition_build->dst, ACCELERATION_STRUCTURE_STORAGE_BIT_KHR, finding);
}

/* How large src was built is unknown: at least one byte. */
bool partition_src_and_scratch_are_apart(const struct partition_build_view *partition_build,
                                         struct finding *finding)
{
    const struct size_facts *sizes = &partition_build->sizes;
    return !sizes->known || are_apart(&partition_build->src, 1, &partition_build->scratch,
                                      sizes->build_scratch, finding);
}

bool partition_dst_and_scratch_are_apart(const struct partition_build_view *partition_build,
                                         struct finding *finding)
{
    const struct size_facts *sizes = &partition_build->sizes;
    return !sizes->known || are_apart(&partition_build->dst, sizes->acceleration_structure,
                                      &partition_build->scratch, sizes->build_scratch, finding);
}

bool partition_src_and_dst_are_apart(const struct partition_build_view *partition_build,
                                     struct finding *finding)
{
    const struct built_address *src = &partition_build->src, *dst = &partition_build->dst;
    return !partition_build->sizes.known || src->address == dst->address ||
           are_apart(src, 1, dst, partition_build->sizes.acceleration_structure, finding);
}

bool partition_inputs_have_input_usage(const struct partition_build_view *partition_build,
                                       struct finding *finding)
{
    return HAS_USAGE(&partition_build->infos, ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_BIT_KHR,
                     finding) &&
           HAS_USAGE(&partition_build->count, ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_BIT_KHR,
                     finding);
}

bool partition_count_is_aligned(const struct partition_build_view *partition_build,
                                struct finding *finding)
{
    return is_aligned_to(&partition_build->count, sizeof(uint32_t), finding);
}

/* ---- descriptors */

#define DESCRIPTORS "pNext<VkWriteDescriptorSetPartitionedAccelerationStructureNV>."

bool partition_descriptors_have_structures(
    const struct partition_descriptors_view *partition_descriptors, struct finding *finding)
{
    const uint32_t count = partition_descriptors->info->accelerationStructureCount,
                   descriptors = partition_descriptors->write->descriptorCount;
    return count == descriptors ||
           violated(finding, DESCRIPTORS "accelerationStructureCount",
                    "{} differs from descriptorCount ({})", number(count), number(descriptors)) ||
           (!count &&
            is_reported_with(
                finding,
                RULE_VkWriteDescriptorSetPartitionedAccelerationStructureNV_accelerationStructureCount_arraylength));
}

bool partition_descriptor_is_of_a_structure(
    const struct partition_descriptor_view *partition_descriptor, struct finding *finding)
{
    const struct address_facts *facts = &partition_descriptor->facts;
    return facts->status != ADDRESS_NOWHERE ||
           violated(finding, DESCRIPTORS "pAccelerationStructures[]",
                    "{} is in no buffer whose address was retrieved",
                    address_of_missing(VK_OBJECT_TYPE_BUFFER, facts->address));
}
