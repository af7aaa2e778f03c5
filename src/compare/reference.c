/* SPDX-License-Identifier: Apache-2.0 */
/* Builds a compared input with the reference builder. */
#include "src/compare/reference.h"

#include <stdlib.h>

#include "src/platform/aligned.h"

/* Allocates memory with the alignment that the builder requires of structures and scratch. */
static void *allocate(uint64_t size)
{
    uint64_t room = (size + BUILDER_ALIGNMENT - 1) / BUILDER_ALIGNMENT * BUILDER_ALIGNMENT;
    return aligned_allocate(BUILDER_ALIGNMENT, room ? room : BUILDER_ALIGNMENT);
}

bool reference_supports(const struct build_parameters *build)
{
    VkGeometryTypeKHR type = VK_GEOMETRY_TYPE_TRIANGLES_KHR;
    if (build->info.type == VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR ||
        build->info.flags & VK_BUILD_ACCELERATION_STRUCTURE_MOTION_BIT_NV)
        return false;
    for (uint32_t i = 0; i < build->info.geometryCount; i++) {
        if (i == 0)
            type = build->geometries[i].geometryType;
        if (build->geometries[i].geometryType != type)
            return false;
    }
    return type == VK_GEOMETRY_TYPE_TRIANGLES_KHR || type == VK_GEOMETRY_TYPE_AABBS_KHR;
}

/* maxVertex counts from vertexData; the builder's max_vertex counts from the first vertex. */
static void limit_vertices(const struct build_parameters *build, struct build_input *input)
{
    for (uint32_t i = 0; i < build->info.geometryCount; i++) {
        struct builder_triangles *triangles = &input->geometries[i].triangles;
        uint32_t first = build->ranges[i].firstVertex;
        if (build->geometries[i].geometryType == VK_GEOMETRY_TYPE_TRIANGLES_KHR)
            triangles->max_vertex -= first < triangles->max_vertex ? first : triangles->max_vertex;
    }
}

static VkResult open_sources(struct reference *reference)
{
    const struct builder_input *input = &reference->input.input;
    reference->sources = calloc(input->geometry_count + 1ull, sizeof(*reference->sources));
    if (!reference->sources)
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    for (uint32_t i = 0; i < input->geometry_count; i++) {
        uint32_t count = input->ranges[i].primitiveCount;
        const struct builder_geometry *geometry = &input->geometries[i];
        if (count == 0)
            continue;
        if ((!reference->is_aabbs && !vertex_format_find(geometry->triangles.vertex_format)) ||
            !source_open(&reference->sources[i], false, geometry, &input->ranges[i]))
            return VK_ERROR_FORMAT_NOT_SUPPORTED;
        reference->primitive_count += count;
        if (count > reference->most_primitives)
            reference->most_primitives = count;
    }
    return VK_SUCCESS;
}

static VkResult build(struct reference *reference)
{
    const struct builder_input *input = &reference->input.input;
    struct builder_sizes sizes;
    if (builder_get_sizes(input, NULL, &sizes) != BUILDER_OK)
        return VK_ERROR_FORMAT_NOT_SUPPORTED;
    void *scratch = allocate(sizes.build_scratch);
    reference->structure = allocate(sizes.structure);
    if (!scratch || !reference->structure) {
        aligned_free(scratch);
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    }
    enum builder_result result = builder_build(input, reference->structure, sizes.structure,
                                               scratch, sizes.build_scratch, &reference->report);
    aligned_free(scratch);
    return result == BUILDER_OK ? VK_SUCCESS : VK_ERROR_FORMAT_NOT_SUPPORTED;
}

VkResult reference_open(const struct input_copy *copy, struct reference *reference)
{
    const struct build_parameters *parameters = &copy->parameters;
    *reference = (struct reference){.geometry_count = parameters->info.geometryCount};
    if (!reference_supports(parameters))
        return VK_ERROR_FORMAT_NOT_SUPPORTED;
    reference->is_aabbs = parameters->info.geometryCount > 0 &&
                          parameters->geometries[0].geometryType == VK_GEOMETRY_TYPE_AABBS_KHR;
    VkResult result = build_input_open(parameters, &copy->memory, &reference->input);
    if (result != VK_SUCCESS)
        return result;
    limit_vertices(parameters, &reference->input);
    reference->input.input.type = VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR;
    result = open_sources(reference);
    return result == VK_SUCCESS ? build(reference) : result;
}

void reference_close(struct reference *reference)
{
    aligned_free(reference->structure);
    free(reference->sources);
    build_input_close(&reference->input);
    *reference = (struct reference){0};
}

enum source_state reference_triangle(const struct reference *reference, uint32_t geometry,
                                     uint32_t primitive, struct triangle_record *triangle)
{
    return source_triangle(&reference->sources[geometry], primitive, triangle);
}

enum source_state reference_aabb(const struct reference *reference, uint32_t geometry,
                                 uint32_t primitive, struct aabb_record *box)
{
    return source_aabb(&reference->sources[geometry], primitive, box);
}
