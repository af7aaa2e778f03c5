/* SPDX-License-Identifier: Apache-2.0 */
/* Determines which enumerants the enabled extensions of a device define. */
#ifndef ASSAY_VIEW_ENABLED_H
#define ASSAY_VIEW_ENABLED_H

#include <stdbool.h>

#include "src/state/facts.h"

bool accel_type_is_enabled(const struct device_facts *device, VkAccelerationStructureTypeKHR type);
bool geometry_type_is_enabled(const struct device_facts *device, VkGeometryTypeKHR type);

/* build_flags_enabled() returns all bits that are valid on the device; core_build_flags are valid
 * on every device. */
VkBuildAccelerationStructureFlagsKHR build_flags_enabled(const struct device_facts *device);
static const VkBuildAccelerationStructureFlagsKHR core_build_flags =
    VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_UPDATE_BIT_KHR |
    VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_COMPACTION_BIT_KHR |
    VK_BUILD_ACCELERATION_STRUCTURE_PREFER_FAST_TRACE_BIT_KHR |
    VK_BUILD_ACCELERATION_STRUCTURE_PREFER_FAST_BUILD_BIT_KHR |
    VK_BUILD_ACCELERATION_STRUCTURE_LOW_MEMORY_BIT_KHR;
static const VkGeometryInstanceFlagsKHR micromap_instance_flags =
    VK_GEOMETRY_INSTANCE_FORCE_OPACITY_MICROMAP_2_STATE_BIT_KHR |
    VK_GEOMETRY_INSTANCE_DISABLE_OPACITY_MICROMAPS_BIT_KHR;
VkGeometryInstanceFlagsKHR instance_flags_enabled(const struct device_facts *device);
static const VkGeometryFlagsKHR geometry_flags =
    VK_GEOMETRY_OPAQUE_BIT_KHR | VK_GEOMETRY_NO_DUPLICATE_ANY_HIT_INVOCATION_BIT_KHR;

#endif
