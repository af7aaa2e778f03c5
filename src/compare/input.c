/* SPDX-License-Identifier: Apache-2.0 */
/* Moves the input of a build to memory of the layer, and builds it with the reference builder.
 * Only base addresses change. Offsets, first vertices, strides and counts stay, since drivers have
 * errors in their use. */
#include "src/compare/input.h"

#include <stdlib.h>
#include <string.h>

#include "src/bvh/input/formats.h"
#include "src/model/inputs.h"
#include "src/platform/aligned.h"

/* The part of an array that a build reads: `size` bytes, `offset` bytes from its address. */
struct extent {
    uint64_t offset, size;
};

enum { EXTENTS = 3 /* per geometry: vertices or boxes, indices, transform */ };

/* A driver that adds an offset twice, or reads beyond the end to fill a vector, still reads
 * zeros. */
enum { PADDING = 4096 };

_Static_assert(INPUT_VERTEX == 0 && INPUT_INDEX == 1 && INPUT_MATRIX == 2, "numbers of extents");

/* The address of an input in the geometry; NULL if it has another type. */
static uint64_t *address_of(VkAccelerationStructureGeometryKHR *geometry, unsigned extent)
{
    const bool is_triangles = type_is_triangles(geometry->geometryType);
    if (!is_triangles && (extent || !type_is_aabbs(geometry->geometryType)))
        return NULL;
    return &input_place(geometry, NULL, is_triangles ? (enum input_role)extent : INPUT_AABBS)
                ->deviceAddress;
}

/* Returns pointers to the array addresses of a geometry, and the extents of the arrays. */
static void find_arrays(VkAccelerationStructureGeometryKHR *geometry,
                        const VkAccelerationStructureBuildRangeInfoKHR *range,
                        uint64_t *addresses[EXTENTS], struct extent extents[EXTENTS])
{
    struct geometry_input inputs[GEOMETRY_INPUTS];
    const uint32_t count = inputs_of_geometry(0, geometry, NULL, range, inputs);
    memset(extents, 0, EXTENTS * sizeof(*extents));
    for (unsigned i = 0; i < EXTENTS; i++)
        addresses[i] = address_of(geometry, i);
    for (uint32_t i = 0; i < count; i++) {
        const unsigned at = inputs[i].role <= INPUT_MATRIX ? inputs[i].role : 0;
        const uint64_t end = input_end(&inputs[i]);
        if (inputs[i].size && addresses[at])
            extents[at] = (struct extent){inputs[i].offset,
                                          end == UINT64_MAX ? UINT64_MAX : end - inputs[i].offset};
    }
}

/* Returns the bytes that an array needs from a multiple of the alignment on. */
static uint64_t room(uint64_t address, const struct extent *extent)
{
    uint64_t size = address % COMPARE_ALIGNMENT + 2 * extent->offset + 2 * extent->size + PADDING;
    return (size + COMPARE_ALIGNMENT - 1) / COMPARE_ALIGNMENT * COMPARE_ALIGNMENT;
}

uint64_t compare_input_size(const struct compare_input *input)
{
    const struct build_parameters *build = input->parameters;
    uint64_t size = COMPARE_ALIGNMENT;
    for (uint32_t i = 0; i < build->info.geometryCount; i++) {
        VkAccelerationStructureGeometryKHR geometry = build->geometries[i];
        uint64_t *addresses[EXTENTS];
        struct extent extents[EXTENTS];
        find_arrays(&geometry, &build->ranges[i], addresses, extents);
        for (int j = 0; j < EXTENTS; j++) {
            const void *bytes;
            if (extents[j].size == 0)
                continue;
            if (extents[j].size > COMPARE_INPUT_MAX || extents[j].offset > COMPARE_INPUT_MAX ||
                input->memory->find(input->memory->context, *addresses[j] + extents[j].offset,
                                    extents[j].size, &bytes) < extents[j].size)
                return UINT64_MAX;
            size += room(*addresses[j], &extents[j]);
            if (size > COMPARE_INPUT_MAX)
                return UINT64_MAX;
        }
    }
    return (size + COMPARE_ALIGNMENT - 1) / COMPARE_ALIGNMENT * COMPARE_ALIGNMENT;
}

void compare_input_place(const struct compare_input *input, uint64_t address, unsigned char *bytes,
                         VkAccelerationStructureGeometryKHR *geometries)
{
    const struct build_parameters *build = input->parameters;
    uint64_t used = 0;
    for (uint32_t i = 0; i < build->info.geometryCount; i++) {
        uint64_t *addresses[EXTENTS];
        struct extent extents[EXTENTS];
        geometries[i] = build->geometries[i];
        find_arrays(&geometries[i], &build->ranges[i], addresses, extents);
        for (int j = 0; j < EXTENTS; j++) {
            const void *from;
            if (addresses[j] && *addresses[j] && extents[j].size == 0)
                *addresses[j] = address; /* the build reads nothing there */
            if (extents[j].size == 0)
                continue;
            uint64_t at = used + *addresses[j] % COMPARE_ALIGNMENT;
            used += room(*addresses[j], &extents[j]);
            input->memory->find(input->memory->context, *addresses[j] + extents[j].offset,
                                extents[j].size, &from);
            memcpy(bytes + at + extents[j].offset, from, extents[j].size);
            *addresses[j] = address + at;
        }
    }
}

/* ---- copies */

static uint64_t find_copied_bytes(void *context, uint64_t address, uint64_t size,
                                  const void **bytes)
{
    const struct input_copy *copy = context;
    uint64_t offset = address - (uint64_t)(uintptr_t)copy->bytes;
    *bytes = NULL;
    if (offset >= copy->size)
        return 0;
    *bytes = copy->bytes + offset;
    return size < copy->size - offset ? size : copy->size - offset;
}

static VkResult fill_copy(const struct compare_input *input, struct input_copy *copy)
{
    const struct build_parameters *from = input->parameters;
    uint32_t count = from->info.geometryCount;
    copy->size = compare_input_size(input);
    if (copy->size == UINT64_MAX)
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    copy->parameters.info = from->info;
    copy->parameters.info.pGeometries = NULL;
    copy->parameters.info.ppGeometries = NULL;
    VkResult result = build_parameters_allocate(&copy->parameters, count);
    copy->bytes = aligned_allocate(COMPARE_ALIGNMENT, copy->size);
    if (result != VK_SUCCESS || !copy->bytes)
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    memset(copy->bytes, 0, copy->size);
    compare_input_place(input, (uint64_t)(uintptr_t)copy->bytes, copy->bytes,
                        copy->parameters.geometries);
    for (uint32_t i = 0; i < count; i++)
        copy->parameters.ranges[i] = from->ranges[i];
    return VK_SUCCESS;
}

struct input_copy *input_copy_create(const struct compare_input *input)
{
    struct input_copy *copy = calloc(1, sizeof(*copy));
    if (!copy)
        return NULL;
    copy->memory = (struct input_memory){.find = find_copied_bytes, .context = copy};
    copy->input = (struct compare_input){&copy->parameters, &copy->memory};
    if (fill_copy(input, copy) == VK_SUCCESS)
        return copy;
    input_copy_free(copy);
    return NULL;
}

void input_copy_free(struct input_copy *copy)
{
    if (!copy)
        return;
    build_parameters_release(&copy->parameters);
    aligned_free(copy->bytes);
    free(copy);
}

/* ---- builds a compared input with the reference builder */

/* Allocates memory with the alignment that the builder requires of structures and scratch. */
static void *allocate_input(uint64_t size)
{
    uint64_t room = (size + BUILDER_ALIGNMENT - 1) / BUILDER_ALIGNMENT * BUILDER_ALIGNMENT;
    return aligned_allocate(BUILDER_ALIGNMENT, room ? room : BUILDER_ALIGNMENT);
}

bool reference_supports(const struct build_parameters *build)
{
    if (build->info.type == VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR ||
        build->info.flags & VK_BUILD_ACCELERATION_STRUCTURE_MOTION_BIT_NV)
        return false;
    for (uint32_t i = 0; i < build->info.geometryCount; i++) {
        const VkGeometryTypeKHR type = build->geometries[i].geometryType;
        if ((!type_is_triangles(type) && !type_is_aabbs(type)) ||
            type != build->geometries[0].geometryType)
            return false;
    }
    return true;
}

/* maxVertex counts from the array on; the builder's max_vertex counts from the first vertex. */
static void limit_vertices(const struct build_parameters *build, struct build_input *input)
{
    for (uint32_t i = 0; i < build->info.geometryCount; i++) {
        struct builder_triangles *triangles = &input->geometries[i].triangles;
        uint32_t first = build->ranges[i].firstVertex;
        if (type_is_triangles(build->geometries[i].geometryType))
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

static VkResult build_reference(struct reference *reference)
{
    const struct builder_input *input = &reference->input.input;
    struct builder_sizes sizes;
    if (builder_get_sizes(input, NULL, &sizes) != BUILDER_OK)
        return VK_ERROR_FORMAT_NOT_SUPPORTED;
    void *scratch = allocate_input(sizes.build_scratch);
    reference->structure = allocate_input(sizes.structure);
    const bool has_memory = scratch && reference->structure;
    const bool is_built =
        has_memory && builder_build(input, reference->structure, sizes.structure, scratch,
                                    sizes.build_scratch, &reference->report) == BUILDER_OK;
    aligned_free(scratch);
    if (!has_memory)
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    return is_built ? VK_SUCCESS : VK_ERROR_FORMAT_NOT_SUPPORTED;
}

VkResult reference_open(const struct input_copy *copy, struct reference *reference)
{
    const struct build_parameters *parameters = &copy->parameters;
    *reference = (struct reference){.geometry_count = parameters->info.geometryCount};
    if (!reference_supports(parameters))
        return VK_ERROR_FORMAT_NOT_SUPPORTED;
    reference->is_aabbs =
        parameters->info.geometryCount > 0 && type_is_aabbs(parameters->geometries[0].geometryType);
    VkResult result = build_input_open(parameters, &copy->memory, &reference->input);
    if (result != VK_SUCCESS)
        return result;
    limit_vertices(parameters, &reference->input);
    reference->input.input.type = VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR;
    result = open_sources(reference);
    return result == VK_SUCCESS ? build_reference(reference) : result;
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
