/* SPDX-License-Identifier: Apache-2.0 */
/* Rules about queries of sizes, addresses, handles and data for capture of structures, and about
 * their bindings. */
#include "src/rules/predicates.h"

/* ---- sizes */

static bool is_of_a_micromap(const struct size_query_view *query)
{
    return query->info->type == VK_ACCELERATION_STRUCTURE_TYPE_OPACITY_MICROMAP_KHR;
}

bool micromap_sizes_are_of_device_builds(const struct size_query_view *size_query,
                                         struct finding *finding)
{
    return !is_of_a_micromap(size_query) ||
           size_query->build_type == VK_ACCELERATION_STRUCTURE_BUILD_TYPE_DEVICE_KHR ||
           violated(finding, "buildType",
                    "{} is not VK_ACCELERATION_STRUCTURE_BUILD_TYPE_DEVICE_KHR, and only devices "
                    "build micromaps",
                    number(size_query->build_type));
}

bool micromap_sizes_need_no_counts(const struct size_query_view *size_query,
                                   struct finding *finding)
{
    return !is_of_a_micromap(size_query) || !size_query->counts_argument ||
           violated_plainly(finding, "pMaxPrimitiveCounts",
                            "is not NULL, and the build of a micromap has no primitives");
}

bool size_query_counts_are_readable(const struct size_query_view *size_query,
                                    struct finding *finding)
{
    return is_of_a_micromap(size_query) || !size_query->info->geometryCount || size_query->counts ||
           violated(finding, "pMaxPrimitiveCounts", "{} does not point to a readable array of {}",
                    hex((uint64_t)(uintptr_t)size_query->counts_argument),
                    count_of(size_query->info->geometryCount, "element"));
}

static const VkAccelerationStructureGeometryKHR *geometry_of(const struct size_query_view *query,
                                                             uint32_t index)
{
    return query->geometries          ? &query->geometries[index]
           : query->geometry_pointers ? query->geometry_pointers[index]
                                      : NULL;
}

bool size_query_instance_counts_are_within_limit(const struct size_query_view *size_query,
                                                 struct finding *finding)
{
    const uint64_t limit = size_query->call->device->limits.maxInstanceCount;
    for (uint32_t i = 0; size_query->counts && i < size_query->info->geometryCount; i++) {
        const VkAccelerationStructureGeometryKHR *geometry = geometry_of(size_query, i);
        if (geometry && type_is_instances(geometry->geometryType) && size_query->counts[i] > limit)
            return violated(finding, "pMaxPrimitiveCounts",
                            "has {} at index {}, more than maxInstanceCount ({})",
                            count_of(size_query->counts[i], "instance"), number(i), number(limit));
    }
    return true;
}

/* ---- addresses and handles */

static struct value buffer_of(const struct lookup_view *lookup)
{
    return object(VK_OBJECT_TYPE_BUFFER, handle_number(lookup->object.buffer));
}

bool address_of_structure_needs_bound_buffer(const struct lookup_view *lookup,
                                             struct finding *finding)
{
    return lookup->object.backed != NO ||
           violated_by_buffer_of(&lookup->object, finding, "accelerationStructure");
}

bool address_of_structure_needs_buffer_usage(const struct lookup_view *lookup,
                                             struct finding *finding)
{
    return lookup->buffer.alive != YES ||
           (lookup->buffer.usage & VK_BUFFER_USAGE_2_SHADER_DEVICE_ADDRESS_BIT) != 0 ||
           violated(finding, "accelerationStructure",
                    "{} lies in {}, which was created without "
                    "VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT",
                    life_object_value(&lookup->object), buffer_of(lookup));
}

bool handle_of_structure_needs_memory(const struct lookup_view *lookup, struct finding *finding)
{
    return lookup->object.backed != NO ||
           violated(finding, "accelerationStructure",
                    "{} is not bound to memory, or its memory was freed or is too small",
                    life_object_value(&lookup->object));
}

/* A size of 0 has an id of its own. */
bool handle_data_holds_a_handle(const struct lookup_view *lookup, struct finding *finding)
{
    return !lookup->data_size || lookup->data_size >= sizeof(uint64_t) ||
           violated(finding, "dataSize", "{} is less than {}, which a handle takes",
                    number(lookup->data_size), count_of(sizeof(uint64_t), "byte"));
}

/* ---- data for capture */

bool captured_structure_is_of_one_kind(const struct capture_view *capture, struct finding *finding)
{
    return !capture->info->accelerationStructure || !capture->info->accelerationStructureNV ||
           violated_plainly(finding, "accelerationStructure",
                            "and accelerationStructureNV are both given") ||
           also_violates(finding, RULE_captured_nv_structure_is_alone);
}

bool captured_nv_structure_is_alone(const struct capture_view *capture, struct finding *finding)
{
    return !capture->info->accelerationStructure || !capture->info->accelerationStructureNV ||
           violated_plainly(finding, "accelerationStructureNV",
                            "and accelerationStructure are both given") ||
           is_reported_with(finding, RULE_captured_structure_is_of_one_kind);
}

bool captured_structure_was_created_for_capture(const struct capture_view *capture,
                                                struct finding *finding)
{
    const struct life_object *structure = &capture->structure;
    return !structure->details_known ||
           (structure->create_flags &
            VK_ACCELERATION_STRUCTURE_CREATE_DESCRIPTOR_BUFFER_CAPTURE_REPLAY_BIT_EXT) != 0 ||
           violated(finding, "accelerationStructure",
                    "{} was created with createFlags {}, without "
                    "VK_ACCELERATION_STRUCTURE_CREATE_DESCRIPTOR_BUFFER_CAPTURE_REPLAY_BIT_EXT",
                    life_object_value(structure), hex(structure->create_flags));
}

/* The specification means this bit of VkBuildAccelerationStructureFlagsNV, although its name there
 * is VK_BUILD_ACCELERATION_STRUCTURE_PREFER_FAST_BUILD_BIT_NV. */
bool captured_nv_structure_was_created_for_capture(const struct capture_view *capture,
                                                   struct finding *finding)
{
    const struct life_object *structure = &capture->nv_structure;
    return !structure->details_known ||
           (structure->create_flags &
            VK_ACCELERATION_STRUCTURE_CREATE_DESCRIPTOR_BUFFER_CAPTURE_REPLAY_BIT_EXT) != 0 ||
           violated(finding, "accelerationStructureNV",
                    "{} was created with info.flags {}, without "
                    "VK_ACCELERATION_STRUCTURE_CREATE_DESCRIPTOR_BUFFER_CAPTURE_REPLAY_BIT_EXT",
                    life_object_value(structure), hex(structure->create_flags));
}

bool captured_structure_has_its_feature(const struct capture_view *capture, struct finding *finding)
{
    const struct life_object *structure = &capture->structure;
    return !structure->handle || capture->call->device->acceleration_structure ||
           violated(
               finding, "accelerationStructure",
               "{} is not VK_NULL_HANDLE, and the feature accelerationStructure is not enabled",
               life_object_value(structure)) ||
           (structure->alive == NO &&
            also_violates(
                finding,
                RULE_VkAccelerationStructureCaptureDescriptorDataInfoEXT_accelerationStructure_parameter));
}

bool captured_nv_structure_has_its_extension(const struct capture_view *capture,
                                             struct finding *finding)
{
    const struct life_object *structure = &capture->nv_structure;
    return !structure->handle || capture->call->device->extension.ray_tracing_nv ||
           violated(finding, "accelerationStructureNV",
                    "{} is not VK_NULL_HANDLE, and VK_NV_ray_tracing is not enabled",
                    life_object_value(structure)) ||
           (structure->alive == NO &&
            also_violates(
                finding,
                RULE_VkAccelerationStructureCaptureDescriptorDataInfoEXT_accelerationStructureNV_parameter));
}

bool captured_data_fits(const struct capture_view *capture, struct finding *finding)
{
    return !capture->data_is_cut ||
           violated(finding, "",
                    "pData {} does not point to {} "
                    "(accelerationStructureCaptureReplayDescriptorDataSize)",
                    hex((uint64_t)(uintptr_t)capture->data),
                    count_of(capture->call->device->accel_capture_size, "byte"));
}

/* ---- memory of VK_NV_ray_tracing */

static struct value structure_of(const struct binding_view *binding)
{
    return object(VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_NV,
                  handle_number(binding->info->accelerationStructure));
}

static struct value memory_of(const struct binding_view *binding)
{
    return object(VK_OBJECT_TYPE_DEVICE_MEMORY, handle_number(binding->info->memory));
}

bool bound_structure_has_no_memory_yet(const struct binding_view *binding, struct finding *finding)
{
    return (binding->before != NV_BOUND && binding->before != NV_MEMORY_TOO_SMALL) ||
           violated(finding, "accelerationStructure", "{} is already bound to memory",
                    structure_of(binding));
}

bool bound_offset_is_in_memory(const struct binding_view *binding, struct finding *finding)
{
    return !binding->memory.size || binding->info->memoryOffset < binding->memory.size ||
           violated(finding, "memoryOffset", "{} is not less than the size of {} ({})",
                    number(binding->info->memoryOffset), memory_of(binding),
                    number(binding->memory.size)) ||
           also_violates(finding, RULE_bound_memory_holds_structure);
}

bool bound_memory_has_an_allowed_type(const struct binding_view *binding, struct finding *finding)
{
    const uint32_t type = binding->memory.type, allowed = binding->required.memory_types;
    return !binding->memory.known || !binding->required.known || !allowed ||
           (type < VK_MAX_MEMORY_TYPES && (allowed & 1u << type) != 0) ||
           violated(finding, "memory",
                    "{} was allocated of type {}, which memoryTypeBits ({}) of {} "
                    "does not include",
                    memory_of(binding), number(type), hex(allowed), structure_of(binding));
}

bool bound_offset_is_aligned(const struct binding_view *binding, struct finding *finding)
{
    const VkDeviceSize alignment = binding->required.known ? binding->required.alignment : 0;
    return !alignment || binding->info->memoryOffset % alignment == 0 ||
           violated(finding, "memoryOffset", "{} is not a multiple of alignment ({}) of {}",
                    number(binding->info->memoryOffset), number(alignment), structure_of(binding));
}

bool bound_memory_holds_structure(const struct binding_view *binding, struct finding *finding)
{
    const VkDeviceSize size = binding->memory.size, offset = binding->info->memoryOffset;
    if (!size || !binding->required.known ||
        (offset < size && size - offset >= binding->required.object))
        return true;
    return violated(finding, "memoryOffset", "{} leaves too little of {} ({}) for the {} of {}",
                    number(offset), memory_of(binding), count_of(size, "byte"),
                    count_of(binding->required.object, "byte"), structure_of(binding)) ||
           (offset >= size && is_reported_with(finding, RULE_bound_offset_is_in_memory));
}
