/* SPDX-License-Identifier: Apache-2.0 */
/* The radii of spheres and linear swept spheres of host builds. */
#include <math.h>
#include <string.h>

#include "case.h"
#include "scene_spheres.h"

static const struct setup with_spheres = {.enable = ENABLE_SPHERES};
static const struct setup with_content = {.enable = ENABLE_SPHERES, .level = "content"};

/* Behind the boxes, and among the indices. */
enum { RADII = SCENE_BUFFER_SIZE / 2, RADIUS_INDICES = SCENE_BUFFER_SIZE / 4 };

static void set_radius(struct scene *scene, uint32_t index, float radius)
{
    memcpy(scene->boxes.host + RADII + index * sizeof(radius), &radius, sizeof(radius));
}

static void set_radii(struct scene *scene)
{
    static const uint32_t indices[4] = {1, 3, 5, 7};
    memcpy(scene->indices.host + RADIUS_INDICES, indices, sizeof(indices));
    for (uint32_t i = 0; i < 16; i++)
        set_radius(scene, i, (float)i);
}

/* Spheres 0 to 3 have vertices and radii 1, 3, 5, 7. */
static void add_spheres_with_radii(struct scene *scene)
{
    scene_add_spheres(scene);
    set_radii(scene);
    scene->spheres.indexData.deviceAddress = scene_address(scene, &scene->indices, RADIUS_INDICES);
    scene->spheres.radiusData.deviceAddress = scene_address(scene, &scene->boxes, RADII);
}

#define RADIUS(name, index, radius) RADIUS_OF(add_spheres_with_radii, name, index, radius)
#define SWEPT_RADIUS(name, index, radius)                                                          \
    RADIUS_OF(add_swept_spheres_with_radii, name, index, radius)
#define RADIUS_OF(add, name, index, radius)                                                        \
    static void name(struct scene *scene)                                                          \
    {                                                                                              \
        add(scene);                                                                                \
        set_radius(scene, index, radius);                                                          \
    }

RADIUS(radius_0_negative, 0, -1.0f)
RADIUS(radius_1_negative, 1, -1e-30f)
RADIUS(radius_5_negative, 5, -0.5f)
RADIUS(radius_5_minus_zero, 5, -0.0f)
RADIUS(radius_5_nan, 5, -NAN)
RADIUS(radius_6_negative, 6, -1.0f)
RADIUS(radius_7_infinite, 7, -INFINITY)
RADIUS(radius_8_negative, 8, -1.0f)

static void all_radii_negative(struct scene *scene)
{
    add_spheres_with_radii(scene);
    for (uint32_t i = 0; i < 16; i++)
        set_radius(scene, i, -1.0f);
}

/* It is inactive. */
static void radius_5_of_no_center(struct scene *scene)
{
    const float nan = NAN;
    radius_5_negative(scene);
    memcpy(scene->vertices.host + 5 * 12 + 4, &nan, sizeof(nan));
}

static void short_indices_to_radii(struct scene *scene)
{
    static const uint16_t indices[4] = {1, 3, 6, 7};
    radius_6_negative(scene);
    memcpy(scene->indices.host + RADIUS_INDICES, indices, sizeof(indices));
}

static void half_radius(struct scene *scene, uint32_t value)
{
    const uint16_t bits = (uint16_t)value;
    add_spheres_with_radii(scene);
    memcpy(scene->boxes.host + RADII + 3 * sizeof(bits), &bits, sizeof(bits));
    scene->spheres.radiusFormat = VK_FORMAT_R16_SFLOAT;
    scene->spheres.radiusStride = sizeof(bits);
}

/* Swept spheres 0 and 1 go from 1 to 3 and from 5 to 7. */
static void add_swept_spheres_with_radii(struct scene *scene)
{
    scene_add_swept_spheres(scene);
    set_radii(scene);
    scene->swept_spheres.radiusFormat = VK_FORMAT_R32_SFLOAT;
    scene->swept_spheres.radiusData.deviceAddress = scene_address(scene, &scene->boxes, RADII);
    scene->swept_spheres.indexType = VK_INDEX_TYPE_UINT32;
    scene->swept_spheres.indexStride = sizeof(uint32_t);
    scene->swept_spheres.indexData.deviceAddress =
        scene_address(scene, &scene->indices, RADIUS_INDICES);
    scene->ranges[SPHERES][0].primitiveCount = 2;
}

SWEPT_RADIUS(swept_radius_5_negative, 5, -0.5f)
SWEPT_RADIUS(swept_radius_5_nan, 5, -NAN)
SWEPT_RADIUS(swept_radius_6_negative, 6, -1.0f)
SWEPT_RADIUS(swept_radius_7_infinite, 7, -INFINITY)
SWEPT_RADIUS(swept_radius_8_negative, 8, -1.0f)

static void swept_radii_all_negative(struct scene *scene)
{
    add_swept_spheres_with_radii(scene);
    for (uint32_t i = 0; i < 16; i++)
        set_radius(scene, i, -1.0f);
}

/* It is inactive. */
static void swept_radius_beside_nan(struct scene *scene)
{
    swept_radius_7_infinite(scene);
    set_radius(scene, 5, NAN);
}

#define SPHERES_RADII SPHERES_PATH "radiusData.hostAddress leads to "
#define SWEPT_RADII SWEPT_PATH "radiusData.hostAddress leads to "

static const struct test_case cases[] = {
    SHARED(RULE(spheres_radii_are_not_negative), .commands = ON_HOST, .setup = &with_content),
    CASE("spheres_radius_negative", .mutate = radius_5_negative, .mutate_twin = radius_5_minus_zero,
         .path = SPHERES_RADII "primitive 2, which has radius -0.5"),
    CASE("spheres_radius_negative_of_no_primitive", .silent = true, .mutate = radius_6_negative),
    CASE("spheres_radius_infinitely_negative", .mutate = radius_7_infinite,
         .mutate_twin = radius_5_nan, .path = SPHERES_RADII "primitive 3, which has radius -inf"),
    CASE("spheres_radius_negative_without_center", .silent = true, .mutate = radius_5_of_no_center),
    CASE("spheres_radius_negative_by_first_vertex", .mutate = radius_8_negative,
         EITHER_SET(ranges[SPHERES][0].firstVertex, 1, 2), .mutate_twin = radius_8_negative,
         .path = SPHERES_RADII "primitive 3"),
    CASE("spheres_radius_negative_at_index_stride", .mutate = radius_1_negative,
         EITHER_SET(spheres.indexStride, 0, 0), .mutate_twin = radius_5_negative,
         .path = SPHERES_RADII "primitive 0, which has radius -1e-30"),
    CASE("spheres_radius_negative_by_short_index", .mutate = short_indices_to_radii,
         EDITS(SET(spheres.indexType, VK_INDEX_TYPE_UINT16), SET(spheres.indexStride, 2)),
         .mutate_twin = short_indices_to_radii,
         TWIN_EDITS(SET(spheres.indexType, VK_INDEX_TYPE_UINT16), SET(spheres.indexStride, 2),
                    SET(ranges[SPHERES][0].primitiveCount, 2)),
         .path = SPHERES_RADII "primitive 2"),
    CASE("spheres_radius_negative_by_offset_of_indices", .mutate = radius_0_negative,
         EDITS(SET(ranges[SPHERES][0].primitiveOffset, 4)), .mutate_twin = radius_0_negative,
         .path = SPHERES_RADII "primitive 3"),
    /* The offset is applied to vertices and radii. */
    CASE("spheres_radius_negative_by_offset", .mutate = radius_6_negative,
         EDITS(SET(spheres.indexType, VK_INDEX_TYPE_NONE_KHR),
               SET(spheres.indexData.deviceAddress, 0),
               SET(ranges[SPHERES][0].primitiveOffset, 12)),
         .mutate_twin = radius_6_negative,
         TWIN_EDITS(SET(spheres.indexType, VK_INDEX_TYPE_NONE_KHR),
                    SET(spheres.indexData.deviceAddress, 0)),
         .path = SPHERES_RADII "primitive 3"),
    CASE("spheres_radii_of_stride_0", .mutate = radius_0_negative,
         EITHER_SET(spheres.radiusStride, 0, 0), .mutate_twin = radius_5_negative,
         .path = SPHERES_RADII "primitive 0"),
    CASE("spheres_half_radius_negative", EITHER_CALL(half_radius, 0x8001, 0x8000),
         .path = SPHERES_RADII "primitive 1"),
    CASE("spheres_half_radius_nan", .silent = true, EDITS(CALL_WITH(half_radius, 0xfe00))),
    CASE("spheres_radii_negative_are_told_once", .mutate = all_radii_negative,
         .mutate_twin = all_radii_negative, TWIN_EDITS(SET(ranges[SPHERES][0].primitiveCount, 0)),
         .count = 1, .path = SPHERES_RADII "primitive 0"),
    CASE("spheres_radii_unreadable", RULE(spheres_radius_data_is_valid),
         .mutate = all_radii_negative, EDITS(SET(spheres.radiusData.deviceAddress, 0x10)),
         .mutate_twin = add_spheres_with_radii, .is_for_the_call = true),
    CASE("spheres_radii_negative_in_device_memory", .silent = true, .commands = ON_COMMAND_BUFFERS,
         .mutate = all_radii_negative, .is_for_the_call = true),
    CASE("spheres_radii_negative_below_level_content", .silent = true, .setup = &with_spheres,
         .mutate = all_radii_negative),

    SHARED(RULE(swept_spheres_radii_are_not_negative), .commands = ON_HOST, .setup = &with_content),
    CASE("swept_spheres_first_radius_negative", .mutate = swept_radius_5_negative,
         .mutate_twin = swept_radius_6_negative,
         .path = SWEPT_RADII "primitive 1, which has radius -0.5"),
    CASE("swept_spheres_last_radius_negative", .mutate = swept_radius_7_infinite,
         .mutate_twin = swept_radius_8_negative,
         .path = SWEPT_RADII "primitive 1, which has radius -inf"),
    CASE("swept_spheres_radius_nan", .silent = true, .mutate = swept_radius_5_nan),
    CASE("swept_spheres_radius_beside_nan", .silent = true, .mutate = swept_radius_beside_nan),
    /* From each index to the one behind it. */
    CASE("swept_spheres_radius_negative_of_successor", .mutate = swept_radius_6_negative,
         EDITS(SET(swept_spheres.indexingMode, VK_RAY_TRACING_LSS_INDEXING_MODE_SUCCESSIVE_NV),
               SET(ranges[SPHERES][0].primitiveCount, 3)),
         .mutate_twin = swept_radius_7_infinite,
         TWIN_EDITS(SET(swept_spheres.indexingMode, VK_RAY_TRACING_LSS_INDEXING_MODE_SUCCESSIVE_NV),
                    SET(ranges[SPHERES][0].primitiveCount, 3)),
         .path = SWEPT_RADII "primitive 2"),
    CASE("swept_spheres_radius_negative_without_indices", .mutate = swept_radius_5_negative,
         EDITS(SET(swept_spheres.indexType, VK_INDEX_TYPE_NONE_KHR),
               SET(swept_spheres.indexData.deviceAddress, 0),
               SET(ranges[SPHERES][0].primitiveCount, 3)),
         .mutate_twin = swept_radius_5_negative,
         TWIN_EDITS(SET(swept_spheres.indexType, VK_INDEX_TYPE_NONE_KHR),
                    SET(swept_spheres.indexData.deviceAddress, 0)),
         .path = SWEPT_RADII "primitive 2"),
    CASE("swept_spheres_radii_negative_are_told_once", .mutate = swept_radii_all_negative,
         .mutate_twin = swept_radii_all_negative,
         TWIN_EDITS(SET(ranges[SPHERES][0].primitiveCount, 0)), .count = 1,
         .path = SWEPT_RADII "primitive 0"),
};

CASE_LIST(cases_radii, cases);
