/* SPDX-License-Identifier: Apache-2.0 */
/* Names of enumerants. The only file that includes vk_enum_string_helper.h, which is large. */
#include "src/view/names.h"

#include <string.h>
#include <vulkan/vk_enum_string_helper.h>

/* The helpers return "Unhandled VkX" for unknown values. */
static struct value spelling(const char *name, uint64_t value)
{
    return strncmp(name, "VK_", 3) == 0 ? text(name) : number(value);
}

struct value structure_type(VkStructureType type)
{
    return spelling(string_VkStructureType(type), (uint32_t)type);
}

struct value geometry_type(VkGeometryTypeKHR type)
{
    return spelling(string_VkGeometryTypeKHR(type), (uint32_t)type);
}

struct value accel_type(VkAccelerationStructureTypeKHR type)
{
    return spelling(string_VkAccelerationStructureTypeKHR(type), (uint32_t)type);
}

struct value index_type(VkIndexType type)
{
    return spelling(string_VkIndexType(type), (uint32_t)type);
}

struct value copy_mode(VkCopyAccelerationStructureModeKHR mode)
{
    return spelling(string_VkCopyAccelerationStructureModeKHR(mode), (uint32_t)mode);
}

struct value micromap_copy_mode(VkCopyMicromapModeEXT mode)
{
    return spelling(string_VkCopyMicromapModeEXT(mode), (uint32_t)mode);
}

struct value query_type(VkQueryType type)
{
    return spelling(string_VkQueryType(type), (uint32_t)type);
}

struct value format(VkFormat format)
{
    return spelling(string_VkFormat(format), (uint32_t)format);
}
