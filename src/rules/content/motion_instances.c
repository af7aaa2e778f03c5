/* SPDX-License-Identifier: Apache-2.0 */
/* Rules about the instances of builds with motion. */
#include <string.h>

#include "src/rules/predicates.h"
#include "src/rules/shared.h"
#include "src/view/enabled.h"
#include "src/view/motion_instance.h"
#include "src/view/names.h"

static const struct device_facts *device_of(const struct motion_instance_view *view)
{
    return view->geometry->build->call->device;
}

bool motion_instance_type_is_valid(const struct motion_instance_view *motion_instance,
                                   struct finding *finding)
{
    struct motion_instance_common common;
    return motion_instance_common(&motion_instance->instance, &common) ||
           device_of(motion_instance)->newer_than_registry ||
           violated(finding, content_field(motion_instance->geometry, INPUT_INSTANCES),
                    "leads to instance {}, whose type {} is not a "
                    "VkAccelerationStructureMotionInstanceTypeNV",
                    number(motion_instance->index),
                    number((uint32_t)motion_instance->instance.type));
}

bool motion_instance_flags_are_zero(const struct motion_instance_view *motion_instance,
                                    struct finding *finding)
{
    return !motion_instance->instance.flags || device_of(motion_instance)->newer_than_registry ||
           violated(finding, content_field(motion_instance->geometry, INPUT_INSTANCES),
                    "leads to instance {}, whose flags {} are not 0",
                    number(motion_instance->index), hex(motion_instance->instance.flags));
}

/* The flag bits of micromaps have a rule (11580) for plain instances, which applies to static
 * members, too. Instances that move have no such rule. */
static VkGeometryInstanceFlagsKHR allowed_flags(const struct device_facts *device, int type)
{
    VkGeometryInstanceFlagsKHR flags = instance_flags_enabled(device);
    return type == VK_ACCELERATION_STRUCTURE_MOTION_INSTANCE_TYPE_STATIC_NV
               ? flags | micromap_instance_flags
               : flags;
}

static bool flags_are_valid(const struct motion_instance_view *view, int type,
                            struct finding *finding, const char *says)
{
    const struct device_facts *device = device_of(view);
    struct motion_instance_common common;
    if (!motion_instance_is(&view->instance, type) ||
        !motion_instance_common(&view->instance, &common))
        return true;
    VkGeometryInstanceFlagsKHR unknown = common.flags & ~allowed_flags(device, type);
    return !unknown || device->newer_than_registry ||
           violated(finding, content_field(view->geometry, INPUT_INSTANCES), says,
                    number(view->index), instance_flags(common.flags), hex(unknown));
}

#define FLAGS_OF(member)                                                                           \
    "leads to instance {}, whose data." member                                                     \
    ".flags {} have bits {}, which VkGeometryInstanceFlagBitsKHR does not define"

bool matrix_motion_instance_flags_are_valid(const struct motion_instance_view *motion_instance,
                                            struct finding *finding)
{
    return flags_are_valid(motion_instance,
                           VK_ACCELERATION_STRUCTURE_MOTION_INSTANCE_TYPE_MATRIX_MOTION_NV, finding,
                           FLAGS_OF("matrixMotionInstance")) ||
           (!motion_instance->is_packed &&
            also_violates(finding, RULE_matrix_motion_member_is_filled));
}

bool srt_motion_instance_flags_are_valid(const struct motion_instance_view *motion_instance,
                                         struct finding *finding)
{
    return flags_are_valid(motion_instance,
                           VK_ACCELERATION_STRUCTURE_MOTION_INSTANCE_TYPE_SRT_MOTION_NV, finding,
                           FLAGS_OF("srtMotionInstance")) ||
           (!motion_instance->is_packed &&
            also_violates(finding, RULE_srt_motion_member_is_filled));
}

/* Only its flags can make a member invalid. If a rule is about the flags of a member, its message
 * names the id of the member. */

#define NO_VALID(member)                                                                           \
    "leads to instance {}, whose data." member                                                     \
    " is invalid: its flags {} have bits {}, which VkGeometryInstanceFlagBitsKHR does not define"

bool static_member_is_filled(const struct motion_instance_view *motion_instance,
                             struct finding *finding)
{
    return motion_instance->is_packed ||
           flags_are_valid(motion_instance,
                           VK_ACCELERATION_STRUCTURE_MOTION_INSTANCE_TYPE_STATIC_NV, finding,
                           NO_VALID("staticInstance"));
}

bool matrix_motion_member_is_filled(const struct motion_instance_view *motion_instance,
                                    struct finding *finding)
{
    return motion_instance->is_packed ||
           flags_are_valid(motion_instance,
                           VK_ACCELERATION_STRUCTURE_MOTION_INSTANCE_TYPE_MATRIX_MOTION_NV, finding,
                           NO_VALID("matrixMotionInstance")) ||
           is_reported_with(finding, RULE_matrix_motion_instance_flags_are_valid);
}

bool srt_motion_member_is_filled(const struct motion_instance_view *motion_instance,
                                 struct finding *finding)
{
    return motion_instance->is_packed ||
           flags_are_valid(motion_instance,
                           VK_ACCELERATION_STRUCTURE_MOTION_INSTANCE_TYPE_SRT_MOTION_NV, finding,
                           NO_VALID("srtMotionInstance")) ||
           is_reported_with(finding, RULE_srt_motion_instance_flags_are_valid);
}

/* An instance without a structure is valid and inactive. */
bool motion_instance_references_are_valid_handles(
    const struct motion_instance_view *motion_instance, struct finding *finding)
{
    const struct accel_facts *referenced = motion_instance->referenced;
    return !referenced->handle || referenced->alive != NO ||
           violated(finding, content_field(motion_instance->geometry, INPUT_INSTANCES),
                    "leads to instance {}, whose accelerationStructureReference {} is not an "
                    "acceleration structure of this device: it was destroyed or never created",
                    number(motion_instance->index),
                    destroyed_object(VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR,
                                     handle_number(referenced->handle), 0));
}
