/* SPDX-License-Identifier: Apache-2.0 */
/* Rules about the creation of structures and micromaps. */
#include "src/rules/predicates.h"
#include "src/view/names.h"

static bool is_opacity_micromap(const struct create_view *create)
{
    return create->type == VK_ACCELERATION_STRUCTURE_TYPE_OPACITY_MICROMAP_KHR;
}

static struct value buffer(const struct create_view *create)
{
    return object(VK_OBJECT_TYPE_BUFFER, handle_number(create->buffer.handle));
}

/* ---- the type and the flags */

static bool has_no_flag(const struct create_view *create, struct finding *finding, VkFlags flag,
                        const char *name)
{
    return !is_opacity_micromap(create) || !(create->create_flags & flag) ||
           violated(finding, "createFlags",
                    "{} includes {}, and type is "
                    "VK_ACCELERATION_STRUCTURE_TYPE_OPACITY_MICROMAP_KHR",
                    hex(create->create_flags), phrase(name));
}

bool created_opacity_micromap_captures_no_descriptors(const struct create_view *create,
                                                      struct finding *finding)
{
    return has_no_flag(create, finding,
                       VK_ACCELERATION_STRUCTURE_CREATE_DESCRIPTOR_BUFFER_CAPTURE_REPLAY_BIT_EXT,
                       "VK_ACCELERATION_STRUCTURE_CREATE_DESCRIPTOR_BUFFER_CAPTURE_REPLAY_BIT_EXT");
}

bool created_opacity_micromap_has_no_motion(const struct create_view *create,
                                            struct finding *finding)
{
    return has_no_flag(create, finding, VK_ACCELERATION_STRUCTURE_CREATE_MOTION_BIT_NV,
                       "VK_ACCELERATION_STRUCTURE_CREATE_MOTION_BIT_NV");
}

bool opacity_micromap_is_created_at_an_address(const struct create_view *create,
                                               struct finding *finding)
{
    return !is_opacity_micromap(create) ||
           violated_plainly(finding, "type",
                            "is VK_ACCELERATION_STRUCTURE_TYPE_OPACITY_MICROMAP_KHR, which "
                            "vkCreateAccelerationStructureKHR cannot create");
}

bool created_top_level_with_motion_has_motion_info(const struct create_view *create,
                                                   struct finding *finding)
{
    return !(create->create_flags & VK_ACCELERATION_STRUCTURE_CREATE_MOTION_BIT_NV) ||
           create->type != VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR || !create->chain_known ||
           create->has_motion_info ||
           violated_plainly(finding, "pNext",
                            "has no VkAccelerationStructureMotionInfoNV, and createFlags includes "
                            "VK_ACCELERATION_STRUCTURE_CREATE_MOTION_BIT_NV");
}

bool captured_descriptor_data_has_its_flag(const struct create_view *create,
                                           struct finding *finding)
{
    return !create->has_captured_data ||
           (create->create_flags &
            VK_ACCELERATION_STRUCTURE_CREATE_DESCRIPTOR_BUFFER_CAPTURE_REPLAY_BIT_EXT) ||
           violated(finding, "createFlags",
                    "{} lacks "
                    "VK_ACCELERATION_STRUCTURE_CREATE_DESCRIPTOR_BUFFER_CAPTURE_REPLAY_BIT_EXT, "
                    "and pNext has a VkOpaqueCaptureDescriptorDataCreateInfoEXT",
                    hex(create->create_flags));
}

/* Micromaps have a flag of the same value. */
_Static_assert((int)VK_ACCELERATION_STRUCTURE_CREATE_DEVICE_ADDRESS_CAPTURE_REPLAY_BIT_KHR ==
                   (int)VK_MICROMAP_CREATE_DEVICE_ADDRESS_CAPTURE_REPLAY_BIT_EXT,
               "one rule is for both");

static bool replays_address(const struct create_view *create)
{
    return create->create_flags &
           VK_ACCELERATION_STRUCTURE_CREATE_DEVICE_ADDRESS_CAPTURE_REPLAY_BIT_KHR;
}

static struct value replay_flag(const struct create_view *create)
{
    return phrase(create->is_micromap
                      ? "VK_MICROMAP_CREATE_DEVICE_ADDRESS_CAPTURE_REPLAY_BIT_EXT"
                      : "VK_ACCELERATION_STRUCTURE_CREATE_DEVICE_ADDRESS_CAPTURE_REPLAY_BIT_KHR");
}

bool replayed_address_has_its_flag(const struct create_view *create, struct finding *finding)
{
    return !create->device_address || replays_address(create) ||
           violated(finding, "createFlags", "{} lacks {}, and deviceAddress is {}",
                    hex(create->create_flags), replay_flag(create), hex(create->device_address));
}

/* ---- features */

static bool has_feature(const struct create_view *create, struct finding *finding, bool is_enabled,
                        struct value flag, const char *feature)
{
    return is_enabled || violated(finding, "createFlags", "{} includes {}, which requires {}",
                                  hex(create->create_flags), flag, phrase(feature));
}

/* The flag of the address has an id of its own. */
bool replayed_address_has_its_feature(const struct create_view *create, struct finding *finding)
{
    return !create->device_address || create->call->device->accel_capture_replay ||
           violated(finding, "deviceAddress",
                    "{} is not 0, which requires "
                    "VkPhysicalDeviceAccelerationStructureFeaturesKHR::"
                    "accelerationStructureCaptureReplay",
                    hex(create->device_address)) ||
           (replays_address(create) &&
            also_violates(finding, RULE_capture_replay_feature_is_enabled));
}

bool capture_replay_feature_is_enabled(const struct create_view *create, struct finding *finding)
{
    const struct device_facts *device = create->call->device;
    if (!replays_address(create))
        return true;
    if (create->is_micromap)
        return has_feature(create, finding, device->micromap.capture_replay, replay_flag(create),
                           "VkPhysicalDeviceOpacityMicromapFeaturesEXT::micromapCaptureReplay");
    return has_feature(create, finding, device->accel_capture_replay, replay_flag(create),
                       "VkPhysicalDeviceAccelerationStructureFeaturesKHR::"
                       "accelerationStructureCaptureReplay") ||
           (create->device_address &&
            is_reported_with(finding, RULE_replayed_address_has_its_feature));
}

bool multi_device_capture_replay_feature_is_enabled(const struct create_view *create,
                                                    struct finding *finding)
{
    const struct device_facts *device = create->call->device;
    return !replays_address(create) || !device->is_group ||
           device->buffer_device_address_multi_device ||
           violated(finding, "createFlags",
                    "{} includes {}, which requires VkPhysicalDeviceBufferDeviceAddressFeatures::"
                    "bufferDeviceAddressMultiDevice on a device with multiple physical devices",
                    hex(create->create_flags), replay_flag(create));
}

bool descriptor_capture_replay_feature_is_enabled(const struct create_view *create,
                                                  struct finding *finding)
{
    return create->is_micromap ||
           !(create->create_flags &
             VK_ACCELERATION_STRUCTURE_CREATE_DESCRIPTOR_BUFFER_CAPTURE_REPLAY_BIT_EXT) ||
           has_feature(
               create, finding, create->call->device->descriptor_buffer_capture_replay,
               phrase("VK_ACCELERATION_STRUCTURE_CREATE_DESCRIPTOR_BUFFER_CAPTURE_REPLAY_BIT_EXT"),
               "VkPhysicalDeviceDescriptorBufferFeaturesEXT::descriptorBufferCaptureReplay");
}

bool created_opacity_micromap_has_its_feature(const struct create_view *create,
                                              struct finding *finding)
{
    return !is_opacity_micromap(create) || create->call->device->micromap.khr ||
           violated_plainly(finding, "type",
                            "is VK_ACCELERATION_STRUCTURE_TYPE_OPACITY_MICROMAP_KHR, which "
                            "requires VkPhysicalDeviceOpacityMicromapFeaturesKHR::micromap");
}

/* ---- the place in the buffer */

enum { STORAGE_ALIGNMENT = 256 };

bool created_place_is_aligned(const struct create_view *create, struct finding *finding)
{
    const uint64_t place = create->by_address ? create->address : create->offset;
    return place % STORAGE_ALIGNMENT == 0 ||
           violated(finding, create->by_address ? "addressRange.address" : "offset",
                    "{} is not a multiple of {}", hex(place), count_of(STORAGE_ALIGNMENT, "byte"));
}

bool created_range_is_not_empty(const struct create_view *create, struct finding *finding)
{
    return create->size || violated_plainly(finding, "addressRange.size", "is 0");
}

bool created_object_fits_its_buffer(const struct create_view *create, struct finding *finding)
{
    const VkDeviceSize all = create->buffer.size;
    return create->buffer.alive != YES ||
           (create->offset <= all && create->size <= all - create->offset) ||
           violated(finding, "size", "{} and the offset {} exceed the size of {}, {}",
                    number(create->size), number(create->offset), buffer(create),
                    count_of(all, "byte"));
}

bool created_object_has_storage_usage(const struct create_view *create, struct finding *finding)
{
    const VkBufferUsageFlags2 wanted =
        create->is_micromap ? VK_BUFFER_USAGE_2_MICROMAP_STORAGE_BIT_EXT
                            : VK_BUFFER_USAGE_2_ACCELERATION_STRUCTURE_STORAGE_BIT_KHR;
    return create->buffer.alive != YES || (create->buffer.usage & wanted) ||
           violated(finding, create->by_address ? "addressRange" : "buffer",
                    "lies in {}, which was created with usage {}, without {}", buffer(create),
                    buffer_usage(create->buffer.usage),
                    phrase(create->is_micromap
                               ? "VK_BUFFER_USAGE_MICROMAP_STORAGE_BIT_EXT"
                               : "VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_STORAGE_BIT_KHR"));
}

bool created_object_is_not_in_a_sparse_resident_buffer(const struct create_view *create,
                                                       struct finding *finding)
{
    return create->buffer.alive != YES ||
           !(create->buffer.flags & VK_BUFFER_CREATE_SPARSE_RESIDENCY_BIT) ||
           violated(finding, create->by_address ? "addressRange" : "buffer",
                    "lies in {}, which was created with VK_BUFFER_CREATE_SPARSE_RESIDENCY_BIT",
                    buffer(create));
}

/* ---- the address range of vkCreateAccelerationStructure2KHR */

bool created_address_is_valid(const struct create_view *create, struct finding *finding)
{
    if (create->storage.status == ADDRESS_NULL)
        return violated_plainly(finding, "addressRange.address", "is 0");
    return create->storage.status != ADDRESS_NOWHERE ||
           violated(finding, "addressRange.address",
                    "{} is in no buffer whose address was retrieved",
                    address_of_missing(VK_OBJECT_TYPE_BUFFER, create->address));
}

static bool excludes_unknown(const struct create_view *create, struct finding *finding,
                             VkFlags known, VkFlags unknown)
{
    return (create->address_flags & (known | unknown)) != (known | unknown) ||
           violated(finding, "addressFlags", "{} includes both {} and {}",
                    hex(create->address_flags), hex(known), hex(unknown));
}

bool address_flags_state_one_storage_usage(const struct create_view *create,
                                           struct finding *finding)
{
    return excludes_unknown(create, finding, VK_ADDRESS_COMMAND_STORAGE_BUFFER_USAGE_BIT_KHR,
                            VK_ADDRESS_COMMAND_UNKNOWN_STORAGE_BUFFER_USAGE_BIT_KHR);
}

bool address_flags_state_one_transform_feedback_usage(const struct create_view *create,
                                                      struct finding *finding)
{
    return excludes_unknown(create, finding,
                            VK_ADDRESS_COMMAND_TRANSFORM_FEEDBACK_BUFFER_USAGE_BIT_KHR,
                            VK_ADDRESS_COMMAND_UNKNOWN_TRANSFORM_FEEDBACK_BUFFER_USAGE_BIT_KHR);
}

/* Other buffers that share the memory are not considered: this one decides. */
static bool usage_is_stated(const struct create_view *create, struct finding *finding,
                            VkBufferUsageFlags2 usage, VkFlags flags, const char *name)
{
    return create->buffer.alive != YES || !(create->buffer.usage & usage) ||
           (create->address_flags & flags) ||
           violated(finding, "addressFlags", "{} does not state that {} was created with {}",
                    hex(create->address_flags), buffer(create), phrase(name));
}

static bool usage_is_not_invented(const struct create_view *create, struct finding *finding,
                                  VkBufferUsageFlags2 usage, VkFlags flag, const char *name)
{
    return create->buffer.alive != YES || (create->buffer.usage & usage) ||
           !(create->address_flags & flag) ||
           violated(finding, "addressFlags", "{} states {}, and {} was created without it",
                    hex(create->address_flags), phrase(name), buffer(create));
}

#define STORAGE VK_BUFFER_USAGE_2_STORAGE_BUFFER_BIT
#define FEEDBACK VK_BUFFER_USAGE_2_TRANSFORM_FEEDBACK_BUFFER_BIT_EXT

bool storage_usage_is_in_address_flags(const struct create_view *create, struct finding *finding)
{
    return usage_is_stated(create, finding, STORAGE,
                           VK_ADDRESS_COMMAND_STORAGE_BUFFER_USAGE_BIT_KHR |
                               VK_ADDRESS_COMMAND_UNKNOWN_STORAGE_BUFFER_USAGE_BIT_KHR,
                           "VK_BUFFER_USAGE_STORAGE_BUFFER_BIT");
}

bool address_flags_have_storage_usage_of_the_buffer(const struct create_view *create,
                                                    struct finding *finding)
{
    return usage_is_not_invented(create, finding, STORAGE,
                                 VK_ADDRESS_COMMAND_STORAGE_BUFFER_USAGE_BIT_KHR,
                                 "VK_BUFFER_USAGE_STORAGE_BUFFER_BIT");
}

bool transform_feedback_usage_is_in_address_flags(const struct create_view *create,
                                                  struct finding *finding)
{
    return usage_is_stated(create, finding, FEEDBACK,
                           VK_ADDRESS_COMMAND_TRANSFORM_FEEDBACK_BUFFER_USAGE_BIT_KHR |
                               VK_ADDRESS_COMMAND_UNKNOWN_TRANSFORM_FEEDBACK_BUFFER_USAGE_BIT_KHR,
                           "VK_BUFFER_USAGE_TRANSFORM_FEEDBACK_BUFFER_BIT_EXT");
}

bool address_flags_have_transform_feedback_usage_of_the_buffer(const struct create_view *create,
                                                               struct finding *finding)
{
    return usage_is_not_invented(create, finding, FEEDBACK,
                                 VK_ADDRESS_COMMAND_TRANSFORM_FEEDBACK_BUFFER_USAGE_BIT_KHR,
                                 "VK_BUFFER_USAGE_TRANSFORM_FEEDBACK_BUFFER_BIT_EXT");
}

static bool may_fault(const struct create_view *create)
{
    return create->buffer.alive == YES && create->call->device->protected_no_fault == NO;
}

static bool is_protected(const struct create_view *create)
{
    return create->buffer.flags & VK_BUFFER_CREATE_PROTECTED_BIT;
}

bool protection_is_in_address_flags(const struct create_view *create, struct finding *finding)
{
    return !may_fault(create) || !is_protected(create) ||
           (create->address_flags & VK_ADDRESS_COMMAND_PROTECTED_BIT_KHR) ||
           violated(finding, "addressFlags",
                    "{} lacks VK_ADDRESS_COMMAND_PROTECTED_BIT_KHR, and {} was created with "
                    "VK_BUFFER_CREATE_PROTECTED_BIT",
                    hex(create->address_flags), buffer(create));
}

bool address_flags_have_protection_of_the_buffer(const struct create_view *create,
                                                 struct finding *finding)
{
    return !may_fault(create) || is_protected(create) ||
           !(create->address_flags & VK_ADDRESS_COMMAND_PROTECTED_BIT_KHR) ||
           violated(finding, "addressFlags",
                    "{} includes VK_ADDRESS_COMMAND_PROTECTED_BIT_KHR, and {} was created without "
                    "VK_BUFFER_CREATE_PROTECTED_BIT",
                    hex(create->address_flags), buffer(create));
}

static bool buffer_replays(const struct create_view *create)
{
    return create->buffer.flags & VK_BUFFER_CREATE_DEVICE_ADDRESS_CAPTURE_REPLAY_BIT;
}

bool structure_in_a_replayed_buffer_is_replayed(const struct create_view *create,
                                                struct finding *finding)
{
    return create->buffer.alive != YES || !buffer_replays(create) || replays_address(create) ||
           violated(finding, "createFlags",
                    "{} lacks {}, and {} was created with "
                    "VK_BUFFER_CREATE_DEVICE_ADDRESS_CAPTURE_REPLAY_BIT",
                    hex(create->create_flags), replay_flag(create), buffer(create));
}

bool replayed_structure_is_in_a_replayed_buffer(const struct create_view *create,
                                                struct finding *finding)
{
    return create->buffer.alive != YES || buffer_replays(create) || !replays_address(create) ||
           violated(finding, "createFlags",
                    "{} includes {}, and {} was created without "
                    "VK_BUFFER_CREATE_DEVICE_ADDRESS_CAPTURE_REPLAY_BIT",
                    hex(create->create_flags), replay_flag(create), buffer(create));
}

/* ---- VK_NV_ray_tracing */

bool compacted_size_comes_alone(const struct create_view *create, struct finding *finding)
{
    const VkAccelerationStructureInfoNV *info = create->nv_info;
    return !create->compacted_size || (!info->geometryCount && !info->instanceCount) ||
           violated(finding, "compactedSize",
                    "is {}, and info.geometryCount is {} and info.instanceCount {}",
                    number(create->compacted_size), number(info->geometryCount),
                    number(info->instanceCount));
}
