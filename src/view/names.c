/* SPDX-License-Identifier: Apache-2.0 */
/* Names of enumerants. The only file that includes vk_enum_string_helper.h, which is large. */
#include "src/view/names.h"

#include <string.h>
#include <vulkan/vk_enum_string_helper.h>

/* The helpers return "Unhandled VkX" for unknown values. */
static struct value spelling(const char *name, uint64_t value)
{
    return strncmp(name, "VK_", 3) == 0 ? phrase(name) : number(value);
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

/* ---- flags */

/* The helpers return "Unhandled VkX" for unknown bits. */
static const char *without_prefix(const char *name, const char *prefix)
{
    const size_t length = strlen(prefix);
    return strncmp(name, prefix, length) == 0 ? name + length : NULL;
}

#define FLAGS(function, flags_type, helper, bit_type, prefix)                                      \
    static const char *name_of_##function(uint64_t bit)                                            \
    {                                                                                              \
        return without_prefix(helper((bit_type)bit), prefix);                                      \
    }                                                                                              \
    struct value function(flags_type flags)                                                        \
    {                                                                                              \
        return (struct value){                                                                     \
            .kind = VALUE_FLAGS, .number = flags, .name_of_bit = name_of_##function};              \
    }

FLAGS(build_flags, VkBuildAccelerationStructureFlagsKHR,
      string_VkBuildAccelerationStructureFlagBitsKHR, VkBuildAccelerationStructureFlagBitsKHR,
      "VK_BUILD_ACCELERATION_STRUCTURE_")
FLAGS(geometry_flags_of, VkGeometryFlagsKHR, string_VkGeometryFlagBitsKHR, VkGeometryFlagBitsKHR,
      "VK_GEOMETRY_")
FLAGS(instance_flags, VkGeometryInstanceFlagsKHR, string_VkGeometryInstanceFlagBitsKHR,
      VkGeometryInstanceFlagBitsKHR, "VK_GEOMETRY_INSTANCE_")
FLAGS(accel_create_flags, VkAccelerationStructureCreateFlagsKHR,
      string_VkAccelerationStructureCreateFlagBitsKHR, VkAccelerationStructureCreateFlagBitsKHR,
      "VK_ACCELERATION_STRUCTURE_CREATE_")
FLAGS(buffer_usage, VkBufferUsageFlags2, string_VkBufferUsageFlagBits2, uint64_t,
      "VK_BUFFER_USAGE_2_")
