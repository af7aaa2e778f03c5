/* SPDX-License-Identifier: Apache-2.0 */
/* The reference builder's structure of a compared input. */
#include "compare/reference.h"

#include <stdlib.h>
#include <string.h>

/* Room that the builder's structures and scratch are aligned to. */
static void *allocate(uint64_t size)
{
    uint64_t room = (size + BUILDER_ALIGNMENT - 1) / BUILDER_ALIGNMENT * BUILDER_ALIGNMENT;
    return aligned_alloc(BUILDER_ALIGNMENT, room ? room : BUILDER_ALIGNMENT);
}

static uint64_t find(void *context, uint64_t address, uint64_t size, const void **bytes)
{
    const struct reference *reference = context;
    uint64_t offset = address - (uint64_t)(uintptr_t)reference->bytes;
    *bytes = NULL;
    if (offset >= reference->size)
        return 0;
    *bytes = reference->bytes + offset;
    return size < reference->size - offset ? size : reference->size - offset;
}

/* A copy, laid out as the driver's is. */
static VkResult copy_input(const struct compare_input *input, struct reference *reference)
{
    const struct build_parameters *from = input->parameters;
    struct build_parameters *to = &reference->placed;
    uint32_t count = from->info.geometryCount;
    to->info = from->info;
    reference->size = compare_input_size(input);
    VkResult result = build_parameters_allocate(to, count);
    if (result != VK_SUCCESS)
        return result;
    reference->bytes = aligned_alloc(COMPARE_ALIGNMENT, reference->size);
    if (!reference->bytes)
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    memset(reference->bytes, 0, reference->size);
    compare_input_place(input, (uint64_t)(uintptr_t)reference->bytes, reference->bytes,
                        to->geometries);
    for (uint32_t i = 0; i < count; i++) {
        VkAccelerationStructureGeometryTrianglesDataKHR *triangles =
            &to->geometries[i].geometry.triangles;
        to->ranges[i] = from->ranges[i];
        if (to->geometries[i].geometryType == VK_GEOMETRY_TYPE_TRIANGLES_KHR)
            triangles->maxVertex -= to->ranges[i].firstVertex < triangles->maxVertex
                                        ? to->ranges[i].firstVertex
                                        : triangles->maxVertex;
    }
    reference->memory = (struct input_memory){.find = find, .context = reference};
    return VK_SUCCESS;
}

static bool is_comparable(const struct build_parameters *build)
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
        free(scratch);
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    }
    enum builder_result result = builder_build(input, reference->structure, sizes.structure,
                                               scratch, sizes.build_scratch, &reference->report);
    free(scratch);
    return result == BUILDER_OK ? VK_SUCCESS : VK_ERROR_FORMAT_NOT_SUPPORTED;
}

VkResult reference_open(const struct compare_input *input, struct reference *reference)
{
    const struct build_parameters *parameters = input->parameters;
    *reference = (struct reference){.geometry_count = parameters->info.geometryCount};
    if (!is_comparable(parameters) || compare_input_size(input) == UINT64_MAX)
        return VK_ERROR_FORMAT_NOT_SUPPORTED;
    reference->is_aabbs = parameters->info.geometryCount > 0 &&
                          parameters->geometries[0].geometryType == VK_GEOMETRY_TYPE_AABBS_KHR;
    VkResult result = copy_input(input, reference);
    if (result == VK_SUCCESS)
        result = build_input_open(&reference->placed, &reference->memory, &reference->input);
    if (result != VK_SUCCESS)
        return result;
    reference->input.input.type = VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR;
    result = open_sources(reference);
    return result == VK_SUCCESS ? build(reference) : result;
}

void reference_close(struct reference *reference)
{
    free(reference->structure);
    free(reference->sources);
    build_input_close(&reference->input);
    build_parameters_release(&reference->placed);
    free(reference->bytes);
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
