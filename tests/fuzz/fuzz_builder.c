/* SPDX-License-Identifier: Apache-2.0 */
/* Fuzz target: geometry descriptions and their data, and serialized structures. Whatever is built
 * or taken from bytes is then traced, refitted, compacted and measured. */
#include <math.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include "fuzz.h"
#include "src/bvh/input/displacement.h"
#include "tests/builder/digest.h"
#include "tests/builder/fixture.h"

uint64_t fuzz_digest = DIGEST_BEGIN;

/* Reads from the input until nothing is left, then zeros. */
struct reader {
    const uint8_t *at;
    size_t left;
};

static void take(struct reader *reader, void *to, size_t size)
{
    size_t count = size < reader->left ? size : reader->left;
    memset(to, 0, size);
    memcpy(to, reader->at, count);
    reader->at += count;
    reader->left -= count;
}

static uint32_t take_number(struct reader *reader, uint32_t below)
{
    uint16_t number;
    take(reader, &number, sizeof(number));
    return number % below;
}

static const struct builder_uuids uuids = {{'a'}, {'b'}};

/* References are resolved to nothing but this. */
static void *small_blas;

static const void *find_small(void *context, uint64_t reference)
{
    return reference % 2 ? small_blas : NULL;
}

/* Two triangles, one of each format. */
static const void *find_micromap(void *context, uint64_t reference)
{
    static _Alignas(BUILDER_ALIGNMENT) uint8_t micromap[256];
    static const uint8_t data[8] = {0x5a, 0x12, 0x34, 0x1b, 0xff, 0, 0x80, 1};
    static const VkMicromapUsageEXT usages[2] = {{1, 2, 1}, {1, 1, 2}};
    static const VkMicromapTriangleEXT triangles[2] = {{0, 2, 1}, {3, 1, 2}};
    if (micromap[0] == 0) {
        const struct micromap_input input = fixture_micromap_input(
            VK_MICROMAP_TYPE_OPACITY_MICROMAP_EXT, 2, usages, data, sizeof(data), 2, triangles);
        if (micromap_build(&input, micromap, sizeof(micromap)) != BUILDER_OK)
            abort();
    }
    return reference == 1 ? micromap : NULL;
}

static enum trace_answer pass_on(void *context, struct trace_hit *candidate)
{
    digest_add_hit(&fuzz_digest, candidate);
    return candidate->primitive % 2 ? TRACE_ACCEPT : TRACE_IGNORE;
}

static void trace_both(const void *structure, enum trace_accuracy accuracy,
                       const struct trace_ray *ray)
{
    struct trace_scene scene = {.structure = structure,
                                .accuracy = accuracy,
                                .resolver = {find_small, NULL},
                                .micromaps = {find_micromap, NULL}};
    struct trace_visitor visitor = {pass_on, NULL};
    struct trace_hit hit;
    trace_candidates(&scene, ray, &visitor);
    if (trace_closest(&scene, ray, &hit))
        digest_add_hit(&fuzz_digest, &hit);
}

static void trace_some(const void *structure, struct reader *reader)
{
    for (int i = 0; i < 6; i++) {
        struct trace_ray ray = {.direction = {1, 0.5f, 0.25f}, .t_max = INFINITY, .cull_mask = 255};
        if (i > 0)
            take(reader, &ray, sizeof(ray));
        if (i == 1)
            ray.flags = 0;
        trace_both(structure, (enum trace_accuracy)(i % 3), &ray);
    }
}

static void use(const void *structure, struct reader *reader)
{
    struct builder_statistics statistics;
    uint64_t size = builder_compacted_size(structure);
    void *copy = fixture_allocate(size);
    builder_measure(structure, &statistics);
    trace_some(structure, reader);
    if (builder_compact(structure, copy, size) != BUILDER_OK)
        abort();
    digest_add_words(&fuzz_digest, copy, size);
    digest_add(&fuzz_digest, &statistics.nodes, sizeof(statistics.nodes));
    struct trace_ray ray = {.direction = {1, 1, 1}, .t_max = INFINITY, .cull_mask = 255};
    trace_both(copy, TRACE_EXACT, &ray);
    free(copy);
}

static void ask_micromap(const void *micromap)
{
    uint16_t values[DISPLACEMENT_MAX_VERTICES];
    uint32_t format, level;
    for (uint32_t i = 0; i < 20; i++) {
        const uint32_t state = micromap_opacity(micromap, i, (float)i / 19, 0.5f - (float)i / 40);
        digest_add(&fuzz_digest, &state, sizeof(state));
        const uint8_t *blocks = micromap_displacement(micromap, i, &format, &level);
        if (blocks) {
            displacement_decode(format, level, blocks, values);
            digest_add(&fuzz_digest, values, displacement_vertex_count(level) * sizeof(values[0]));
        }
    }
}

/* What the bytes describe, and what they are. */
static void fuzz_micromap(const uint8_t *bytes, size_t size)
{
    struct micromap_input input = {.type = size % 2 ? VK_MICROMAP_TYPE_OPACITY_MICROMAP_EXT
                                                    : VK_MICROMAP_TYPE_DISPLACEMENT_MICROMAP_NV};
    VkMicromapUsageEXT usages[2];
    uint64_t needed;
    if (size < sizeof(usages))
        return;
    memcpy(usages, bytes, sizeof(usages));
    for (int i = 0; i < 2; i++) {
        usages[i].count %= 8;
        usages[i].format %= 4;
        usages[i].subdivisionLevel %= 8;
    }
    input.usage_count = 2;
    input.usages = usages;
    input.data = input.triangles = bytes + sizeof(usages);
    input.data_size = input.triangles_size = size - sizeof(usages);
    input.stride = 8 + size % 5;
    if (micromap_get_size(&input, &needed) != BUILDER_OK)
        return;
    void *micromap = fixture_allocate(needed);
    if (micromap_build(&input, micromap, needed) == BUILDER_OK)
        ask_micromap(micromap);
    free(micromap);
    micromap = fixture_allocate(size);
    if (micromap_deserialize(bytes, size, &uuids, micromap, size) == BUILDER_OK)
        ask_micromap(micromap);
    free(micromap);
}

static void fuzz_bytes(struct reader *reader)
{
    uint64_t room = reader->left + 64;
    void *structure = fixture_allocate(room), *bytes = fixture_allocate(reader->left);
    size_t size = reader->left;
    take(reader, bytes, size);
    fuzz_micromap(bytes, size);
    if (builder_deserialize(bytes, size, &uuids, structure, room) == BUILDER_OK)
        use(structure, reader);
    free(bytes);
    free(structure);
}

static void describe_triangles(struct reader *reader, struct builder_triangles *triangles)
{
    static const VkFormat formats[] = {
        VK_FORMAT_R32G32B32_SFLOAT,    VK_FORMAT_R32G32_SFLOAT,
        VK_FORMAT_R16G16B16A16_SFLOAT, VK_FORMAT_R16G16_SNORM,
        VK_FORMAT_R8G8B8A8_UNORM,      VK_FORMAT_A2B10G10R10_SNORM_PACK32,
        VK_FORMAT_R64G64B64_SFLOAT,    VK_FORMAT_R32G32B32A32_SFLOAT,
    };
    static const VkIndexType types[] = {VK_INDEX_TYPE_NONE_KHR, VK_INDEX_TYPE_UINT8_KHR,
                                        VK_INDEX_TYPE_UINT16, VK_INDEX_TYPE_UINT32};
    triangles->vertex_format = formats[take_number(reader, 8)];
    triangles->index_type = types[take_number(reader, 4)];
    take(reader, &triangles->max_vertex, sizeof(triangles->max_vertex));
    triangles->vertex_stride = take_number(reader, 64);
    if (take_number(reader, 8) == 0)
        take(reader, &triangles->vertex_stride, sizeof(triangles->vertex_stride));
}

static void point_into(struct builder_geometry *geometry, const uint8_t *data, size_t size,
                       size_t split, bool has_transform)
{
    switch (geometry->type) {
    case VK_GEOMETRY_TYPE_TRIANGLES_KHR: {
        struct builder_triangles *triangles = &geometry->triangles;
        triangles->indices = data;
        triangles->indices_size = split;
        triangles->vertices = data + split;
        triangles->vertices_size = size - split;
        triangles->transforms = has_transform ? data : NULL;
        triangles->transforms_size = size;
        triangles->motion_vertices = data;
        triangles->motion_vertices_size = size;
        break;
    }
    case VK_GEOMETRY_TYPE_AABBS_KHR:
        geometry->aabbs = (struct builder_aabbs){data, size, split};
        break;
    default:
        geometry->instances = (struct builder_instances){data, size, false};
        break;
    }
}

static void refit(const struct builder_input *input, void *structure)
{
    struct builder_sizes sizes;
    uint32_t count = input->ranges[0].primitiveCount;
    if (builder_get_sizes(input, &count, &sizes) != BUILDER_OK)
        abort();
    void *scratch = fixture_allocate(sizes.update_scratch);
    builder_refit(input, structure, structure, sizes.structure, scratch, sizes.update_scratch,
                  NULL);
    free(scratch);
}

/* Flags of a geometry that Vulkan does not have. */
#define HAS_MOTION 0x100u
#define HAS_POINTERS 0x200u
#define HAS_OPACITY 0x400u
#define HAS_SPHERES 0x800u      /* in place of AABBs */
#define HAS_SWEPT 0x1000u       /* those are swept */
#define HAS_DENSE 0x8000u       /* in place of triangles */
#define HAS_DISPLACEMENT 0x800u /* of triangles */

struct span {
    const uint8_t *bytes;
    size_t size;
};

/* Addresses are offsets. */
static const void *read_span(void *context, uint64_t address, uint64_t size)
{
    const struct span *span = context;
    return address <= span->size && size <= span->size - address ? span->bytes + address : NULL;
}

static struct builder_spheres describe_spheres(const uint8_t *data, size_t size, uint32_t split,
                                               uint32_t flags)
{
    static const VkIndexType types[] = {VK_INDEX_TYPE_NONE_KHR, VK_INDEX_TYPE_UINT16,
                                        VK_INDEX_TYPE_UINT32, VK_INDEX_TYPE_NONE_KHR};
    return (struct builder_spheres){
        .vertex_format = split % 3 ? VK_FORMAT_R32G32B32_SFLOAT : VK_FORMAT_R16G16B16A16_SFLOAT,
        .radius_format = split % 5 ? VK_FORMAT_R32_SFLOAT : VK_FORMAT_R16_SFLOAT,
        .index_type = types[split % 4],
        .vertices = data,
        .radii = data,
        .indices = data,
        .vertices_size = size,
        .radii_size = size,
        .indices_size = size,
        .vertex_stride = split % 17,
        .radius_stride = split % 19,
        .index_stride = split % 7,
        .indexing_mode = (VkRayTracingLssIndexingModeNV)(flags >> 13 & 1),
        .end_caps_mode = (VkRayTracingLssPrimitiveEndCapsModeNV)(flags >> 14 & 1),
    };
}

/* ---- displacements of any kind */

/* Micromap 1 alone is there, where there is enough data: a block of displacements, used at several
 * levels. */
static const void *find_displacing(void *context, uint64_t reference)
{
    static _Alignas(BUILDER_ALIGNMENT) uint8_t micromap[2048];
    static const VkMicromapUsageEXT usages[3] = {{1, 1, 1}, {1, 4, 1}, {1, 5, 3}};
    static const VkMicromapTriangleEXT triangles[3] = {{0, 1, 1}, {0, 4, 1}, {0, 5, 3}};
    const struct span *data = context;
    const struct micromap_input input =
        fixture_micromap_input(VK_MICROMAP_TYPE_DISPLACEMENT_MICROMAP_NV, 3, usages, data->bytes,
                               data->size, 3, triangles);
    return reference == 1 && micromap_build(&input, micromap, sizeof(micromap)) == BUILDER_OK
               ? micromap
               : NULL;
}

/* `flags` are random bits. */
static struct builder_displacement describe_displacement(const struct span *data,
                                                         VkIndexType index_type, uint32_t flags)
{
    static const VkMicromapUsageEXT usages[3] = {{2000, 1, 1}, {7, 4, 1}, {3, 5, 3}};
    static uint8_t indices[2000]; /* mostly good ones: level 1, now and then a special one */
    bool is_random = flags % 16 == 5;
    for (uint32_t i = 0; indices[4] == 0 && i < sizeof(indices); i++)
        indices[i] = i % 5 == 4 ? 0xff : i % 200 == 3 ? 1 : i % 400 == 6 ? 2 : 0;
    return (struct builder_displacement){
        .usage_count = 3,
        .usages = usages,
        .vector_format = VK_FORMAT_R16G16B16_SFLOAT,
        .bias_and_scale_format = VK_FORMAT_R16G16_SNORM,
        .index_type = is_random ? index_type : VK_INDEX_TYPE_UINT8_KHR,
        .base_triangle = is_random ? flags >> 13 & 1 : 0,
        .vectors = data->bytes,
        .biases_and_scales = flags & 0x200 ? data->bytes : NULL,
        .flags = data->bytes,
        .indices = is_random ? data->bytes : indices,
        .vectors_size = data->size,
        .biases_and_scales_size = data->size,
        .flags_size = data->size,
        .indices_size = is_random ? data->size : sizeof(indices),
        .vector_stride = flags >> 12,
        .bias_and_scale_stride = flags >> 14,
        .flags_stride = flags & 1,
        .index_stride = is_random ? flags >> 15 : 1,
        .micromap = flags % 8 == 3 ? flags >> 12 & 3 : 1,
    };
}

/* Mostly triangles that are within their data. */
static void make_likely(struct builder_triangles *triangles,
                        VkAccelerationStructureBuildRangeInfoKHR *range, uint32_t flags)
{
    if (flags % 16 == 5)
        return;
    triangles->vertex_format = VK_FORMAT_R16G16B16A16_SFLOAT;
    triangles->index_type = VK_INDEX_TYPE_NONE_KHR;
    triangles->max_vertex = UINT32_MAX;
    triangles->vertex_stride %= 9;
    range->primitiveCount %= 50;
}

/* ---- geometries */

static void fuzz_geometry(struct reader *reader)
{
    struct builder_geometry geometry = {.type = (VkGeometryTypeKHR)take_number(reader, 3)};
    VkAccelerationStructureBuildRangeInfoKHR range;
    struct builder_input input = {
        .type = geometry.type == VK_GEOMETRY_TYPE_INSTANCES_KHR
                    ? VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR
                    : VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR,
        .quality = (enum builder_quality)take_number(reader, 3),
        .geometry_count = 1,
        .geometries = &geometry,
        .ranges = &range,
        .resolver = {find_small, NULL},
    };
    take(reader, &range, sizeof(range));
    if (take_number(reader, 8) != 0) { /* mostly offsets that have a chance */
        range.primitiveOffset %= 64;
        range.firstVertex %= 16;
        range.transformOffset %= 64;
    }
    range.primitiveCount %= 2000;
    uint32_t flags = take_number(reader, 0x10000);
    geometry.flags = flags % 4;
    if (flags & HAS_MOTION)
        input.flags = VK_BUILD_ACCELERATION_STRUCTURE_MOTION_BIT_NV;
    if (geometry.type == VK_GEOMETRY_TYPE_AABBS_KHR && flags & HAS_SPHERES)
        geometry.type = flags & HAS_SWEPT ? VK_GEOMETRY_TYPE_LINEAR_SWEPT_SPHERES_NV
                                          : VK_GEOMETRY_TYPE_SPHERES_NV;
    bool is_sphere = geometry.type == VK_GEOMETRY_TYPE_SPHERES_NV ||
                     geometry.type == VK_GEOMETRY_TYPE_LINEAR_SWEPT_SPHERES_NV;
    bool has_transform = take_number(reader, 2);
    uint32_t split = take_number(reader, 4096);
    if (geometry.type == VK_GEOMETRY_TYPE_TRIANGLES_KHR)
        describe_triangles(reader, &geometry.triangles);
    size_t size = reader->left;
    uint8_t *data = fixture_allocate(size);
    take(reader, data, size);
    if (geometry.type != VK_GEOMETRY_TYPE_AABBS_KHR && split > size)
        split = (uint32_t)size;
    if (geometry.type == VK_GEOMETRY_TYPE_TRIANGLES_KHR && flags & HAS_DENSE) {
        geometry.type = VK_GEOMETRY_TYPE_DENSE_GEOMETRY_FORMAT_TRIANGLES_AMDX;
        geometry.dense = (struct builder_dense){data, size, 0x1fffffff, NULL};
        for (size_t i = 0; i < size; i += 128) /* mostly what blocks begin with */
            data[i] = i % 5 ? 6 : data[i];
    } else if (is_sphere) {
        geometry.spheres = describe_spheres(data, size, split, flags);
    } else {
        point_into(&geometry, data, size, split, has_transform);
    }
    struct builder_opacity opacity = {
        .index_type = geometry.triangles.index_type,
        .base_triangle = flags >> 12,
        .indices = data,
        .indices_size = size,
        .stride = flags >> 11,
        .micromap = 1,
    };
    if (geometry.type == VK_GEOMETRY_TYPE_TRIANGLES_KHR && flags & HAS_OPACITY)
        geometry.triangles.opacity = &opacity;
    struct span span = {data, size};
    struct builder_displacement displacement;
    if (geometry.type == VK_GEOMETRY_TYPE_TRIANGLES_KHR && flags & HAS_DISPLACEMENT) {
        displacement = describe_displacement(&span, geometry.triangles.index_type, flags);
        geometry.triangles.displacement = &displacement;
        make_likely(&geometry.triangles, &range, flags);
    }
    input.micromaps = (struct builder_resolver){find_displacing, &span};
    if (geometry.type == VK_GEOMETRY_TYPE_INSTANCES_KHR && flags & HAS_POINTERS) {
        geometry.instances.array_of_pointers = true;
        input.memory = (struct builder_memory){read_span, &span};
    }
    void *structure = fixture_build(&input, NULL);
    if (structure) {
        struct reader again = {data, size};
        use(structure, &again);
        refit(&input, structure);
        use(structure, &again);
    }
    free(structure);
    free(data);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    struct reader reader = {data, size};
    if (!small_blas) {
        static const float triangle[9] = {0, 0, 0, 1, 0, 0, 0, 1, 1};
        struct fixture_input input;
        fixture_input_triangles(&input, triangle, 1);
        small_blas = fixture_build(&input.input, NULL);
    }
    if (take_number(&reader, 2) == 0)
        fuzz_bytes(&reader);
    else
        fuzz_geometry(&reader);
    return 0;
}
