/* SPDX-License-Identifier: Apache-2.0 */
/* The builder's input: the description of each geometry, and how much of its data can be read; and
 * sizes, computed from an input without data. */
#include "src/snapshots/build_input.h"

#include <stdlib.h>

#include "src/bvh/input/source.h"
#include "src/model/inputs.h"

/* The kind of BVH that the flags request. VK_BUILD_ACCELERATION_STRUCTURE_LOW_MEMORY_BIT_KHR is
 * kept among the BVH's flags and changes nothing else, because BVHs have one form. */
static enum builder_quality build_input_quality(VkBuildAccelerationStructureFlagsKHR flags)
{
    if (flags & VK_BUILD_ACCELERATION_STRUCTURE_PREFER_FAST_TRACE_BIT_KHR)
        return BUILDER_HIGH;
    if (flags & VK_BUILD_ACCELERATION_STRUCTURE_PREFER_FAST_BUILD_BIT_KHR)
        return BUILDER_FAST;
    return BUILDER_BALANCED;
}

static void describe_chained(const struct chained_input *from, struct builder_geometry *to)
{
    const VkAccelerationStructureGeometryLinearSweptSpheresDataNV *spheres = &from->spheres;
    switch ((int)to->type) {
    case VK_GEOMETRY_TYPE_SPHERES_NV:
    case VK_GEOMETRY_TYPE_LINEAR_SWEPT_SPHERES_NV:
        to->spheres = (struct builder_spheres){
            .vertex_format = spheres->vertexFormat,
            .radius_format = spheres->radiusFormat,
            .index_type = spheres->indexType,
            .vertex_stride = spheres->vertexStride,
            .radius_stride = spheres->radiusStride,
            .index_stride = spheres->indexStride,
            .indexing_mode = spheres->indexingMode,
            .end_caps_mode = spheres->endCapsMode,
        };
        break;
    case VK_GEOMETRY_TYPE_DENSE_GEOMETRY_FORMAT_TRIANGLES_AMDX:
        to->dense.max_primitive = from->dense.maxPrimitiveIndex;
        break;
    default: /* the builder rejects it */
        break;
    }
}

void build_input_describe(const VkAccelerationStructureGeometryKHR *geometry,
                          const struct chained_input *chained, struct builder_geometry *described)
{
    *described =
        (struct builder_geometry){.type = geometry->geometryType, .flags = geometry->flags};
    switch (geometry->geometryType) {
    case VK_GEOMETRY_TYPE_TRIANGLES_KHR: {
        const VkAccelerationStructureGeometryTrianglesDataKHR *triangles =
            &geometry->geometry.triangles;
        described->triangles.vertex_format = triangles->vertexFormat;
        described->triangles.index_type = triangles->indexType;
        described->triangles.max_vertex = triangles->maxVertex;
        described->triangles.vertex_stride = triangles->vertexStride;
        break;
    }
    case VK_GEOMETRY_TYPE_AABBS_KHR:
        described->aabbs.stride = geometry->geometry.aabbs.stride;
        break;
    case VK_GEOMETRY_TYPE_INSTANCES_KHR:
        described->instances.array_of_pointers = has_instance_pointers(geometry);
        break;
    default:
        if (chained)
            describe_chained(chained, described);
    }
}

/* ---- data */

/* If indices can't be read yet, the numbers of vertices and radii are unknown. */
static uint64_t end_of_spheres(const struct input_memory *memory,
                               const struct builder_spheres *spheres, bool is_swept,
                               const VkAccelerationStructureBuildRangeInfoKHR *range,
                               const struct geometry_input *input)
{
    const uint64_t count = sphere_vertex_count(spheres, is_swept, range);
    if (!input->is_chosen || input->count)
        return input_end(input);
    if (!count)
        return memory->is_later ? UINT64_MAX : 0;
    return input_extent(0, range->firstVertex + count - 1, input->stride, input->most);
}

/* Where the bytes of an input go. */
struct found_bytes {
    const void **bytes;
    uint64_t *size;
    bool is_optional; /* if it is given, the builder must know even if none of it can be read */
};

static struct found_bytes place_of(struct build_input *input, uint32_t geometry,
                                   enum input_role role)
{
    struct builder_geometry *to = &input->geometries[geometry];
    struct builder_displacement *displacement =
        input->displacements ? &input->displacements[geometry] : NULL;
#define PLACE(of, name)                                                                            \
    {                                                                                              \
        &(of)->name, &(of)->name##_size, false                                                     \
    }
#define OPTIONAL(of, name)                                                                         \
    {                                                                                              \
        &(of)->name, &(of)->name##_size, true                                                      \
    }
    switch (role) {
    case INPUT_VERTEX:
        return (struct found_bytes)PLACE(&to->triangles, vertices);
    case INPUT_MOTION_VERTEX:
        return (struct found_bytes)OPTIONAL(&to->triangles, motion_vertices);
    case INPUT_INDEX:
        return (struct found_bytes)PLACE(&to->triangles, indices);
    case INPUT_MATRIX:
        return (struct found_bytes)OPTIONAL(&to->triangles, transforms);
    case INPUT_AABBS:
        return (struct found_bytes){&to->aabbs.data, &to->aabbs.size, false};
    case INPUT_INSTANCES:
        return (struct found_bytes){&to->instances.data, &to->instances.size, false};
    case INPUT_SPHERE_VERTEX:
    case INPUT_SWEPT_VERTEX:
        return (struct found_bytes)PLACE(&to->spheres, vertices);
    case INPUT_SPHERE_RADIUS:
    case INPUT_SWEPT_RADIUS:
        return (struct found_bytes)PLACE(&to->spheres, radii);
    case INPUT_SPHERE_INDEX:
    case INPUT_SWEPT_INDEX:
        return (struct found_bytes)PLACE(&to->spheres, indices);
    case INPUT_DENSE_DATA:
        return (struct found_bytes){&to->dense.data, &to->dense.size, false};
    case INPUT_OPACITY_INDEX:
    case INPUT_OPACITY_EXT_INDEX:
        return (struct found_bytes)PLACE(&input->opacities[geometry], indices);
    case INPUT_DISPLACEMENT_INDEX:
        return (struct found_bytes)PLACE(displacement, indices);
    case INPUT_DISPLACEMENT_VECTOR:
        return (struct found_bytes)PLACE(displacement, vectors);
    case INPUT_DISPLACEMENT_BIAS:
        return (struct found_bytes)OPTIONAL(displacement, biases_and_scales);
    case INPUT_DISPLACEMENT_FLAGS:
        return (struct found_bytes)OPTIONAL(displacement, flags);
    case INPUT_MICROMAP_DATA: /* see build_input_find_micromap() */
    case INPUT_MICROMAP_TRIANGLES:
    case INPUT_SCRATCH:
    case INPUT_UPDATE_SCRATCH:
    case INPUT_INDIRECT:
    case INPUT_ROLES:
        break;
    }
    return (struct found_bytes){0};
#undef PLACE
#undef OPTIONAL
}

static bool is_read_by_rules(enum input_role role)
{
    switch (role) {
    case INPUT_MOTION_VERTEX:
    case INPUT_OPACITY_EXT_INDEX:
    case INPUT_DENSE_DATA:
    case INPUT_DISPLACEMENT_INDEX:
    case INPUT_DISPLACEMENT_VECTOR:
    case INPUT_DISPLACEMENT_BIAS:
    case INPUT_DISPLACEMENT_FLAGS:
    case INPUT_MICROMAP_DATA:
        return false;
    default:
        return true;
    }
}

static bool is_left_out(const struct input_memory *memory, const struct geometry_input *input)
{
    return (memory->is_for_rules && !is_read_by_rules(input->role)) ||
           (memory->is_host && input->is_of_device);
}

/* Indices come before what they choose among. */
static void find_data(const struct input_memory *memory, const struct build_parameters *build,
                      uint32_t geometry, struct build_input *input)
{
    const struct chained_input *chained = build->chained ? &build->chained[geometry] : NULL;
    struct builder_geometry *to = &input->geometries[geometry];
    const bool is_swept = type_is_swept_spheres(to->type),
               is_sphere = is_swept || type_is_spheres(to->type);
    struct geometry_input inputs[GEOMETRY_INPUTS];
    const uint32_t count = inputs_of_geometry(build->info.flags, &build->geometries[geometry],
                                              chained, &build->ranges[geometry], inputs);
    if (!build->ranges[geometry].primitiveCount ||
        (is_sphere && !sphere_formats_are_known(&to->spheres)))
        return;
    for (uint32_t i = 0; i < count; i++) {
        const struct found_bytes place = place_of(input, geometry, inputs[i].role);
        if (!place.bytes || is_left_out(memory, &inputs[i]))
            continue;
        const uint64_t end = is_sphere ? end_of_spheres(memory, &to->spheres, is_swept,
                                                        &build->ranges[geometry], &inputs[i])
                                       : input_end(&inputs[i]);
        if (end)
            *place.size =
                memory->find(memory->context, inputs[i].address.deviceAddress, end, place.bytes);
        if (place.is_optional && !*place.bytes)
            *place.bytes = build; /* it is given, and none of it can be read */
    }
}

/* ---- the whole input */

/* Resolves an element of an array of pointers. */
static const void *read_address(void *context, uint64_t address, uint64_t size)
{
    const struct input_memory *memory = context;
    const void *bytes;
    return memory->find(memory->context, address, size, &bytes) == size ? bytes : NULL;
}

static VkResult open_geometries(const struct build_parameters *build,
                                const struct input_memory *memory, struct build_input *input)
{
    uint32_t count = build->info.geometryCount;
    input->geometries = calloc(count, sizeof(*input->geometries));
    if (!input->geometries)
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    input->input.geometries = input->geometries;
    for (uint32_t i = 0; i < count; i++)
        build_input_describe(&build->geometries[i], build->chained ? &build->chained[i] : NULL,
                             &input->geometries[i]);
    VkResult result = build_input_describe_micromaps(build, input);
    for (uint32_t i = 0; result == VK_SUCCESS && i < count; i++)
        find_data(memory, build, i, input);
    if (result != VK_SUCCESS)
        build_input_close(input);
    return result;
}

VkResult build_input_open(const struct build_parameters *build, const struct input_memory *memory,
                          struct build_input *input)
{
    uint32_t count = build->info.geometryCount;
    *input = (struct build_input){
        .input = {.type = build->info.type,
                  .flags = build->info.flags,
                  .quality = build_input_quality(build->info.flags),
                  .geometry_count = count,
                  .ranges = build->ranges},
        .memory = *memory,
    };
    input->input.memory = (struct builder_memory){read_address, &input->memory};
    if ((int)build->info.type == VK_ACCELERATION_STRUCTURE_TYPE_OPACITY_MICROMAP_KHR) {
        input->is_micromap = true;
        build_input_find_micromap(build, memory, &input->micromap);
        return VK_SUCCESS;
    }
    return count ? open_geometries(build, memory, input) : VK_SUCCESS;
}

void build_input_close(struct build_input *input)
{
    free(input->geometries);
    free(input->opacities);
    free(input->displacements);
    input->geometries = NULL;
    input->opacities = NULL;
    input->displacements = NULL;
}

/* ---- sizes */

static uint64_t find_nothing(void *context, uint64_t address, uint64_t size, const void **bytes)
{
    (void)context;
    (void)address;
    (void)size;
    *bytes = NULL;
    return 0;
}

VkResult build_parameters_sizes(const struct build_parameters *build, const uint32_t *counts,
                                struct builder_sizes *sizes)
{
    const struct input_memory nothing = {.find = find_nothing};
    struct build_input input;
    *sizes = (struct builder_sizes){0};
    VkResult result = build_input_open(build, &nothing, &input);
    if (result == VK_SUCCESS && input.is_micromap)
        micromap_get_size(&input.micromap, &sizes->structure);
    else if (result == VK_SUCCESS)
        builder_get_sizes(&input.input, counts, sizes);
    build_input_close(&input);
    return result;
}

void cpu_build_sizes(const VkAccelerationStructureBuildGeometryInfoKHR *info,
                     const uint32_t *counts, struct builder_sizes *sizes)
{
    *sizes = (struct builder_sizes){0};
    struct readable_cache cache = {0};
    struct build_parameters build;
    if (build_parameters_copy(&cache, info, NULL, &build) != VK_SUCCESS)
        return;
    bool takes_counts = build_parameters_take_ranges(&build);
    if (!takes_counts ||
        readable(&cache, counts, sizeof(*counts) * (size_t)build.info.geometryCount))
        build_parameters_sizes(&build, takes_counts ? counts : NULL, sizes);
    build_parameters_release(&build);
}
