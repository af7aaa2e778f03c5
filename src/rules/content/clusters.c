/* SPDX-License-Identifier: Apache-2.0 */
/* Rules about what builds of clusters and of partitioned structures have read in device memory. */
#include "src/model/formats.h"
#include "src/rules/predicates.h"
#include "src/view/names.h"

/* ---- clusters: counts and destinations */

static const VkClusterAccelerationStructureCommandsInfoNV *
info_of(const struct cluster_read_view *read)
{
    return &read->build->clusters.info;
}

bool cluster_count_is_within_the_maximum(const struct cluster_read_view *cluster_read,
                                         struct finding *finding)
{
    const uint32_t most = info_of(cluster_read)->input.maxAccelerationStructureCount;
    return !cluster_read->has_count || cluster_read->count <= most ||
           violated(finding, "srcInfosCount",
                    "leads to count {}, which is greater than input.maxAccelerationStructureCount "
                    "({})",
                    number(cluster_read->count), number(most));
}

bool cluster_count_is_within_the_array(const struct cluster_read_view *cluster_read,
                                       struct finding *finding)
{
    const VkStridedDeviceAddressRegionKHR *array = &info_of(cluster_read)->srcInfosArray;
    const uint64_t room = array->stride ? array->size / array->stride : UINT64_MAX;
    return !cluster_read->has_count || cluster_read->infos <= room ||
           violated(finding, "srcInfosCount",
                    "leads to count {}, but srcInfosArray has {} with stride {}",
                    number(cluster_read->count), count_of(array->size, "byte"),
                    number(array->stride));
}

bool cluster_references_are_within_the_maximum(const struct cluster_read_view *cluster_read,
                                               struct finding *finding)
{
    const VkClusterAccelerationStructureClustersBottomLevelInputNV *input =
        &cluster_read->build->clusters.bottom_level;
    if (cluster_read->most_references > input->maxClusterCountPerAccelerationStructure)
        return violated(finding, "srcInfosArray",
                        "leads to structure {}, whose clusterReferencesCount {} is greater than "
                        "maxClusterCountPerAccelerationStructure ({})",
                        number(cluster_read->most_index), number(cluster_read->most_references),
                        number(input->maxClusterCountPerAccelerationStructure));
    return cluster_read->references <= input->maxTotalClusterCount ||
           violated(finding, "srcInfosArray",
                    "leads to {} in all, which is more than maxTotalClusterCount ({})",
                    count_of(cluster_read->references, "cluster reference"),
                    number(input->maxTotalClusterCount));
}

/* Rules about implicit destinations require the same of explicit ones. */
static enum rule rule_of_alignment(const struct cluster_read_view *read)
{
    switch ((int)info_of(read)->input.opType) {
    case VK_CLUSTER_ACCELERATION_STRUCTURE_OP_TYPE_BUILD_TRIANGLE_CLUSTER_NV:
        return RULE_cluster_dst_is_aligned;
    case VK_CLUSTER_ACCELERATION_STRUCTURE_OP_TYPE_BUILD_TRIANGLE_CLUSTER_TEMPLATE_NV:
        return RULE_cluster_template_dst_is_aligned;
    case VK_CLUSTER_ACCELERATION_STRUCTURE_OP_TYPE_INSTANTIATE_TRIANGLE_CLUSTER_NV:
        return RULE_cluster_instance_dst_is_aligned;
    default:
        return RULE_COUNT;
    }
}

#define DST "dstAddressesArray"

bool cluster_dsts_are_aligned(const struct cluster_read_view *cluster_read, struct finding *finding)
{
    const struct cluster_dst *dst = cluster_read->misaligned;
    const enum rule also = rule_of_alignment(cluster_read);
    if (!dst)
        return true;
    return violated(finding, DST, "leads to address {}, {}, which is not a multiple of {}",
                    number(dst->index), hex(dst->facts.address), number(cluster_read->alignment)) ||
           (also != RULE_COUNT && also_violates(finding, also));
}

bool cluster_dsts_have_storage_usage(const struct cluster_read_view *cluster_read,
                                     struct finding *finding)
{
    const struct cluster_dst *dst = cluster_read->unusable;
    if (!dst)
        return true;
    if (dst->facts.status != ADDRESS_IN_BUFFER)
        return violated(finding, DST, "leads to address {}, {}, which is in no buffer",
                        number(dst->index),
                        address_of_missing(VK_OBJECT_TYPE_BUFFER, dst->facts.address));
    return violated(finding, DST,
                    "leads to address {}, {}, which is in {}, which was created with usage {}, "
                    "without VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_STORAGE_BIT_KHR",
                    number(dst->index), hex(dst->facts.address),
                    object(VK_OBJECT_TYPE_BUFFER, handle_number(dst->facts.buffer)),
                    buffer_usage(dst->facts.usage));
}

/* Two structures at one address share memory. */
bool cluster_dsts_are_apart(const struct cluster_read_view *cluster_read, struct finding *finding)
{
    const struct cluster_dst *dst = cluster_read->repeated;
    return !dst ||
           violated(finding, DST, "leads to the same address {} at indices {} and {}",
                    hex(dst->facts.address), number(dst->same), number(dst->index)) ||
           also_violates(finding, RULE_cluster_dsts_and_scratch_are_apart);
}

bool cluster_dsts_and_scratch_are_apart(const struct cluster_read_view *cluster_read,
                                        struct finding *finding)
{
    const struct cluster_dst *dst = cluster_read->in_scratch;
    if (!cluster_dsts_are_apart(cluster_read, finding))
        return is_reported_with(finding, RULE_cluster_dsts_are_apart);
    return !dst || violated(finding, DST,
                            "leads to address {}, {}, which is among the {} of scratchData {}",
                            number(dst->index), hex(dst->facts.address),
                            count_of(cluster_read->build->scratch_size, "byte"),
                            hex(info_of(cluster_read)->scratchData));
}

/* ---- clusters: what is built */

typedef bool cluster_check(const struct cluster_info_view *info, struct finding *finding);

static bool is_of(const struct cluster_info_view *info, VkClusterAccelerationStructureOpTypeNV type)
{
    return info->triangles && info->build->clusters.info.input.opType == type;
}

static const struct cluster_support *support_of(const struct cluster_info_view *info)
{
    return &info->call->device->clusters;
}

static bool is_within(struct finding *finding, const char *field, uint64_t value, uint32_t limit,
                      const char *name)
{
    return value <= limit || violated(finding, field, "{} is greater than {} ({})", number(value),
                                      phrase(name), number(limit));
}

static bool is_less(struct finding *finding, const char *field, uint64_t value, uint32_t limit,
                    const char *name)
{
    return value < limit || violated(finding, field, "{} is not less than {} ({})", number(value),
                                     phrase(name), number(limit));
}

static bool id_is_valid(const struct cluster_info_view *info, struct finding *finding)
{
    return info->triangles->clusterID != UINT32_MAX ||
           violated_plainly(finding, "clusterID", "is 0xffffffff");
}

static bool triangle_count_is_within_limit(const struct cluster_info_view *info,
                                           struct finding *finding)
{
    return is_within(finding, "triangleCount", info->triangles->triangleCount,
                     support_of(info)->limits.maxTrianglesPerCluster, "maxTrianglesPerCluster");
}

static bool vertex_count_is_within_limit(const struct cluster_info_view *info,
                                         struct finding *finding)
{
    return is_within(finding, "vertexCount", info->triangles->vertexCount,
                     support_of(info)->limits.maxVerticesPerCluster, "maxVerticesPerCluster");
}

static bool is_one_bit(uint32_t bits)
{
    return bits && !(bits & (bits - 1));
}

static bool index_type_is_one_bit(const struct cluster_info_view *info, struct finding *finding)
{
    const uint32_t type = info->triangles->indexType;
    return is_one_bit(type) || violated(finding, "indexType", "{} is not one bit", hex(type));
}

/* Without micromaps, no bit says something, too. */
static bool opacity_index_type_is_one_bit(const struct cluster_info_view *info,
                                          struct finding *finding)
{
    const uint32_t type = info->triangles->opacityMicromapIndexType;
    return is_one_bit(type) || (!type && !info->triangles->opacityMicromapArray) ||
           violated(finding, "opacityMicromapIndexType", "{} is not one bit", hex(type));
}

static bool truncate_bits_are_within_range(const struct cluster_info_view *info,
                                           struct finding *finding)
{
    const uint32_t bits = info->triangles->positionTruncateBitCount,
                   least = info->build->clusters.triangles.minPositionTruncateBitCount;
    return (bits >= least && bits <= 32) ||
           violated(finding, "positionTruncateBitCount",
                    "{} is not between minPositionTruncateBitCount ({}) and 32", number(bits),
                    number(least));
}

_Static_assert(VK_CLUSTER_ACCELERATION_STRUCTURE_INDEX_FORMAT_8BIT_NV == 1 &&
                   VK_CLUSTER_ACCELERATION_STRUCTURE_INDEX_FORMAT_16BIT_NV == 2 &&
                   VK_CLUSTER_ACCELERATION_STRUCTURE_INDEX_FORMAT_32BIT_NV == 4,
               "each bit is the size of an index in bytes");

static bool index_stride_is_aligned(const struct cluster_info_view *info, struct finding *finding)
{
    const uint32_t size = info->triangles->indexType, stride = info->triangles->indexBufferStride;
    return !is_one_bit(size) || stride % size == 0 ||
           violated(finding, "indexBufferStride", "{} is not a multiple of the {} of an index",
                    number(stride), count_of(size, "byte"));
}

static bool vertex_stride_fits_the_format(const struct cluster_info_view *info,
                                          struct finding *finding)
{
    const VkFormat of_vertices = info->build->clusters.triangles.vertexFormat;
    const uint32_t size = format_smallest_component(of_vertices),
                   stride = info->triangles->vertexBufferStride;
    return !size || stride % size == 0 ||
           violated(finding, "vertexBufferStride",
                    "{} is not a multiple of the {} of a component of {}", number(stride),
                    count_of(size, "byte"), format(of_vertices));
}

/* Geometries of triangles may only raise the base. */
static bool geometry_index_is_within_limit(const struct cluster_info_view *info,
                                           struct finding *finding)
{
    const struct triangle_geometry *wrong = info->wrong_index;
    if (wrong)
        return violated(finding, "geometryIndexAndFlagsBuffer",
                        "leads to geometryIndex {} of triangle {}, which is not less than "
                        "maxClusterGeometryIndex ({})",
                        number(wrong->geometry.geometryIndex), number(wrong->triangle),
                        number(support_of(info)->limits.maxClusterGeometryIndex));
    return is_less(finding, "baseGeometryIndexAndGeometryFlags.geometryIndex",
                   info->triangles->baseGeometryIndexAndGeometryFlags.geometryIndex,
                   support_of(info)->limits.maxClusterGeometryIndex, "maxClusterGeometryIndex");
}

static bool has_flag_for_micromaps(const struct cluster_info_view *info, struct finding *finding)
{
    const VkBuildAccelerationStructureFlagsKHR flags = info->build->clusters.info.input.flags;
    return !info->triangles->opacityMicromapArray ||
           flags & VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_CLUSTER_OPACITY_MICROMAPS_BIT_NV ||
           violated(finding, "opacityMicromapArray",
                    "{} is not 0, but input.flags {} lack "
                    "VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_CLUSTER_OPACITY_MICROMAPS_BIT_NV",
                    hex(info->triangles->opacityMicromapArray), build_flags(flags));
}

/* Clusters and templates have the same rules. */
#define BOTH(cluster, template, check)                                                              \
    bool cluster(const struct cluster_info_view *cluster_info, struct finding *finding)             \
    {                                                                                               \
        return !is_of(cluster_info,                                                                 \
                      VK_CLUSTER_ACCELERATION_STRUCTURE_OP_TYPE_BUILD_TRIANGLE_CLUSTER_NV) ||       \
               check(cluster_info, finding);                                                        \
    }                                                                                               \
    bool template(const struct cluster_info_view *cluster_info, struct finding *finding)            \
    {                                                                                               \
        return !is_of(                                                                              \
                   cluster_info,                                                                    \
                   VK_CLUSTER_ACCELERATION_STRUCTURE_OP_TYPE_BUILD_TRIANGLE_CLUSTER_TEMPLATE_NV) || \
               check(cluster_info, finding);                                                        \
    }
BOTH(cluster_id_is_valid, template_id_is_valid, id_is_valid)
BOTH(cluster_triangle_count_read_is_within_limit, template_triangle_count_read_is_within_limit,
     triangle_count_is_within_limit)
BOTH(cluster_vertex_count_read_is_within_limit, template_vertex_count_read_is_within_limit,
     vertex_count_is_within_limit)
BOTH(cluster_index_type_is_one_bit, template_index_type_is_one_bit, index_type_is_one_bit)
BOTH(cluster_opacity_index_type_is_one_bit, template_opacity_index_type_is_one_bit,
     opacity_index_type_is_one_bit)
BOTH(cluster_truncate_bits_are_within_range, template_truncate_bits_are_within_range,
     truncate_bits_are_within_range)
BOTH(cluster_index_stride_is_aligned, template_index_stride_is_aligned, index_stride_is_aligned)
BOTH(cluster_vertex_stride_fits_the_format, template_vertex_stride_fits_the_format,
     vertex_stride_fits_the_format)
BOTH(cluster_geometry_index_is_within_limit, template_geometry_index_is_within_limit,
     geometry_index_is_within_limit)
BOTH(cluster_has_flag_for_micromaps, template_has_flag_for_micromaps, has_flag_for_micromaps)

bool cluster_geometry_reserves_bits(const struct cluster_info_view *cluster_info,
                                    struct finding *finding)
{
    const struct triangle_geometry *wrong = cluster_info->wrong_reserved;
    const uint32_t reserved =
        cluster_info->triangles
            ? cluster_info->triangles->baseGeometryIndexAndGeometryFlags.reserved
            : 0;
    if (wrong)
        return violated(finding, "geometryIndexAndFlagsBuffer",
                        "leads to reserved {} of triangle {}, which is not 0",
                        hex(wrong->geometry.reserved), number(wrong->triangle));
    return !reserved || violated(finding, "baseGeometryIndexAndGeometryFlags.reserved",
                                 "{} is not 0", hex(reserved));
}

bool template_bounds_are_aligned(const struct cluster_info_view *cluster_info,
                                 struct finding *finding)
{
    const uint32_t alignment = support_of(cluster_info)->limits.clusterTemplateBoundsByteAlignment;
    return !is_of(cluster_info,
                  VK_CLUSTER_ACCELERATION_STRUCTURE_OP_TYPE_BUILD_TRIANGLE_CLUSTER_TEMPLATE_NV) ||
           !alignment || cluster_info->triangles->instantiationBoundingBoxLimit % alignment == 0 ||
           violated(finding, "instantiationBoundingBoxLimit",
                    "{} is not a multiple of clusterTemplateBoundsByteAlignment ({})",
                    hex(cluster_info->triangles->instantiationBoundingBoxLimit), number(alignment));
}

bool cluster_instance_reserves_bits(const struct cluster_info_view *cluster_info,
                                    struct finding *finding)
{
    const VkClusterAccelerationStructureInstantiateClusterInfoNV *instance = cluster_info->instance;
    return !instance || !instance->reserved ||
           violated(finding, "reserved", "{} is not 0", hex(instance->reserved));
}

bool cluster_instance_geometry_index_is_within_limit(const struct cluster_info_view *cluster_info,
                                                     struct finding *finding)
{
    const VkClusterAccelerationStructureInstantiateClusterInfoNV *instance = cluster_info->instance;
    return !instance || is_less(finding, "geometryIndexOffset", instance->geometryIndexOffset,
                                support_of(cluster_info)->limits.maxClusterGeometryIndex,
                                "maxClusterGeometryIndex");
}

bool cluster_instance_has_vertices(const struct cluster_info_view *cluster_info,
                                   struct finding *finding)
{
    const VkClusterAccelerationStructureInstantiateClusterInfoNV *instance = cluster_info->instance;
    return !instance || instance->vertexBuffer.startAddress ||
           !cluster_info->template.has_no_vertices ||
           violated(finding, "vertexBuffer",
                    "is 0, but the template at clusterTemplateAddress {} was built without "
                    "vertices",
                    hex(instance->clusterTemplateAddress));
}

bool cluster_instance_has_the_format_of_its_template(const struct cluster_info_view *cluster_info,
                                                     struct finding *finding)
{
    const VkClusterAccelerationStructureInstantiateClusterInfoNV *instance = cluster_info->instance;
    const VkFormat built = cluster_info->template.format,
                   given = cluster_info->build->clusters.triangles.vertexFormat;
    return !instance || !instance->vertexBuffer.startAddress || built == VK_FORMAT_UNDEFINED ||
           built == given ||
           violated(finding, "vertexBuffer",
                    "is of vertexFormat {}, but the template at clusterTemplateAddress {} was "
                    "built for {}",
                    format(given), hex(instance->clusterTemplateAddress), format(built));
}

bool cluster_references_have_a_stride(const struct cluster_info_view *cluster_info,
                                      struct finding *finding)
{
    return !cluster_info->bottom_level ||
           cluster_info->bottom_level->clusterReferencesStride >= sizeof(VkDeviceAddress) ||
           violated(finding, "clusterReferencesStride", "{} is less than 8",
                    number(cluster_info->bottom_level->clusterReferencesStride));
}

bool cluster_references_have_room(const struct cluster_info_view *cluster_info,
                                  struct finding *finding)
{
    const VkClusterAccelerationStructureBuildClustersBottomLevelInfoNV *info =
        cluster_info->bottom_level;
    const struct address_facts *facts = &cluster_info->references;
    if (!info || !info->clusterReferencesCount || facts->status != ADDRESS_IN_BUFFER)
        return true;
    const uint64_t size =
        (info->clusterReferencesCount - 1ull) * info->clusterReferencesStride + sizeof(uint64_t);
    return size <= facts->bytes_left ||
           violated(finding, "clusterReferences", "{} leaves {} to the end of {}, but {} take {}",
                    hex(facts->address), count_of(facts->bytes_left, "byte"),
                    object(VK_OBJECT_TYPE_BUFFER, handle_number(facts->buffer)),
                    count_of(info->clusterReferencesCount, "reference"), count_of(size, "byte"));
}

bool cluster_references_are_unique(const struct cluster_info_view *cluster_info,
                                   struct finding *finding)
{
    return cluster_info->first_same == cluster_info->second_same ||
           violated(finding, "clusterReferences", "leads to the same cluster at indices {} and {}",
                    number(cluster_info->first_same), number(cluster_info->second_same));
}

bool cluster_move_is_of_a_cluster(const struct cluster_info_view *cluster_info,
                                  struct finding *finding)
{
    return !cluster_info->unbuilt_move ||
           violated(finding, "srcAccelerationStructure",
                    "{} is an address at which no command builds a cluster, a template or a "
                    "bottom-level structure of clusters",
                    hex(cluster_info->unbuilt_move));
}

bool cluster_indices_are_of_a_template(const struct cluster_info_view *cluster_info,
                                       struct finding *finding)
{
    return !cluster_info->unbuilt_template ||
           violated(finding, "clusterTemplateAddress",
                    "{} is an address at which no command builds a template",
                    hex(cluster_info->unbuilt_template));
}

/* ---- partitioned structures */

bool partition_src_is_built(const struct partition_read_view *partition_read,
                            struct finding *finding)
{
    return !partition_read->src_is_unbuilt ||
           violated(finding, "srcAccelerationStructureData",
                    "{} is an address at which no command builds a partitioned structure",
                    hex(partition_read->build->partitions.info.srcAccelerationStructureData));
}

bool partition_infos_have_room(const struct partition_read_view *partition_read,
                               struct finding *finding)
{
    const struct address_facts *infos = &partition_read->infos;
    const uint64_t size = (uint64_t)partition_read->count *
                          sizeof(VkBuildPartitionedAccelerationStructureIndirectCommandNV);
    return infos->status != ADDRESS_IN_BUFFER || size <= infos->bytes_left ||
           violated(finding, "srcInfos",
                    "{} leaves {} to the end of {}, but the count {} at srcInfosCount needs {}",
                    hex(infos->address), count_of(infos->bytes_left, "byte"),
                    object(VK_OBJECT_TYPE_BUFFER, handle_number(infos->buffer)),
                    number(partition_read->count), count_of(size, "byte"));
}

bool partition_operations_are_unique(const struct partition_read_view *partition_read,
                                     struct finding *finding)
{
    return !partition_read->repeats_operation ||
           violated(finding, "srcInfos", "leads to more than one operation of opType {}",
                    number(partition_read->operation));
}

bool partition_instances_are_unique(const struct partition_read_view *partition_read,
                                    struct finding *finding)
{
    return !partition_read->repeats_instance ||
           violated(finding, "srcInfos", "leads to an argData with more than one instanceIndex {}",
                    number(partition_read->instance));
}

static const VkPartitionedAccelerationStructureInstancesInputNV *
input_of(const struct partition_operation_view *operation)
{
    return &operation->build->partitions.info.input;
}

bool partition_mask_has_8_bits(const struct partition_operation_view *partition_operation,
                               struct finding *finding)
{
    const uint32_t mask = partition_operation->write ? partition_operation->write->instanceMask : 0;
    return mask <= UINT8_MAX ||
           violated(finding, "argData[].instanceMask", "{} has more than 8 bits", hex(mask));
}

static bool has_24_bits(struct finding *finding, uint32_t contribution)
{
    return !(contribution >> 24) ||
           violated(finding, "argData[].instanceContributionToHitGroupIndex",
                    "{} has more than 24 bits", hex(contribution));
}

bool written_hit_group_index_has_24_bits(const struct partition_operation_view *partition_operation,
                                         struct finding *finding)
{
    return !partition_operation->write ||
           has_24_bits(finding, partition_operation->write->instanceContributionToHitGroupIndex);
}

bool updated_hit_group_index_has_24_bits(const struct partition_operation_view *partition_operation,
                                         struct finding *finding)
{
    return !partition_operation->update ||
           has_24_bits(finding, partition_operation->update->instanceContributionToHitGroupIndex);
}

bool written_instance_is_within_the_count(
    const struct partition_operation_view *partition_operation, struct finding *finding)
{
    return !partition_operation->write ||
           is_less(finding, "argData[].instanceIndex", partition_operation->write->instanceIndex,
                   input_of(partition_operation)->instanceCount, "input.instanceCount");
}

bool updated_instance_may_be_updated(const struct partition_operation_view *partition_operation,
                                     struct finding *finding)
{
    return !partition_operation->updates_fixed_instance ||
           violated(finding, "argData[].instanceIndex",
                    "{} was written with an acceleration structure, and without explicit bounds",
                    number(partition_operation->update->instanceIndex));
}

bool updated_instance_is_within_the_count(
    const struct partition_operation_view *partition_operation, struct finding *finding)
{
    return !partition_operation->update ||
           is_less(finding, "argData[].instanceIndex", partition_operation->update->instanceIndex,
                   input_of(partition_operation)->instanceCount, "input.instanceCount");
}

static bool partition_is_within_the_count(const struct partition_operation_view *operation,
                                          uint32_t index, struct finding *finding)
{
    return index == VK_PARTITIONED_ACCELERATION_STRUCTURE_PARTITION_INDEX_GLOBAL_NV ||
           is_less(finding, "argData[].partitionIndex", index, input_of(operation)->partitionCount,
                   "input.partitionCount");
}

bool written_partition_is_within_the_count(
    const struct partition_operation_view *partition_operation, struct finding *finding)
{
    return !partition_operation->write ||
           partition_is_within_the_count(partition_operation,
                                         partition_operation->write->partitionIndex, finding);
}

bool translated_partition_is_within_the_count(
    const struct partition_operation_view *partition_operation, struct finding *finding)
{
    return !partition_operation->translation ||
           partition_is_within_the_count(partition_operation,
                                         partition_operation->translation->partitionIndex, finding);
}

/* A NaN is in no order. */
bool explicit_bounds_are_valid(const struct partition_operation_view *partition_operation,
                               struct finding *finding)
{
    const VkPartitionedAccelerationStructureWriteInstanceDataNV *write = partition_operation->write;
    if (!write ||
        !(write->instanceFlags &
          VK_PARTITIONED_ACCELERATION_STRUCTURE_INSTANCE_FLAG_ENABLE_EXPLICIT_BOUNDING_BOX_NV))
        return true;
    for (uint32_t i = 0; i < 3; i++)
        if (!(write->explicitAABB[i] <= write->explicitAABB[i + 3]))
            return violated(finding, "argData[].explicitAABB",
                            "has the minimum {} and the maximum {} of coordinate {}",
                            real((double)write->explicitAABB[i]),
                            real((double)write->explicitAABB[i + 3]), number(i));
    return true;
}

bool translation_is_enabled(const struct partition_operation_view *partition_operation,
                            struct finding *finding)
{
    return !partition_operation->translation || partition_operation->build->partitions.translates ||
           violated_plainly(finding, "opType",
                            "writes translations of partitions, but the build lacks "
                            "enablePartitionTranslation");
}
