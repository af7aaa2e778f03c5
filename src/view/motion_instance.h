/* SPDX-License-Identifier: Apache-2.0 */
/* The members that all types of VkAccelerationStructureMotionInstanceNV share. */
#ifndef ASSAY_VIEW_MOTION_INSTANCE_H
#define ASSAY_VIEW_MOTION_INSTANCE_H

#include <stdbool.h>
#include <stdint.h>
#include <vulkan/vulkan.h>

static inline bool motion_instance_is(const VkAccelerationStructureMotionInstanceNV *instance,
                                      VkAccelerationStructureMotionInstanceTypeNV type)
{
    return instance->type == type;
}

struct motion_instance_common {
    VkGeometryInstanceFlagsKHR flags;
    uint64_t reference;
};

/* Fills `common`. Returns false if the type is unknown. */
static inline bool motion_instance_common(const VkAccelerationStructureMotionInstanceNV *instance,
                                          struct motion_instance_common *common)
{
#define COMMON(member)                                                                             \
    ((struct motion_instance_common){(member).flags, (member).accelerationStructureReference})
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
#undef COMMON
}

#endif
