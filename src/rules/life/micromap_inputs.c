/* SPDX-License-Identifier: Apache-2.0 */
/* Rules about the host memory of micromap builds, and about the data of their triangles. */
#include <string.h>

#include "src/rules/predicates.h"

/* ---- host memory */

bool built_micromap_triangles_are_host_memory(const struct built_micromap_view *built_micromap,
                                              struct finding *finding)
{
    static const char field[] = "triangleArray.hostAddress";
    const struct host_bytes *bytes = &built_micromap->host_triangles;
    if (!built_micromap->triangle_count)
        return true;
    if (!bytes->address)
        return violated_plainly(finding, field, "is NULL");
    return !bytes->unreadable ||
           violated(finding, field, "{} does not point to {} with triangleArrayStride {}",
                    hex((uint64_t)(uintptr_t)bytes->address),
                    count_of(built_micromap->triangle_count, "readable triangle"),
                    number(built_micromap->info->triangleArrayStride));
}

bool built_micromap_data_is_host_memory(const struct built_micromap_view *built_micromap,
                                        struct finding *finding)
{
    static const char field[] = "data.hostAddress";
    const struct host_bytes *bytes = &built_micromap->host_data;
    if (!built_micromap->triangle_count)
        return true;
    if (!bytes->address)
        return violated_plainly(finding, field, "is NULL");
    return !bytes->unreadable ||
           violated(finding, field,
                    "{} is invalid: triangle {} has {} of data at {}, which is not host memory",
                    hex((uint64_t)(uintptr_t)bytes->address), number(built_micromap->triangle),
                    count_of(bytes->size, "byte"), hex(bytes->begin));
}

bool built_micromap_scratch_is_host_memory(const struct built_micromap_view *built_micromap,
                                           struct finding *finding)
{
    const struct host_bytes *scratch = &built_micromap->host_scratch;
    return built_micromap->info->mode != VK_BUILD_MICROMAP_MODE_BUILD_EXT || !scratch->size ||
           !scratch->unreadable ||
           violated(finding, "scratchData.hostAddress",
                    "{} does not point to {} of host memory (buildScratchSize)",
                    hex(scratch->begin), count_of(scratch->size, "byte"));
}

/* ---- the data of triangles */

static bool is_of_opacity(const struct micromap_triangles_view *triangles)
{
    return triangles->type == VK_MICROMAP_TYPE_OPACITY_MICROMAP_EXT;
}

static bool is_of_displacement(const struct micromap_triangles_view *triangles)
{
    return triangles->type == VK_MICROMAP_TYPE_DISPLACEMENT_MICROMAP_NV;
}

static VkMicromapTriangleEXT triangle_at(const struct micromap_triangles_view *triangles,
                                         uint64_t index)
{
    VkMicromapTriangleEXT triangle;
    memcpy(&triangle, triangles->first + index * triangles->stride, sizeof(triangle));
    return triangle;
}

/* Each format is from 1 to `last`. */
static bool formats_are_valid(const struct micromap_triangles_view *triangles, uint32_t last,
                              const char *type, struct finding *finding)
{
    for (uint64_t i = 0; !triangles->call->device->newer_than_registry && i < triangles->count;
         i++) {
        const uint32_t format = triangle_at(triangles, i).format;
        if (format < 1 || format > last)
            return violated(finding, "triangleArray",
                            "leads to triangle {}, whose format {} is not a {}", number(i),
                            number(format), phrase(type));
    }
    return true;
}

bool triangle_format_is_an_opacity_format(const struct micromap_triangles_view *micromap_triangles,
                                          struct finding *finding)
{
    return !is_of_opacity(micromap_triangles) ||
           formats_are_valid(micromap_triangles, VK_OPACITY_MICROMAP_FORMAT_4_STATE_EXT,
                             "VkOpacityMicromapFormatEXT", finding);
}

bool triangle_format_is_a_displacement_format(
    const struct micromap_triangles_view *micromap_triangles, struct finding *finding)
{
    return !is_of_displacement(micromap_triangles) ||
           formats_are_valid(micromap_triangles,
                             VK_DISPLACEMENT_MICROMAP_FORMAT_1024_TRIANGLES_128_BYTES_NV,
                             "VkDisplacementMicromapFormatNV", finding);
}

enum { ANY_FORMAT = 0 };

static bool levels_are_within(const struct micromap_triangles_view *triangles, uint32_t format,
                              uint32_t limit, const char *limit_name, struct finding *finding)
{
    for (uint64_t i = 0; i < triangles->count; i++) {
        const VkMicromapTriangleEXT triangle = triangle_at(triangles, i);
        if ((format == ANY_FORMAT || triangle.format == format) &&
            triangle.subdivisionLevel > limit)
            return violated(
                finding, "triangleArray",
                "leads to triangle {}, whose subdivisionLevel {} with format {} exceeds {} ({})",
                number(i), number(triangle.subdivisionLevel), number(triangle.format),
                phrase(limit_name), number(limit));
    }
    return true;
}

bool ext_triangle_2_state_level_is_within_limit(
    const struct micromap_triangles_view *micromap_triangles, struct finding *finding)
{
    return !is_of_opacity(micromap_triangles) ||
           levels_are_within(
               micromap_triangles, VK_OPACITY_MICROMAP_FORMAT_2_STATE_EXT,
               micromap_triangles->call->device->micromap.ext_limits.opacity_2_state_level,
               "maxOpacity2StateSubdivisionLevel", finding);
}

bool ext_triangle_4_state_level_is_within_limit(
    const struct micromap_triangles_view *micromap_triangles, struct finding *finding)
{
    return !is_of_opacity(micromap_triangles) ||
           levels_are_within(
               micromap_triangles, VK_OPACITY_MICROMAP_FORMAT_4_STATE_EXT,
               micromap_triangles->call->device->micromap.ext_limits.opacity_4_state_level,
               "maxOpacity4StateSubdivisionLevel", finding);
}

bool displacement_triangle_level_is_within_limit(
    const struct micromap_triangles_view *micromap_triangles, struct finding *finding)
{
    return !is_of_displacement(micromap_triangles) ||
           levels_are_within(micromap_triangles, ANY_FORMAT,
                             micromap_triangles->call->device->micromap.displacement_level,
                             "maxDisplacementMicromapSubdivisionLevel", finding);
}
