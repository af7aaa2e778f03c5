/* SPDX-License-Identifier: Apache-2.0 */
/* The radii of spheres and linear swept spheres of host builds. */
#include <math.h>
#include <string.h>

#include "case.h"
#include "scene_extensions.h"

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

#define RADIUS(index, radius) WRITE_FLOAT(boxes, RADII + 4 * (index), radius)

static void make_all_radii_negative(struct scene *scene)
{
    for (uint32_t i = 0; i < 16; i++)
        set_radius(scene, i, -1.0f);
}

static void use_short_indices(struct scene *scene)
{
    static const uint16_t indices[4] = {1, 3, 6, 7};
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

#define SPHERES_RADII SPHERES_PATH "radiusData.hostAddress leads to "
#define SWEPT_RADII SWEPT_PATH "radiusData.hostAddress leads to "

static const struct test_case cases[] = {
    SHARED(RULE(spheres_radii_are_not_negative), .commands = ON_HOST, .setup = &with_content,
           .mutate = add_spheres_with_radii),
    CASE("spheres_radius_negative", EDITS(RADIUS(5, -0.5f)), .mutate_twin = add_spheres_with_radii,
         TWIN_EDITS(RADIUS(5, -0.0f)), .path = SPHERES_RADII "primitive 2, whose radius -0.5"),
    CASE("spheres_radius_negative_of_no_primitive", .silent = true, EDITS(RADIUS(6, -1.0f))),
    CASE("spheres_radius_infinitely_negative", EDITS(RADIUS(7, -INFINITY)),
         .mutate_twin = add_spheres_with_radii, TWIN_EDITS(RADIUS(5, -NAN)),
         .path = SPHERES_RADII "primitive 3, whose radius -inf"),
    /* It is inactive. */
    CASE("spheres_radius_negative_without_center", .silent = true,
         EDITS(RADIUS(5, -0.5f), WRITE_FLOAT(vertices, 5 * 12 + 4, NAN))),

    SHARED(RULE(spheres_radii_are_not_negative), .commands = ON_HOST, .setup = &with_content,
           .mutate = add_spheres_with_radii, .mutate_twin = add_spheres_with_radii),
    CASE("spheres_radius_negative_by_first_vertex",
         EDITS(RADIUS(8, -1.0f), SET(ranges[SPHERES][0].firstVertex, 1)),
         TWIN_EDITS(RADIUS(8, -1.0f), SET(ranges[SPHERES][0].firstVertex, 2)),
         .path = SPHERES_RADII "primitive 3"),
    CASE("spheres_radius_negative_at_index_stride",
         EDITS(RADIUS(1, -1e-30f), SET(spheres.indexStride, 0)),
         TWIN_EDITS(RADIUS(5, -0.5f), SET(spheres.indexStride, 0)),
         .path = SPHERES_RADII "primitive 0, whose radius -1e-30"),
    CASE("spheres_radius_negative_by_short_index",
         EDITS(RADIUS(6, -1.0f), CALL(use_short_indices),
               SET(spheres.indexType, VK_INDEX_TYPE_UINT16), SET(spheres.indexStride, 2)),
         TWIN_EDITS(RADIUS(6, -1.0f), CALL(use_short_indices),
                    SET(spheres.indexType, VK_INDEX_TYPE_UINT16), SET(spheres.indexStride, 2),
                    SET(ranges[SPHERES][0].primitiveCount, 2)),
         .path = SPHERES_RADII "primitive 2"),
    CASE("spheres_radius_negative_by_offset_of_indices",
         EDITS(RADIUS(0, -1.0f), SET(ranges[SPHERES][0].primitiveOffset, 4)),
         TWIN_EDITS(RADIUS(0, -1.0f)), .path = SPHERES_RADII "primitive 3"),
    /* The offset is applied to vertices and radii. */
    CASE("spheres_radius_negative_by_offset",
         EDITS(RADIUS(6, -1.0f), SET(spheres.indexType, VK_INDEX_TYPE_NONE_KHR),
               SET(spheres.indexData.deviceAddress, 0),
               SET(ranges[SPHERES][0].primitiveOffset, 12)),
         TWIN_EDITS(RADIUS(6, -1.0f), SET(spheres.indexType, VK_INDEX_TYPE_NONE_KHR),
                    SET(spheres.indexData.deviceAddress, 0)),
         .path = SPHERES_RADII "primitive 3"),
    CASE("spheres_radii_of_stride_0", EDITS(RADIUS(0, -1.0f), SET(spheres.radiusStride, 0)),
         TWIN_EDITS(RADIUS(5, -0.5f), SET(spheres.radiusStride, 0)),
         .path = SPHERES_RADII "primitive 0"),

    SHARED(RULE(spheres_radii_are_not_negative), .commands = ON_HOST, .setup = &with_content),
    CASE("spheres_half_radius_negative", EITHER_CALL(half_radius, 0x8001, 0x8000),
         .path = SPHERES_RADII "primitive 1"),
    CASE("spheres_half_radius_nan", .silent = true, EDITS(CALL_WITH(half_radius, 0xfe00))),
    CASE("spheres_radii_negative_are_told_once", .mutate = add_spheres_with_radii,
         EDITS(CALL(make_all_radii_negative)), .mutate_twin = add_spheres_with_radii,
         TWIN_EDITS(CALL(make_all_radii_negative), SET(ranges[SPHERES][0].primitiveCount, 0)),
         .count = 1, .path = SPHERES_RADII "primitive 0"),
    CASE("spheres_radii_unreadable", RULE(spheres_radius_data_is_valid),
         .mutate = add_spheres_with_radii,
         EDITS(CALL(make_all_radii_negative), SET(spheres.radiusData.deviceAddress, 0x10)),
         .mutate_twin = add_spheres_with_radii, .is_for_the_call = true),
    CASE("spheres_radii_negative_in_device_memory", .silent = true, .commands = ON_COMMAND_BUFFERS,
         .mutate = add_spheres_with_radii, EDITS(CALL(make_all_radii_negative)),
         .is_for_the_call = true),
    CASE("spheres_radii_negative_below_level_content", .silent = true, .setup = &with_spheres,
         .mutate = add_spheres_with_radii, EDITS(CALL(make_all_radii_negative))),

    SHARED(RULE(swept_spheres_radii_are_not_negative), .commands = ON_HOST, .setup = &with_content,
           .mutate = add_swept_spheres_with_radii),
    CASE("swept_spheres_first_radius_negative", EDITS(RADIUS(5, -0.5f)),
         .mutate_twin = add_swept_spheres_with_radii, TWIN_EDITS(RADIUS(6, -1.0f)),
         .path = SWEPT_RADII "primitive 1, whose radius -0.5"),
    CASE("swept_spheres_last_radius_negative", EDITS(RADIUS(7, -INFINITY)),
         .mutate_twin = add_swept_spheres_with_radii, TWIN_EDITS(RADIUS(8, -1.0f)),
         .path = SWEPT_RADII "primitive 1, whose radius -inf"),
    CASE("swept_spheres_radius_nan", .silent = true, EDITS(RADIUS(5, -NAN))),
    /* It is inactive. */
    CASE("swept_spheres_radius_beside_nan", .silent = true,
         EDITS(RADIUS(7, -INFINITY), RADIUS(5, NAN))),
    /* From each index to the one behind it. */
    CASE("swept_spheres_radius_negative_of_successor",
         EDITS(RADIUS(6, -1.0f),
               SET(swept_spheres.indexingMode, VK_RAY_TRACING_LSS_INDEXING_MODE_SUCCESSIVE_NV),
               SET(ranges[SPHERES][0].primitiveCount, 3)),
         .mutate_twin = add_swept_spheres_with_radii,
         TWIN_EDITS(RADIUS(7, -INFINITY),
                    SET(swept_spheres.indexingMode, VK_RAY_TRACING_LSS_INDEXING_MODE_SUCCESSIVE_NV),
                    SET(ranges[SPHERES][0].primitiveCount, 3)),
         .path = SWEPT_RADII "primitive 2"),
    CASE("swept_spheres_radius_negative_without_indices",
         EDITS(RADIUS(5, -0.5f), SET(swept_spheres.indexType, VK_INDEX_TYPE_NONE_KHR),
               SET(swept_spheres.indexData.deviceAddress, 0),
               SET(ranges[SPHERES][0].primitiveCount, 3)),
         .mutate_twin = add_swept_spheres_with_radii,
         TWIN_EDITS(RADIUS(5, -0.5f), SET(swept_spheres.indexType, VK_INDEX_TYPE_NONE_KHR),
                    SET(swept_spheres.indexData.deviceAddress, 0)),
         .path = SWEPT_RADII "primitive 2"),
    CASE("swept_spheres_radii_negative_are_told_once", EDITS(CALL(make_all_radii_negative)),
         .mutate_twin = add_swept_spheres_with_radii,
         TWIN_EDITS(CALL(make_all_radii_negative), SET(ranges[SPHERES][0].primitiveCount, 0)),
         .count = 1, .path = SWEPT_RADII "primitive 0"),
};

CASE_LIST(cases_radii, cases);
