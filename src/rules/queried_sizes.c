/* SPDX-License-Identifier: Apache-2.0 */
/* Says in what the application's query of the sizes of a build differs from the build. */
#include "src/rules/shared.h"
#include "src/view/names.h"

static const char *member_name(enum size_member member)
{
    switch (member) {
    case SIZED_BUILD_TYPE:
        return "buildType";
    case SIZED_TYPE:
        return "type";
    case SIZED_FLAGS:
    case SIZED_GEOMETRY_FLAGS:
        return "flags";
    case SIZED_GEOMETRY_COUNT:
        return "geometryCount";
    case SIZED_GEOMETRY_TYPE:
        return "geometryType";
    case SIZED_PRIMITIVE_COUNT:
        return "pMaxPrimitiveCounts";
    case SIZED_VERTEX_FORMAT:
        return "vertexFormat";
    case SIZED_MAX_VERTEX:
        return "maxVertex";
    case SIZED_INDEX_TYPE:
        return "indexType";
    case SIZED_TRANSFORM:
        return "transformData";
    case SIZED_STRIDE:
        return "stride";
    }
    return "";
}

static struct value member_value(enum size_member member, uint64_t value)
{
    switch (member) {
    case SIZED_BUILD_TYPE:
        return phrase(value == VK_ACCELERATION_STRUCTURE_BUILD_TYPE_HOST_KHR
                          ? "VK_ACCELERATION_STRUCTURE_BUILD_TYPE_HOST_KHR"
                          : "VK_ACCELERATION_STRUCTURE_BUILD_TYPE_DEVICE_KHR");
    case SIZED_TYPE:
        return accel_type((VkAccelerationStructureTypeKHR)value);
    case SIZED_FLAGS:
        return build_flags((VkBuildAccelerationStructureFlagsKHR)value);
    case SIZED_GEOMETRY_FLAGS:
        return geometry_flags_of((VkGeometryFlagsKHR)value);
    case SIZED_GEOMETRY_TYPE:
        return geometry_type((VkGeometryTypeKHR)value);
    case SIZED_VERTEX_FORMAT:
        return format((VkFormat)value);
    case SIZED_INDEX_TYPE:
        return index_type((VkIndexType)value);
    case SIZED_TRANSFORM:
        return phrase(value ? "an address" : "0");
    case SIZED_GEOMETRY_COUNT:
    case SIZED_PRIMITIVE_COUNT:
    case SIZED_MAX_VERTEX:
    case SIZED_STRIDE:
        break;
    }
    return number(value);
}

static bool remarks_on_difference(struct finding *finding, VkDeviceSize size,
                                  const struct size_difference *difference)
{
    const struct value queried = member_value(difference->member, difference->queried);
    const struct value built = member_value(difference->member, difference->built);
    const struct value name = phrase(member_name(difference->member));
    if (difference->member < SIZED_GEOMETRY_TYPE)
        return remarks(finding, "The query that returned {} had {} {} instead of {}", number(size),
                       name, queried, built);
    return remarks(finding,
                   difference->member == SIZED_PRIMITIVE_COUNT
                       ? "The query that returned {} had {}[{}] {} instead of {}"
                       : "The query that returned {} had {} of pGeometries[{}] {} instead of {}",
                   number(size), name, number(difference->geometry), queried, built);
}

__attribute__((cold, noinline)) bool remarks_on_size_query(struct finding *finding,
                                                           const struct build_view *build,
                                                           enum queried_size which)
{
    const struct size_differences *queried = build->queried;
    const bool is_same_query = queried && queried->build == build->index && queried->which == which;
    for (uint32_t i = 0; is_same_query && i < queried->count; i++)
        remarks_on_difference(finding, queried->size, &queried->items[i]);
    return false;
}
