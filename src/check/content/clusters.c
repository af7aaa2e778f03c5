/* SPDX-License-Identifier: Apache-2.0 */
/* Makes the views of what builds of clusters and of partitioned structures have read. Of an array,
 * only the mistakes of the first wrong element are reported. */
#include "src/check/content/clusters.h"

#include <string.h>

#include "src/base/handle_table.h"
#include "src/check/life/life.h"
#include "src/check/walk/rows.h"

/* The copies of one build. */
struct copied {
    struct walk *walk;
    const struct call_view *call;
    const struct addressed_build *build;
    const struct input_memory *memory;
    uint64_t place; /* see struct addressed_read */
    uint32_t number;
    bool addresses_are_known; /* no buffer was destroyed since the submission */
    bool earlier_is_known;    /* all builds of places before this one were read */
};

/* Reads one element; missing bytes become zeros. Returns how many bytes are known. */
static uint64_t read_element(const struct copied *copied, uint64_t address, void *element,
                             size_t size)
{
    const void *bytes;
    memset(element, 0, size);
    const uint64_t found = copied->memory->find(copied->memory->context, address, size, &bytes);
    if (found)
        memcpy(element, bytes, (size_t)found);
    return found;
}

static bool read_whole(const struct copied *copied, uint64_t address, void *element, size_t size)
{
    return read_element(copied, address, element, size) == size;
}

/* The address of what a member of a build of clusters leads to, which may be in device memory. 0:
 * it is not known. */
static VkDeviceAddress resolve(const struct copied *copied, enum addressed_member member,
                               VkDeviceAddress address)
{
    const VkClusterAccelerationStructureCommandsInfoNV *info = &copied->build->clusters.info;
    VkDeviceAddress resolved = 0;
    if (!cluster_member_is_indirect(info, member))
        return address;
    return read_whole(copied, address, &resolved, sizeof(resolved)) ? resolved : 0;
}

static struct address_facts look_up(const struct copied *copied, uint64_t address)
{
    struct address_facts facts = {.address = address, .status = ADDRESS_UNKNOWN};
    if (copied->addresses_are_known)
        resources_look_up_address(copied->walk->context->resources, address, &facts);
    return facts;
}

/* What was accessed in memory that is still there. */
static void report_access(const struct copied *copied, const struct addressed_range *range)
{
    const struct check_context *context = copied->walk->context;
    if (context->hooks->on_access && copied->addresses_are_known && range->address)
        context->hooks->on_access(context->user, copied->number, copied->build->is_partitioned,
                                  range);
}

/* A structure that is read, or is built, at an address. */
static void report_structure(const struct copied *copied, bool is_written, uint64_t address)
{
    report_access(copied, &(struct addressed_range){.member = ADDRESSED_MEMBERS,
                                                    .is_written = is_written,
                                                    .address = address,
                                                    .count = 1,
                                                    .size = 1});
}

/* What a build of clusters accesses because the device has read that there is something to build.
 */
static void report_ranges(const struct copied *copied, uint32_t infos)
{
    struct addressed_range ranges[ADDRESSED_MEMBERS];
    const uint32_t count = infos && copied->build->clusters.info.srcInfosCount
                               ? addressed_ranges(copied->build, infos, ranges)
                               : 0;
    for (uint32_t i = 0; i < count; i++)
        if (ranges[i].member != ADDRESSED_COUNT) /* as the journal says */
            report_access(copied, &ranges[i]);
}

/* Without a stride all elements are one: two tell as much as all. */
static uint32_t elements_of(uint32_t count, uint64_t stride)
{
    return stride || count < 2 ? count : 2;
}

/* The element of an array in device memory. */
static struct location element_of(const struct copied *copied, const char *array, uint32_t index)
{
    return check_element(copied->call, array, index);
}

/* Returns the index at which the value was noted before, or `index`. Without memory it is new. */
static uint32_t note_value(struct handle_table *table, uint64_t value, uint32_t index)
{
    const uintptr_t known = (uintptr_t)handle_table_find(table, value);
    if (known)
        return (uint32_t)(known - 1);
    handle_table_set(table, value, (void *)((uintptr_t)index + 1)); // NOLINT
    return index;
}

/* ---- clusters */

static uint32_t alignment_of(const struct copied *copied)
{
    const VkPhysicalDeviceClusterAccelerationStructurePropertiesNV *limits =
        &copied->call->device->clusters.limits;
    switch ((int)copied->build->clusters.info.input.opType) {
    case VK_CLUSTER_ACCELERATION_STRUCTURE_OP_TYPE_BUILD_CLUSTERS_BOTTOM_LEVEL_NV:
        return limits->clusterBottomLevelByteAlignment;
    case VK_CLUSTER_ACCELERATION_STRUCTURE_OP_TYPE_BUILD_TRIANGLE_CLUSTER_TEMPLATE_NV:
        return limits->clusterTemplateByteAlignment;
    case VK_CLUSTER_ACCELERATION_STRUCTURE_OP_TYPE_BUILD_TRIANGLE_CLUSTER_NV:
    case VK_CLUSTER_ACCELERATION_STRUCTURE_OP_TYPE_INSTANTIATE_TRIANGLE_CLUSTER_NV:
        return limits->clusterByteAlignment;
    default: /* what is moved decides, and indices of templates have no alignment */
        return 0;
    }
}

struct wrong_dsts {
    struct cluster_dst misaligned, unusable, repeated, in_scratch;
};

static void find_wrong(const struct cluster_dst **found, struct cluster_dst *place,
                       const struct cluster_dst *dst, bool is_wrong)
{
    if (!is_wrong || *found)
        return;
    *place = *dst;
    *found = place;
}

/* Explicit destinations, which the build has read. */
static void read_dsts(const struct copied *copied, struct cluster_read_view *view,
                      struct wrong_dsts *wrong)
{
    const VkClusterAccelerationStructureCommandsInfoNV *info = &copied->build->clusters.info;
    const VkStridedDeviceAddressRegionKHR *array = &info->dstAddressesArray;
    const VkDeviceAddress addresses = resolve(copied, ADDRESSED_ADDRESSES, array->deviceAddress);
    const bool is_indirect_scratch = cluster_member_is_indirect(info, ADDRESSED_SCRATCH);
    struct handle_table known = {0};
    view->alignment = alignment_of(copied);
    for (uint32_t i = 0; i < view->infos; i++) {
        VkDeviceAddress address;
        if (!addresses ||
            !read_whole(copied, addresses + i * array->stride, &address, sizeof(address)))
            break;
        report_structure(copied, true, address);
        const struct cluster_dst dst = {.index = i,
                                        .same = address ? note_value(&known, address, i) : i,
                                        .facts = look_up(copied, address)};
        find_wrong(&view->misaligned, &wrong->misaligned, &dst,
                   view->alignment && address % view->alignment);
        find_wrong(
            &view->unusable, &wrong->unusable, &dst,
            dst.facts.status == ADDRESS_NULL || dst.facts.status == ADDRESS_NOWHERE ||
                (dst.facts.status == ADDRESS_IN_BUFFER &&
                 !(dst.facts.usage & VK_BUFFER_USAGE_2_ACCELERATION_STRUCTURE_STORAGE_BIT_KHR)));
        find_wrong(&view->repeated, &wrong->repeated, &dst, dst.same != i);
        find_wrong(&view->in_scratch, &wrong->in_scratch, &dst,
                   !is_indirect_scratch &&
                       address - info->scratchData < copied->build->scratch_size);
    }
    handle_table_release(&known);
}

static void find_same_reference(const struct copied *copied, struct cluster_info_view *view)
{
    const VkClusterAccelerationStructureBuildClustersBottomLevelInfoNV *info = view->bottom_level;
    struct handle_table known = {0};
    for (uint32_t i = 0;
         i < elements_of(info->clusterReferencesCount, info->clusterReferencesStride); i++) {
        VkDeviceAddress reference;
        const uint64_t at = info->clusterReferences + (uint64_t)i * info->clusterReferencesStride;
        if (!read_whole(copied, at, &reference, sizeof(reference)))
            break;
        if (!reference)
            continue;
        report_structure(copied, false, reference);
        view->first_same = note_value(&known, reference, i);
        view->second_same = i;
        if (view->first_same != i)
            break;
    }
    handle_table_release(&known);
}

/* A structure of srcInfosArray, whatever its type. */
union cluster_info {
    VkClusterAccelerationStructureBuildTriangleClusterTemplateInfoNV triangles;
    VkClusterAccelerationStructureInstantiateClusterInfoNV instance;
    VkClusterAccelerationStructureBuildClustersBottomLevelInfoNV bottom_level;
    uint64_t address; /* of the others */
};

_Static_assert(offsetof(VkClusterAccelerationStructureBuildTriangleClusterInfoNV,
                        opacityMicromapIndexBuffer) ==
                   offsetof(VkClusterAccelerationStructureBuildTriangleClusterTemplateInfoNV,
                            opacityMicromapIndexBuffer),
               "a template begins like a cluster");

static bool may_hold(const struct copied *copied, enum place_kind kind, VkDeviceAddress address)
{
    const struct check_context *context = copied->walk->context;
    return places_may_hold(context->places, kind, address, context->destroy_count);
}

/* Whether the address is one in a buffer, and no command that was recorded builds there what one of
 * the kinds says. */
static bool is_unbuilt(const struct copied *copied, uint64_t address, enum place_kind first,
                       enum place_kind last)
{
    if (look_up(copied, address).status != ADDRESS_IN_BUFFER)
        return false;
    for (enum place_kind kind = first; kind <= last; kind++)
        if (may_hold(copied, kind, address))
            return false;
    return true;
}

/* The template that is instantiated. */
static struct template_facts find_template(const struct copied *copied, VkDeviceAddress address)
{
    const struct check_context *context = copied->walk->context;
    return copied->earlier_is_known
               ? places_find_template(context->places, address, context->destroy_count)
               : (struct template_facts){.format = VK_FORMAT_UNDEFINED};
}

static void view_info(const struct copied *copied, const union cluster_info *info,
                      struct cluster_info_view *view)
{
    switch ((int)copied->build->clusters.info.input.opType) {
    case VK_CLUSTER_ACCELERATION_STRUCTURE_OP_TYPE_BUILD_TRIANGLE_CLUSTER_NV:
    case VK_CLUSTER_ACCELERATION_STRUCTURE_OP_TYPE_BUILD_TRIANGLE_CLUSTER_TEMPLATE_NV:
        view->triangles = &info->triangles;
        break;
    case VK_CLUSTER_ACCELERATION_STRUCTURE_OP_TYPE_INSTANTIATE_TRIANGLE_CLUSTER_NV:
        view->instance = &info->instance;
        report_structure(copied, false, info->instance.clusterTemplateAddress);
        view->template = find_template(copied, info->instance.clusterTemplateAddress);
        break;
    case VK_CLUSTER_ACCELERATION_STRUCTURE_OP_TYPE_BUILD_CLUSTERS_BOTTOM_LEVEL_NV:
        view->bottom_level = &info->bottom_level;
        view->references = look_up(copied, info->bottom_level.clusterReferences);
        find_same_reference(copied, view);
        break;
    case VK_CLUSTER_ACCELERATION_STRUCTURE_OP_TYPE_MOVE_OBJECTS_NV:
        view->unbuilt_move = is_unbuilt(copied, info->address, PLACE_BOTTOM_LEVEL, PLACE_TEMPLATE)
                                 ? info->address
                                 : 0;
        report_structure(copied, false, info->address);
        break;
    case VK_CLUSTER_ACCELERATION_STRUCTURE_OP_TYPE_GET_CLUSTER_TEMPLATE_INDICES_NV:
        view->unbuilt_template =
            is_unbuilt(copied, info->address, PLACE_TEMPLATE, PLACE_TEMPLATE) ? info->address : 0;
        report_structure(copied, false, info->address);
        break;
    default:
        break;
    }
}

/* Without a stride only the first element is certain. */
static void read_geometries(const struct copied *copied, struct cluster_info_view *view,
                            struct triangle_geometry wrong[2])
{
    const VkClusterAccelerationStructureBuildTriangleClusterTemplateInfoNV *info = view->triangles;
    const uint32_t limit = copied->call->device->clusters.limits.maxClusterGeometryIndex;
    const uint64_t stride = info->geometryIndexAndFlagsBufferStride, size = sizeof(wrong->geometry),
                   most = copied->build->clusters.triangles.maxClusterTriangleCount * size;
    uint64_t count = stride || !info->triangleCount ? info->triangleCount : 1;
    const unsigned char *bytes;
    if (count && (count - 1) * stride + size > most) /* as much as was copied */
        count = most < size ? 0 : (most - size) / stride + 1;
    if (!count || !info->geometryIndexAndFlagsBuffer ||
        copied->memory->find(copied->memory->context, info->geometryIndexAndFlagsBuffer,
                             (count - 1) * stride + size,
                             (const void **)&bytes) != (count - 1) * stride + size)
        return;
    for (uint32_t i = 0; i < count; i++) {
        struct triangle_geometry read = {.triangle = i};
        memcpy(&read.geometry, bytes + i * stride, size);
        if (!view->wrong_index && read.geometry.geometryIndex >= limit) {
            wrong[0] = read;
            view->wrong_index = &wrong[0];
        }
        if (!view->wrong_reserved && read.geometry.reserved) {
            wrong[1] = read;
            view->wrong_reserved = &wrong[1];
        }
    }
}

static WALK_ALL(cluster_info)

    /* Returns false if a rule about the structure is violated. */
    static bool check_info(const struct copied *copied, const struct cluster_op *op, uint32_t index,
                           const union cluster_info *info)
{
    const struct location location = element_of(copied, "pCommandInfos->srcInfosArray", index);
    const uint32_t findings = copied->walk->findings;
    struct cluster_info_view view = {.call = copied->call, .build = copied->build};
    struct triangle_geometry wrong[2];
    view_info(copied, info, &view);
    if (cluster_op_has_geometries(copied->build))
        read_geometries(copied, &view, wrong);
    check_implicit_read(copied->walk, copied->call, &location, op->name, info,
                        copied->addresses_are_known);
    walk_cluster_info(copied->walk, &view, &location);
    return copied->walk->findings == findings;
}

/* Returns false if one of them was not copied, or violates a rule. */
static bool read_infos(const struct copied *copied, struct cluster_read_view *view)
{
    const VkClusterAccelerationStructureCommandsInfoNV *info = &copied->build->clusters.info;
    const VkClusterAccelerationStructureOpTypeNV type = info->input.opType;
    const struct cluster_op *op = cluster_op(type);
    const VkDeviceAddress infos =
        resolve(copied, ADDRESSED_INFOS, info->srcInfosArray.deviceAddress);
    bool is_valid = true;
    if (!infos && view->infos)
        return false;
    for (uint32_t i = 0; op && i < view->infos; i++) {
        union cluster_info element = {0};
        if (!read_whole(copied, infos + i * info->srcInfosArray.stride, &element, op->size))
            return false;
        const uint32_t references =
            type == VK_CLUSTER_ACCELERATION_STRUCTURE_OP_TYPE_BUILD_CLUSTERS_BOTTOM_LEVEL_NV
                ? element.bottom_level.clusterReferencesCount
                : 0;
        view->references += references;
        if (references > view->most_references) {
            view->most_references = references;
            view->most_index = i;
        }
        view->has_vertices |=
            type == VK_CLUSTER_ACCELERATION_STRUCTURE_OP_TYPE_BUILD_TRIANGLE_CLUSTER_TEMPLATE_NV &&
            element.triangles.vertexBuffer;
        is_valid = is_valid && check_info(copied, op, i, &element);
    }
    return is_valid;
}

/* Keeps what later builds may depend on. */
static void keep_templates(const struct copied *copied, const struct cluster_read_view *view)
{
    struct places *places = copied->walk->context->places;
    if (place_kind_of(copied->build) != PLACE_TEMPLATE)
        return;
    places_set_read(places, copied->place);
    places_set_templates_read(places, addressed_build_dst(copied->build),
                              copied->build->clusters.triangles.vertexFormat, view->has_vertices);
}

static WALK_ALL(cluster_read)

    static void check_clusters(const struct copied *copied)
{
    const VkClusterAccelerationStructureCommandsInfoNV *info = &copied->build->clusters.info;
    const uint32_t most = info->input.maxAccelerationStructureCount;
    const struct location location = check_argument(copied->call, "pCommandInfos");
    struct cluster_read_view view = {.call = copied->call, .build = copied->build, .infos = most};
    struct wrong_dsts wrong;
    if (info->srcInfosCount) {
        const VkDeviceAddress count = resolve(copied, ADDRESSED_COUNT, info->srcInfosCount);
        view.has_count = count && read_whole(copied, count, &view.count, sizeof(view.count));
        view.infos = !view.has_count ? 0 : view.count < most ? view.count : most;
    }
    report_ranges(copied, view.infos);
    if (read_infos(copied, &view) && (view.has_count || !info->srcInfosCount) && view.count <= most)
        keep_templates(copied, &view);
    if (info->input.opMode == VK_CLUSTER_ACCELERATION_STRUCTURE_OP_MODE_EXPLICIT_DESTINATIONS_NV)
        read_dsts(copied, &view, &wrong);
    walk_cluster_read(copied->walk, &view, &location);
}

/* ---- partitioned structures */

static uint32_t instance_of(const struct partition_operation_view *view)
{
    return view->write ? view->write->instanceIndex : view->update->instanceIndex;
}

typedef VkBuildPartitionedAccelerationStructureIndirectCommandNV indirect_command;

/* An element of the array of an operation. */
union partition_element {
    VkPartitionedAccelerationStructureWriteInstanceDataNV write;
    VkPartitionedAccelerationStructureUpdateInstanceDataNV update;
    VkPartitionedAccelerationStructureWritePartitionTranslationDataNV translation;
};

static bool read_element_of(const struct copied *copied, const indirect_command *operation,
                            uint32_t index, union partition_element *element)
{
    return read_whole(copied,
                      operation->argData.startAddress + index * operation->argData.strideInBytes,
                      element, partition_argument_size(operation->opType));
}

/* Keeps what later builds may depend on. */
static void keep_instances(const struct copied *copied, const indirect_command *operation)
{
    const uint32_t count = elements_of(operation->argCount, operation->argData.strideInBytes);
    const bool is_new = !copied->build->partitions.info.srcAccelerationStructureData;
    union partition_element element;
    for (uint32_t i = 0; i < count && read_element_of(copied, operation, i, &element); i++)
        places_add_instance(
            copied->walk->context->places, element.write.instanceIndex, is_new,
            !element.write.accelerationStructure ||
                element.write.instanceFlags &
                    VK_PARTITIONED_ACCELERATION_STRUCTURE_INSTANCE_FLAG_ENABLE_EXPLICIT_BOUNDING_BOX_NV);
}

/* Whether an update changes an instance that may not be updated. */
static bool updates_fixed_instance(const struct copied *copied, uint32_t index)
{
    const struct check_context *context = copied->walk->context;
    const VkDeviceAddress src = copied->build->partitions.info.srcAccelerationStructureData;
    return src && copied->earlier_is_known &&
           places_are_own(context->places, src, context->destroy_count) &&
           places_instance_is_fixed(context->places, index);
}

static WALK_ALL(partition_operation)

    /* The elements of one operation. Returns false if one of them was not copied. */
    static bool read_operation(const struct copied *copied, uint32_t index,
                               const indirect_command *operation, struct partition_read_view *whole)
{
    const size_t size = partition_argument_size(operation->opType);
    const char *const name =
        operation->opType == VK_PARTITIONED_ACCELERATION_STRUCTURE_OP_TYPE_WRITE_INSTANCE_NV
            ? "VkPartitionedAccelerationStructureWriteInstanceDataNV"
            : "VkPartitionedAccelerationStructureUpdateInstanceDataNV";
    struct location location = element_of(copied, "pBuildInfo->srcInfos", index);
    const bool translates =
        operation->opType ==
        VK_PARTITIONED_ACCELERATION_STRUCTURE_OP_TYPE_WRITE_PARTITION_TRANSLATION_NV;
    struct handle_table known = {0};
    bool is_valid = true, is_whole = size;
    const uint32_t count = elements_of(operation->argCount, operation->argData.strideInBytes);
    for (uint32_t i = 0; is_whole && i < count; i++) {
        union partition_element element;
        struct partition_operation_view view = {.call = copied->call, .build = copied->build};
        const uint32_t findings = copied->walk->findings;
        is_whole = read_element_of(copied, operation, i, &element);
        if (!is_whole)
            break;
        if (translates)
            view.translation = &element.translation;
        else if (size == sizeof(element.write))
            view.write = &element.write;
        else
            view.update = &element.update;
        if (view.write &&
            !(element.write.instanceFlags &
              VK_PARTITIONED_ACCELERATION_STRUCTURE_INSTANCE_FLAG_ENABLE_EXPLICIT_BOUNDING_BOX_NV))
            report_structure(copied, false, element.write.accelerationStructure);
        view.updates_fixed_instance =
            view.update && updates_fixed_instance(copied, element.update.instanceIndex);
        if (!translates && note_value(&known, 1 + (uint64_t)instance_of(&view), i) != i &&
            !whole->repeats_instance) {
            whole->repeats_instance = true;
            whole->instance = instance_of(&view);
        }
        location.geometry = i;
        if (is_valid && !translates)
            check_implicit_read(copied->walk, copied->call, &location, name, &element,
                                copied->addresses_are_known);
        if (is_valid)
            walk_partition_operation(copied->walk, &view, &location);
        is_valid = is_valid && copied->walk->findings == findings;
    }
    handle_table_release(&known);
    return is_whole;
}

static WALK_ALL(partition_read)

    /* Returns false if an operation was not copied. */
    static bool read_operations(const struct copied *copied, struct partition_read_view *view)
{
    const VkBuildPartitionedAccelerationStructureInfoNV *info = &copied->build->partitions.info;
    indirect_command operations[PARTITION_OPERATIONS_READ];
    uint32_t types = 0, count = 0;
    bool is_whole = true;
    while (count < view->count && count < PARTITION_OPERATIONS_READ &&
           read_whole(copied, info->srcInfos + count * sizeof(*operations), &operations[count],
                      sizeof(*operations)))
        count++;
    if (copied->earlier_is_known && !info->srcAccelerationStructureData)
        places_begin_instances(copied->walk->context->places);
    for (uint32_t i = 0; copied->earlier_is_known && i < count; i++)
        if (operations[i].opType == VK_PARTITIONED_ACCELERATION_STRUCTURE_OP_TYPE_WRITE_INSTANCE_NV)
            keep_instances(copied, &operations[i]);
    for (uint32_t i = 0; i < count; i++) {
        const struct location element = element_of(copied, "pBuildInfo->srcInfos", i);
        const uint32_t op_type = operations[i].opType;
        const uint32_t type = op_type < PARTITION_OPERATIONS ? 1u << op_type : 0;
        if (types & type && !view->repeats_operation) {
            view->repeats_operation = true;
            view->operation = op_type;
        }
        types |= type;
        check_implicit_read(copied->walk, copied->call, &element,
                            "VkBuildPartitionedAccelerationStructureIndirectCommandNV",
                            &operations[i], copied->addresses_are_known);
        is_whole = read_operation(copied, i, &operations[i], view) && is_whole;
    }
    return is_whole && count == view->count;
}

static void check_partitions(const struct copied *copied)
{
    const VkBuildPartitionedAccelerationStructureInfoNV *info = &copied->build->partitions.info;
    const struct location location = check_argument(copied->call, "pBuildInfo");
    const VkDeviceAddress src = info->srcAccelerationStructureData;
    struct places *places = copied->walk->context->places;
    struct partition_read_view view = {.call = copied->call,
                                       .build = copied->build,
                                       .infos = look_up(copied, info->srcInfos),
                                       .src_is_unbuilt =
                                           src && !may_hold(copied, PLACE_PARTITIONED, src)};
    if (!read_whole(copied, info->srcInfosCount, &view.count, sizeof(view.count)))
        view.count = 0;
    else if (read_operations(copied, &view))
        places_set_read(places, copied->place);
    walk_partition_read(copied->walk, &view, &location);
}

void content_check_addressed(struct walk *walk, const struct call_view *call,
                             const struct addressed_read *read)
{
    const struct check_context *context = walk->context;
    const struct addressed_build *build = read->build;
    const struct copied copied = {.walk = walk,
                                  .call = call,
                                  .build = build,
                                  .memory = read->memory,
                                  .place = read->place,
                                  .number = read->number,
                                  .earlier_is_known = places_are_read(context->places, read->place),
                                  .addresses_are_known =
                                      resources_destroy_count(context->resources) ==
                                      context->destroy_count};
    if (build->is_partitioned)
        check_partitions(&copied);
    else
        check_clusters(&copied);
}
