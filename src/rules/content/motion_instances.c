/* SPDX-License-Identifier: Apache-2.0 */
/* Rules about the instances of builds with motion. */
#include <string.h>

#include "src/bvh/input/source.h"
#include "src/check/content/read.h"
#include "src/rules/predicates.h"
#include "src/view/enabled.h"

/* What the kinds of instances have in common. */
struct common {
    VkGeometryInstanceFlagsKHR flags;
    uint64_t reference;
};

#define COMMON(member) ((struct common){(member).flags, (member).accelerationStructureReference})

static bool is_of_type(const struct motion_instance_view *view, int type)
{
    return (int)view->instance.type == type;
}

/* False for instances of no known type. */
static bool find_common(const VkAccelerationStructureMotionInstanceNV *instance,
                        struct common *common)
{
    switch ((int)instance->type) {
    case VK_ACCELERATION_STRUCTURE_MOTION_INSTANCE_TYPE_STATIC_NV:
        *common = COMMON(instance->data.staticInstance);
        return true;
    case VK_ACCELERATION_STRUCTURE_MOTION_INSTANCE_TYPE_MATRIX_MOTION_NV:
        *common = COMMON(instance->data.matrixMotionInstance);
        return true;
    case VK_ACCELERATION_STRUCTURE_MOTION_INSTANCE_TYPE_SRT_MOTION_NV:
        *common = COMMON(instance->data.srtMotionInstance);
        return true;
    default:
        return false;
    }
}

static void check_instance(struct content *content, struct motion_instance_view *view)
{
    const uint32_t index = view->index;
    struct common common = {0};
    bool is_known = find_common(&view->instance, &common);
    content_find_reference(content, common.reference, &view->referenced);
    content_walk_motion_instance(content, view);
    if (is_of_type(view, VK_ACCELERATION_STRUCTURE_MOTION_INSTANCE_TYPE_STATIC_NV)) {
        content_check_instance(content, index, !view->is_packed,
                               &view->instance.data.staticInstance);
    } else if (is_known) {
        content_check_reference(content, index, &view->referenced);
    }
    if (is_of_type(view, VK_ACCELERATION_STRUCTURE_MOTION_INSTANCE_TYPE_MATRIX_MOTION_NV)) {
        const VkAccelerationStructureMatrixMotionInstanceNV *moving =
            &view->instance.data.matrixMotionInstance;
        content_check_transform(content, index, common.reference, &moving->transformT0);
        content_check_transform(content, index, common.reference, &moving->transformT1);
    }
}

void content_read_motion_instance(struct content *content, uint32_t index, const void *bytes)
{
    struct motion_instance_view view = {.geometry = content->range->geometry, .index = index};
    memcpy(&view.instance, bytes, sizeof(view.instance));
    check_instance(content, &view);
}

void content_read_motion_data(struct content *content, uint32_t index, uint32_t type,
                              const void *bytes)
{
    struct motion_instance_view view = {
        .geometry = content->range->geometry, .index = index, .is_packed = true};
    view.instance.type = (VkAccelerationStructureMotionInstanceTypeNV)type;
    memcpy(&view.instance.data, bytes, source_motion_size(type));
    check_instance(content, &view);
}

static const struct device_facts *device_of(const struct motion_instance_view *view)
{
    return view->geometry->build->call->device;
}

bool motion_instance_type_is_valid(const struct motion_instance_view *motion_instance,
                                   struct finding *finding)
{
    struct common common;
    return find_common(&motion_instance->instance, &common) ||
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

/* Plain instances have a rule for the bits of micromaps (11580), which is also asked of static
 * members; instances that move have none. */
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
    struct common common;
    if (!is_of_type(view, type) || !find_common(&view->instance, &common))
        return true;
    VkGeometryInstanceFlagsKHR unknown = common.flags & ~allowed_flags(device, type);
    return !unknown || device->newer_than_registry ||
           violated(finding, content_field(view->geometry, INPUT_INSTANCES), says,
                    number(view->index), hex(common.flags), hex(unknown));
}

#define FLAGS_OF(member)                                                                           \
    "leads to instance {}, whose data." member                                                     \
    ".flags {} have bits {}, which no "                                                            \
    "VkGeometryInstanceFlagBitsKHR is"

bool matrix_motion_instance_flags_are_valid(const struct motion_instance_view *motion_instance,
                                            struct finding *finding)
{
    return flags_are_valid(motion_instance,
                           VK_ACCELERATION_STRUCTURE_MOTION_INSTANCE_TYPE_MATRIX_MOTION_NV, finding,
                           FLAGS_OF("matrixMotionInstance"));
}

bool srt_motion_instance_flags_are_valid(const struct motion_instance_view *motion_instance,
                                         struct finding *finding)
{
    return flags_are_valid(motion_instance,
                           VK_ACCELERATION_STRUCTURE_MOTION_INSTANCE_TYPE_SRT_MOTION_NV, finding,
                           FLAGS_OF("srtMotionInstance"));
}

/* Flags are all that can make a member no valid structure of its type. */

#define NO_VALID(member)                                                                           \
    "leads to instance {}, whose data." member " is no valid structure: its flags {} have bits {}"

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
                           NO_VALID("matrixMotionInstance"));
}

bool srt_motion_member_is_filled(const struct motion_instance_view *motion_instance,
                                 struct finding *finding)
{
    return motion_instance->is_packed ||
           flags_are_valid(motion_instance,
                           VK_ACCELERATION_STRUCTURE_MOTION_INSTANCE_TYPE_SRT_MOTION_NV, finding,
                           NO_VALID("srtMotionInstance"));
}

/* An instance without a structure is inactive, not wrong. */
bool motion_instance_references_are_valid_handles(
    const struct motion_instance_view *motion_instance, struct finding *finding)
{
    const struct accel_facts *referenced = &motion_instance->referenced;
    return !referenced->handle || referenced->alive != NO ||
           violated(finding, content_field(motion_instance->geometry, INPUT_INSTANCES),
                    "leads to instance {}, whose accelerationStructureReference {} is not an "
                    "acceleration structure of this device",
                    number(motion_instance->index), hex((uint64_t)(uintptr_t)referenced->handle));
}
