/* SPDX-License-Identifier: Apache-2.0 */
/* Cases 54 to 58: opacity micromaps (VK_EXT_opacity_micromap, VK_KHR_opacity_micromap). */
#include <math.h>
#include <string.h>

#include "cases.h"

/* The center of triangle i of 2 * count * count, every other one flipped; false: there is none. */
static bool find_center(int i, int count, float *u, float *v)
{
    const int column = i / 2 % count, row = i / 2 / count % count;
    const float offset = i % 2 ? 2.0f / 3 : 1.0f / 3;
    *u = ((float)column + offset) / (float)count;
    *v = ((float)row + offset) / (float)count;
    return column + row + i % 2 < count;
}

/* Level 2 of the specification's figure: column, row, whether flipped, place. */
static const uint8_t curve[16][4] = {
    {0, 0, 0, 0},  {0, 0, 1, 1}, {0, 1, 0, 3},  {0, 1, 1, 4},  {0, 2, 0, 14}, {0, 2, 1, 13},
    {0, 3, 0, 15}, {1, 0, 0, 2}, {1, 0, 1, 7},  {1, 1, 0, 5},  {1, 1, 1, 6},  {1, 2, 0, 12},
    {2, 0, 0, 8},  {2, 0, 1, 9}, {2, 1, 0, 11}, {3, 0, 0, 10},
};

CASE(54, 0, 0, "order of microtriangles", NULL)
{
    for (int i = 0; i < 16; i++) {
        float u, v;
        EXPECT(find_center(2 * (4 * curve[i][1] + curve[i][0]) + curve[i][2], 4, &u, &v) &&
               micromap_curve_index(u, v, 2) == curve[i][3]);
    }
    /* Each place once; what a place is cut into comes after one another. */
    for (uint32_t level = 0; level <= 5; level++) {
        uint8_t seen[1024] = {0};
        int count = 1 << level;
        for (int i = 0; i < 2 * count * count; i++) {
            float u, v;
            if (!find_center(i, count, &u, &v))
                continue;
            uint32_t place = micromap_curve_index(u, v, level);
            EXPECT(place < (uint32_t)(count * count) && seen[place]++ == 0);
            EXPECT(level == 0 || place >> 2 == micromap_curve_index(u, v, level - 1));
        }
    }
    /* Corners, the far edge, and what rounding leads outside. */
    const float odd[][2] = {{0, 0},        {1, 0},     {0, 1},           {0.5f, 0.5f},
                            {0.75f, 0.5f}, {1.5f, -1}, {-0.0f, 1.0001f}, {NAN, 2}};
    for (int i = 0; i < 8; i++)
        for (uint32_t level = 0; level <= MICROMAP_MAX_LEVEL; level++)
            EXPECT(micromap_curve_index(odd[i][0], odd[i][1], level) >> 2 * level == 0);
    EXPECT(micromap_curve_index(1, 0, 1) == 2 && micromap_curve_index(0, 1, 1) == 3);
    EXPECT(micromap_curve_index(0.25f, 0.25f, 1) == 1); /* on an edge: the upper one */
    EXPECT(micromap_curve_index(0.5f, 0.5f, 2) == 12);
}

/* `count` triangles of one format and level; the data of one after the other. */
static void *build_micromap(uint32_t format, uint32_t level, uint32_t count, const void *data,
                            uint64_t data_size)
{
    VkMicromapUsageEXT usage = {count, level, format};
    VkMicromapTriangleEXT *triangles = fixture_allocate(count * sizeof(*triangles));
    uint64_t bits = (uint64_t)format << 2 * level;
    for (uint32_t i = 0; i < count; i++)
        triangles[i] = (VkMicromapTriangleEXT){(uint32_t)((bits + 7) / 8) * i, (uint16_t)level,
                                               (uint16_t)format};
    const struct micromap_input input = fixture_micromap_input(
        VK_MICROMAP_TYPE_OPACITY_MICROMAP_EXT, 1, &usage, data, data_size, count, triangles);
    return fixture_micromap(&input);
}

static const float corners[18] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 2, 0, 0, 3, 0, 0, 2, 1, 0};

static void *build_with(const struct builder_opacity *opacity, VkGeometryFlagsKHR flags)
{
    INPUT(triangles, input, corners, 2);
    input.geometry.flags = flags;
    input.geometry.triangles.opacity = opacity;
    return case_build(&input);
}

/* 1: hit and opaque, 0: hit and not, -1: none. Into the triangle at (u, v). */
static int answer(const void *structure, float u, float v, uint32_t ray_flags)
{
    struct trace_ray ray = case_ray_down(u, v);
    struct trace_hit hit;
    ray.flags = ray_flags;
    return case_trace(structure, ray, &hit) ? hit.opaque : -1;
}

static int answer_in(const void *blas, VkGeometryInstanceFlagsKHR flags, float u, float v,
                     uint32_t ray_flags)
{
    VkAccelerationStructureInstanceKHR instance = fixture_instance(blas);
    instance.flags = flags & 0xff;
    return answer(case_instances(&instance, 1), u, v, ray_flags);
}

/* Each microtriangle has a state of its own. */
CASE(55, 0, 0, "state of every microtriangle", "opacity micromaps")
{
    enum { LEVEL = 3, COUNT = 8 };
    uint8_t data[32];
    uint64_t random = 97;
    for (int i = 0; i < 32; i++)
        data[i] = (uint8_t)fixture_random(&random);
    for (uint32_t format = 1; format <= 2; format++) {
        void *micromap = build_micromap(format, LEVEL, 2, data, sizeof(data));
        struct builder_opacity opacity = {.index_type = VK_INDEX_TYPE_NONE_KHR,
                                          .micromap = (uintptr_t)micromap};
        void *blas = build_with(&opacity, VK_GEOMETRY_OPAQUE_BIT_KHR);
        for (int i = 0; i < 2 * 2 * COUNT * COUNT; i++) {
            int which = i / (2 * COUNT * COUNT);
            float u, v;
            if (!find_center(i, COUNT, &u, &v))
                continue;
            uint32_t bit = format * micromap_curve_index(u, v, LEVEL);
            uint32_t byte = (uint32_t)which * (format == 1 ? 8 : 16) + bit / 8;
            int state = data[byte] >> bit % 8 & (format == 1 ? 1 : 3);
            int expected = state == 0 ? -1 : state == 1;
            float x = u + (float)(2 * which);
            EXPECT(answer(blas, x, v, 0) == expected);
            int two_states = state == 0 || state == 2 ? -1 : 1;
            EXPECT(answer(blas, x, v, TRACE_FORCE_2_STATE) == two_states);
            EXPECT(answer_in(blas, VK_GEOMETRY_INSTANCE_FORCE_OPACITY_MICROMAP_2_STATE_BIT_KHR, x,
                             v, 0) == two_states);
            EXPECT(answer_in(blas, VK_GEOMETRY_INSTANCE_DISABLE_OPACITY_MICROMAPS_BIT_KHR, x, v,
                             0) == 1);
        }
    }
}

/* What the instance and the ray say comes after what the micromap says; but ignored is ignored. */
CASE(56, 0, 0, "special indices, overridden", "opacity micromaps")
{
    const int special[4] = {-1, 1, 0, 0}; /* answers to indices -1 to -4 */
    for (int i = 0; i < 4; i++) {
        const int16_t indices[2] = {(int16_t)(-1 - i), 0};
        struct builder_opacity opacity = {.index_type = VK_INDEX_TYPE_UINT16,
                                          .base_triangle = 9, /* not for special indices */
                                          .indices = indices,
                                          .indices_size = sizeof(indices),
                                          .stride = sizeof(indices[0])};
        void *blas = build_with(&opacity, 0);
        const VkGeometryInstanceFlagsKHR force = VK_GEOMETRY_INSTANCE_FORCE_OPAQUE_BIT_KHR;
        const VkGeometryInstanceFlagsKHR forbid = VK_GEOMETRY_INSTANCE_FORCE_NO_OPAQUE_BIT_KHR;
        bool is_ignored = i == 0;
        EXPECT(answer(blas, 0.25f, 0.25f, 0) == special[i]);
        EXPECT(answer_in(blas, force, 0.25f, 0.25f, 0) == (is_ignored ? -1 : 1));
        EXPECT(answer_in(blas, forbid, 0.25f, 0.25f, 0) == (is_ignored ? -1 : 0));
        EXPECT(answer(blas, 0.25f, 0.25f, TRACE_OPAQUE) == (is_ignored ? -1 : 1));
        EXPECT(answer(blas, 0.25f, 0.25f, TRACE_CULL_NO_OPAQUE) == (special[i] == 1 ? 1 : -1));
        EXPECT(answer(blas, 0.25f, 0.25f, TRACE_CULL_OPAQUE) == (special[i] == 0 ? 0 : -1));
        EXPECT(answer(blas, 0.25f, 0.25f, TRACE_FORCE_2_STATE) == (i % 2 ? 1 : -1));
        EXPECT(answer(blas, 2.25f, 0.25f, 0) == 0); /* no micromap: the geometry's */
    }
}

/* Types, strides and bases of indices; triangles that no micromap knows. */
CASE(57, 0, 0, "indices into micromaps", "opacity micromaps")
{
    const uint8_t data[4] = {0, 1, 0, 1}; /* level 0, 2 states */
    void *micromap = build_micromap(VK_OPACITY_MICROMAP_FORMAT_2_STATE_EXT, 0, 4, data, 4);
    const struct {
        uint8_t bytes[16];
        VkIndexType type;
        uint32_t stride, base;
        int answers[2];
    } tables[] = {
        {{0}, VK_INDEX_TYPE_NONE_KHR, 0, 0, {-1, 1}},
        {{0}, VK_INDEX_TYPE_NONE_KHR, 0, 1, {1, -1}},
        {{3, 2}, VK_INDEX_TYPE_UINT8_KHR, 1, 0, {1, -1}},
        {{0xfe, 0xff}, VK_INDEX_TYPE_UINT8_KHR, 1, 0, {1, -1}},
        {{0, 9, 9, 9, 1, 0}, VK_INDEX_TYPE_UINT16, 4, 1, {0, -1}}, /* 0x900 + 1: no such triangle */
        {{1, 0, 9, 9, 0xff, 0xff}, VK_INDEX_TYPE_UINT16, 4, 0, {1, -1}},
        {{2, 0, 0, 0, 1, 0, 0, 0}, VK_INDEX_TYPE_UINT32, 4, 1, {1, -1}},
        {{0xfd, 0xff, 0xff, 0xff, 0xfb, 0xff, 0xff, 0xff}, VK_INDEX_TYPE_UINT32, 4, 0, {0, 0}},
        {{0xff, 0xff, 0xff, 0x7f, 4, 0, 0, 0}, VK_INDEX_TYPE_UINT32, 4, 0xffffffff, {0, 0}},
        {{3, 0, 0, 0, 7}, VK_INDEX_TYPE_UINT32, 0, 0, {1, 1}}, /* stride 0: all the same */
    };
    for (size_t i = 0; i < sizeof(tables) / sizeof(tables[0]); i++) {
        struct builder_opacity opacity = {
            .index_type = tables[i].type,
            .base_triangle = tables[i].base,
            .indices = tables[i].bytes,
            .indices_size = sizeof(tables[i].bytes),
            .stride = tables[i].stride,
            .micromap = (uintptr_t)micromap,
        };
        void *blas = build_with(&opacity, 0);
        for (int j = 0; j < 2; j++)
            EXPECT(answer(blas, 0.25f + (float)(2 * j), 0.25f, 0) == tables[i].answers[j]);
    }
    /* a reference that leads nowhere, and indices that can't be read */
    struct builder_opacity opacity = {.index_type = VK_INDEX_TYPE_NONE_KHR};
    void *blas = build_with(&opacity, VK_GEOMETRY_OPAQUE_BIT_KHR);
    EXPECT(answer(blas, 0.25f, 0.25f, 0) == 1);
    opacity = (struct builder_opacity){
        .index_type = VK_INDEX_TYPE_UINT32, .indices = data, .indices_size = 4, .stride = 4};
    INPUT(triangles, input, corners, 2);
    input.geometry.triangles.opacity = &opacity;
    EXPECT(case_fails(&input) && report.out_of_range == 1);
}

/* Sizes, wrong inputs, copies; and a structure's references in its copies. */
CASE(58, 0, 0, "micromaps and their copies", "opacity micromaps")
{
    const uint8_t data[16] = {0x1b};
    VkMicromapTriangleEXT triangles[2] = {{0, 1, 2}, {8, 2, 1}};
    VkMicromapUsageEXT usages[2] = {{1, 2, 1}, {1, 1, 2}};
    struct micromap_input input = fixture_micromap_input(VK_MICROMAP_TYPE_OPACITY_MICROMAP_EXT, 2,
                                                         usages, data, sizeof(data), 2, triangles);
    struct builder_uuids uuids = {{1}, {2}};
    uint64_t size, bytes_size;
    EXPECT(micromap_get_size(&input, &size) == BUILDER_OK);
    void *micromap = fixture_allocate(size), *again = fixture_allocate(size);
    EXPECT(micromap_build(&input, micromap, size - 1) == BUILDER_TOO_SMALL);
    EXPECT(micromap_build(&input, micromap, size) == BUILDER_OK);
    EXPECT(micromap_size(micromap) == size && micromap_compacted_size(micromap) <= size);
    EXPECT(micromap_opacity(micromap, 0, 0.1f, 0.1f) == MICROMAP_UNKNOWN_OPAQUE);
    EXPECT(micromap_opacity(micromap, 0, 0.9f, 0) == MICROMAP_OPAQUE);
    EXPECT(micromap_opacity(micromap, 2, 0, 0) == MICROMAP_NONE);
    bytes_size = micromap_serialized_size(micromap);
    uint8_t *bytes = fixture_allocate(bytes_size);
    EXPECT(micromap_serialize(micromap, &uuids, bytes, bytes_size) == BUILDER_OK);
    EXPECT(micromap_deserialize(bytes, bytes_size, &uuids, again, size) == BUILDER_OK);
    EXPECT(memcmp(micromap, again, size) == 0);
    for (uint64_t i = 0; i < bytes_size; i++) { /* whatever is damaged: no crash, or refused */
        bytes[i] ^= 0x80;
        if (micromap_deserialize(bytes, bytes_size, &uuids, again, size) == BUILDER_OK)
            micromap_opacity(again, 1, 0.3f, 0.3f);
        bytes[i] ^= 0x80;
    }
    const uint64_t data_at = bytes_size - size + 40; /* where the second triangle has its offset */
    for (uint64_t offset = size - 2; offset <= size; offset++) {
        memcpy(bytes + data_at, &offset, sizeof(offset));
        EXPECT((micromap_deserialize(bytes, bytes_size, &uuids, again, size) == BUILDER_OK) ==
               (offset == size - 2));
    }
    EXPECT(micromap_serialize(micromap, &uuids, bytes, bytes_size) == BUILDER_OK);
    triangles[1].dataOffset = 15; /* 2 bytes from there on */
    EXPECT(micromap_build(&input, micromap, size) == BUILDER_INPUT_OUT_OF_RANGE);
    triangles[1] = (VkMicromapTriangleEXT){0, 12, 2}; /* not as the usages say */
    EXPECT(micromap_build(&input, micromap, size) == BUILDER_INPUT_OUT_OF_RANGE);
    usages[0].format = 3;
    EXPECT(micromap_get_size(&input, &size) == BUILDER_UNKNOWN_FORMAT && size == 0);
    usages[0] = (VkMicromapUsageEXT){0xffffffff, 12, 2};
    EXPECT(micromap_get_size(&input, &size) == BUILDER_TOO_MANY_PRIMITIVES);

    const int16_t indices[2] = {1, -2};
    struct builder_opacity opacity = {.index_type = VK_INDEX_TYPE_UINT16,
                                      .indices = indices,
                                      .indices_size = sizeof(indices),
                                      .stride = 2,
                                      .micromap = (uintptr_t)again};
    micromap_deserialize(bytes, bytes_size, &uuids, again, micromap_size(micromap));
    void *blas = build_with(&opacity, VK_GEOMETRY_OPAQUE_BIT_KHR);
    void *compacted = case_compact(blas);
    EXPECT(answer(compacted, 0.25f, 0.25f, 0) == -1);
    EXPECT(answer(compacted, 2.25f, 0.25f, 0) == 1);
}
