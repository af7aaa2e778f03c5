/* SPDX-License-Identifier: Apache-2.0 */
/* Rules about serialized data. */
#include "src/rules/predicates.h"

static const char *memory_of(const struct copy_view *copy)
{
    return copy->is_on_host ? "src.hostAddress" : "src.deviceAddress";
}

static bool header_is_complete(const struct copy_view *copy)
{
    return !copy->data.has_sizes || copy->data.header_size <= copy->data.size;
}

/* What the header of other data says means nothing. */
static bool is_usable(const struct copy_view *copy)
{
    return copy->data.has_sizes && copy->data.compatible != NO && header_is_complete(copy);
}

static bool data_ends_in_its_buffer(const struct copy_view *copy)
{
    return !is_usable(copy) || copy->is_on_host || copy->memory.status != ADDRESS_IN_BUFFER ||
           copy->data.size <= copy->memory.bytes_left;
}

bool serialized_data_is_complete(const struct copy_view *copy, struct finding *finding)
{
    if (!data_ends_in_its_buffer(copy))
        return violated(finding, memory_of(copy),
                        "{} holds data of {}, as the header says, but {} ends {} behind it",
                        hex(copy->address), count_of(copy->data.size, "byte"),
                        object(VK_OBJECT_TYPE_BUFFER, handle_number(copy->memory.buffer)),
                        count_of(copy->memory.bytes_left, "byte"));
    return header_is_complete(copy) ||
           violated(
               finding, memory_of(copy),
               "{} holds data of {}, as the header says, less than the {} of the header itself",
               hex(copy->address), count_of(copy->data.size, "byte"),
               count_of(copy->data.header_size, "byte")) ||
           (copy->data.compatible == NO &&
            also_violates(finding, RULE_serialized_data_is_compatible));
}

bool serialized_data_is_compatible(const struct copy_view *copy, struct finding *finding)
{
    return copy->data.compatible != NO ||
           violated(finding, memory_of(copy),
                    "{} holds data of a version that is not compatible with the physical device",
                    hex(copy->address)) ||
           (!header_is_complete(copy) &&
            is_reported_with(finding, RULE_serialized_data_is_complete));
}

bool deserialized_dst_is_large_enough(const struct copy_view *copy, struct finding *finding)
{
    return !is_usable(copy) || !copy->dst.details_known ||
           copy->dst.size >= copy->data.deserialized_size ||
           violated(finding, "dst",
                    "{} was created with size {}, less than the deserialized size in the header of "
                    "src ({})",
                    life_object_value(&copy->dst), number(copy->dst.size),
                    number(copy->data.deserialized_size));
}

bool serialized_blocks_have_valid_types(const struct copy_view *copy, struct finding *finding)
{
    return !is_usable(copy) || !copy->data.invalid_type ||
           copy->call->device->newer_than_registry ||
           violated(finding, memory_of(copy),
                    "{} holds a block of type {}, which is no "
                    "VkAccelerationStructureSerializedBlockTypeKHR",
                    hex(copy->address), number(copy->data.invalid_type));
}

bool serialized_micromaps_need_the_feature(const struct copy_view *copy, struct finding *finding)
{
    return !is_usable(copy) || !copy->data.has_micromaps || copy->call->device->micromap.khr ||
           violated(finding, memory_of(copy),
                    "{} holds a block of opacity micromaps, and the feature micromap of "
                    "VkPhysicalDeviceOpacityMicromapFeaturesKHR is not enabled",
                    hex(copy->address));
}

bool serialized_micromap_addresses_are_valid(const struct copy_view *copy, struct finding *finding)
{
    return !is_usable(copy) || !copy->data.invalid_address || !copy->call->device->micromap.khr ||
           violated(finding, memory_of(copy),
                    "{} holds the address {} of an opacity micromap, which is in no buffer whose "
                    "address was retrieved",
                    hex(copy->address),
                    address_of_missing(VK_OBJECT_TYPE_BUFFER, copy->data.invalid_address));
}
