/* SPDX-License-Identifier: Apache-2.0 */
/* Names of enumerants, from the string helpers of Vulkan-Utility-Libraries. */
#ifndef ASSAY_VIEW_NAMES_H
#define ASSAY_VIEW_NAMES_H

#include <vulkan/vulkan_core.h>

#include "src/view/finding.h"

/* Returns the enumerant's name, or its number if it has none. */
struct value structure_type(VkStructureType type);
struct value geometry_type(VkGeometryTypeKHR type);
struct value accel_type(VkAccelerationStructureTypeKHR type);
struct value index_type(VkIndexType type);
struct value copy_mode(VkCopyAccelerationStructureModeKHR mode);
struct value micromap_copy_mode(VkCopyMicromapModeEXT mode);
struct value query_type(VkQueryType type);
struct value format(VkFormat format);

/* Return flags with the names of their bits. */
struct value build_flags(VkBuildAccelerationStructureFlagsKHR flags);
struct value geometry_flags_of(VkGeometryFlagsKHR flags);
struct value instance_flags(VkGeometryInstanceFlagsKHR flags);
struct value accel_create_flags(VkAccelerationStructureCreateFlagsKHR flags);
struct value buffer_usage(VkBufferUsageFlags2 usage);

#endif
