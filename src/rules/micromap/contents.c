/* SPDX-License-Identifier: Apache-2.0 */
/* Rules about the triangles of micromaps, and about the indices that map triangles to micromap
 * triangles. */
#include "src/rules/predicates.h"
#include "src/rules/shared.h"

#define TRIANGLES MICROMAP_DATA "triangleArray"

/* ---- triangles of a micromap */

static bool is_lossy(const struct micromap_triangle_view *view)
{
    return view->geometry->build->info->flags &
           VK_BUILD_ACCELERATION_STRUCTURE_MICROMAP_LOSSY_BIT_KHR;
}

static const struct device_facts *device_of(const struct micromap_triangle_view *view)
{
    return view->geometry->build->call->device;
}

static bool level_is_within(const struct micromap_triangle_view *view, uint32_t limit,
                            const char *limit_name, struct finding *finding)
{
    return view->triangle.subdivisionLevel <= limit ||
           violated(
               finding, TRIANGLES,
               "leads to triangle {}, whose subdivisionLevel {} with format {} exceeds {} ({})",
               number(view->index), number(view->triangle.subdivisionLevel),
               number(view->triangle.format), phrase(limit_name), number(limit));
}

/* The largest subdivision level whose data size can be computed. No format supports a higher
 * one. */
enum { LEVEL_MAX = 15 };

/* Returns the size in bytes, or 0 if unknown. */
static uint64_t data_size(const VkMicromapTriangleKHR *triangle)
{
    if (triangle->subdivisionLevel > LEVEL_MAX ||
        (triangle->format != VK_OPACITY_MICROMAP_FORMAT_2_STATE_KHR &&
         triangle->format != VK_OPACITY_MICROMAP_FORMAT_4_STATE_KHR))
        return 0;
    uint64_t bits_each = triangle->format == VK_OPACITY_MICROMAP_FORMAT_4_STATE_KHR ? 2 : 1;
    return ((bits_each << 2 * triangle->subdivisionLevel) + 7) / 8;
}

bool micromap_triangle_data_is_in_its_buffer(const struct micromap_triangle_view *micromap_triangle,
                                             struct finding *finding)
{
    const VkMicromapTriangleKHR *triangle = &micromap_triangle->triangle;
    uint64_t size = data_size(triangle), left = micromap_triangle->data_left;
    return !left || !size || triangle->dataOffset + size <= left ||
           violated(finding, TRIANGLES,
                    "leads to triangle {}, which needs {} at dataOffset {}, but the buffer has {} "
                    "from data on",
                    number(micromap_triangle->index), count_of(size, "byte"),
                    number(triangle->dataOffset), count_of(left, "byte"));
}

bool micromap_triangle_format_is_valid(const struct micromap_triangle_view *micromap_triangle,
                                       struct finding *finding)
{
    uint32_t format = micromap_triangle->triangle.format;
    return format == VK_OPACITY_MICROMAP_FORMAT_2_STATE_KHR ||
           format == VK_OPACITY_MICROMAP_FORMAT_4_STATE_KHR ||
           device_of(micromap_triangle)->newer_than_registry ||
           violated(finding, TRIANGLES,
                    "leads to triangle {}, whose format {} is not a VkOpacityMicromapFormatKHR",
                    number(micromap_triangle->index), number(format));
}

bool triangle_2_state_level_is_within_limit(const struct micromap_triangle_view *micromap_triangle,
                                            struct finding *finding)
{
    return micromap_triangle->triangle.format != VK_OPACITY_MICROMAP_FORMAT_2_STATE_KHR ||
           level_is_within(micromap_triangle,
                           device_of(micromap_triangle)->micromap.khr_limits.opacity_2_state_level,
                           "maxOpacity2StateSubdivisionLevel", finding);
}

bool triangle_4_state_level_is_within_limit(const struct micromap_triangle_view *micromap_triangle,
                                            struct finding *finding)
{
    return is_lossy(micromap_triangle) ||
           micromap_triangle->triangle.format != VK_OPACITY_MICROMAP_FORMAT_4_STATE_KHR ||
           level_is_within(micromap_triangle,
                           device_of(micromap_triangle)->micromap.khr_limits.opacity_4_state_level,
                           "maxOpacity4StateSubdivisionLevel", finding);
}

bool lossy_triangle_level_is_within_limit(const struct micromap_triangle_view *micromap_triangle,
                                          struct finding *finding)
{
    return !is_lossy(micromap_triangle) ||
           level_is_within(micromap_triangle,
                           device_of(micromap_triangle)->micromap.khr_limits.lossy_4_state_level,
                           "maxOpacityLossy4StateSubdivisionLevel", finding);
}

bool lossy_triangle_is_4_state(const struct micromap_triangle_view *micromap_triangle,
                               struct finding *finding)
{
    uint32_t format = micromap_triangle->triangle.format;
    return !is_lossy(micromap_triangle) || format == VK_OPACITY_MICROMAP_FORMAT_4_STATE_KHR ||
           violated(finding, TRIANGLES,
                    "leads to triangle {}, whose format {} is not "
                    "VK_OPACITY_MICROMAP_FORMAT_4_STATE_KHR, which "
                    "VK_BUILD_ACCELERATION_STRUCTURE_MICROMAP_LOSSY_BIT_KHR in flags requires",
                    number(micromap_triangle->index), number(format));
}

/* ---- indices into a micromap */

/* Special indices are negative numbers of the index type's width. */
static int64_t signed_index(const struct opacity_index_view *view)
{
    uint32_t sign = UINT32_C(1) << (view->bits - 1);
    return (int64_t)(view->index ^ sign) - (int64_t)sign;
}

static bool is_special(int64_t index)
{
    return index < 0 &&
           index >= VK_OPACITY_MICROMAP_SPECIAL_INDEX_CLUSTER_GEOMETRY_DISABLE_OPACITY_MICROMAP_NV;
}

bool opacity_index_is_within_micromap(const struct opacity_index_view *opacity_index,
                                      struct finding *finding)
{
    int64_t index = signed_index(opacity_index);
    uint64_t count = opacity_index->triangle_count, base = opacity_index->base_triangle;
    return !opacity_index->micromap || !opacity_index->count_known || index <= 0 ||
           (uint64_t)index + base <= count ||
           violated(finding, OPACITY_DATA "indexBuffer",
                    "has index {} for primitive {}, which plus baseTriangle {} is beyond the {} "
                    "that {} was last built with",
                    number((uint64_t)index), number(opacity_index->primitive), number(base),
                    count_of(count, "triangle"),
                    object(VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR, opacity_index->micromap));
}

bool opacity_index_without_micromap_is_special(const struct opacity_index_view *opacity_index,
                                               struct finding *finding)
{
    return opacity_index->micromap || is_special(signed_index(opacity_index)) ||
           opacity_index->geometry->build->call->device->newer_than_registry ||
           violated(finding, OPACITY_DATA "indexBuffer",
                    "has index {} for primitive {}, but without a micromap only values of "
                    "VkOpacityMicromapSpecialIndexKHR are valid",
                    number(opacity_index->index), number(opacity_index->primitive));
}
