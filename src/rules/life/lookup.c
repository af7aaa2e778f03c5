/* SPDX-License-Identifier: Apache-2.0 */
/* Rules about queries of sizes, addresses and handles of structures. */
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
        if (geometry && geometry->geometryType == VK_GEOMETRY_TYPE_INSTANCES_KHR &&
            size_query->counts[i] > limit)
            return violated(finding, "pMaxPrimitiveCounts",
                            "has {} at index {}, more than maxInstanceCount ({})",
                            count_of(size_query->counts[i], "instance"), number(i), number(limit));
    }
    return true;
}

/* ---- addresses and handles */

static struct value buffer_of(const struct lookup_view *lookup)
{
    return object(VK_OBJECT_TYPE_BUFFER, (uint64_t)(uintptr_t)lookup->object.buffer);
}

bool address_of_structure_needs_bound_buffer(const struct lookup_view *lookup,
                                             struct finding *finding)
{
    return lookup->object.backed != NO ||
           violated(finding, "accelerationStructure",
                    "{} lies in {}, which is not bound to memory, or was destroyed, or whose "
                    "memory was freed",
                    life_object_value(&lookup->object), buffer_of(lookup));
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
