/* SPDX-License-Identifier: Apache-2.0 */
/* The data of triangles and boxes of host builds, and their transforms. */
#include <math.h>
#include <string.h>

#include "case.h"

static const struct setup with_content = {.level = "content"};
static const struct setup with_small_indices = {.enable = ENABLE_UINT8_KHR, .level = "content"};

/* ---- boxes: of AABBS, 0 at stride 24, 1 at stride 32 from 1024 on ---- */

static float *box_at(struct scene *scene, size_t offset)
{
    return (float *)(void *)(scene->boxes.host + offset);
}

enum { MIN_X, MIN_Y, MIN_Z, MAX_X, MAX_Y, MAX_Z };

/* Without minX nothing else counts. */
static void inactive_box_upside_down(struct scene *scene)
{
    box_at(scene, 0)[MIN_X] = NAN;
    box_at(scene, 0)[MIN_Y] = 7.0f;
    box_at(scene, 0)[MAX_Z] = NAN;
}

static void infinite_boxes(struct scene *scene)
{
    box_at(scene, 0)[MIN_X] = -INFINITY;
    box_at(scene, 0)[MAX_X] = INFINITY;
    box_at(scene, 24)[MIN_Y] = box_at(scene, 24)[MAX_Y] = INFINITY;
    box_at(scene, 48)[MIN_Z] = 0.0f;
    box_at(scene, 48)[MAX_Z] = -0.0f;
}

static void two_boxes_upside_down(struct scene *scene)
{
    box_at(scene, 24)[MIN_X] = box_at(scene, 48)[MIN_X] = 2.0f;
}

/* ---- indices: of UNINDEXED, 1, from 2048 on ---- */

enum { SHORTS = SCENE_BUFFER_SIZE / 2 };

static uint16_t *short_indices(struct scene *scene)
{
    return (uint16_t *)(void *)(scene->indices.host + SHORTS);
}

static void wide_indices(struct scene *scene, uint32_t last)
{
    const uint32_t indices[6] = {0, 1, 2, 3, 2, last};
    memcpy(short_indices(scene), indices, sizeof(indices));
    scene->TRIANGLES(UNINDEXED, 1).indexType = VK_INDEX_TYPE_UINT32;
}

static void byte_index_beyond(struct scene *scene)
{
    const uint8_t indices[6] = {0, 1, 2, 3, 2, 255};
    memcpy(short_indices(scene), indices, sizeof(indices));
    scene->TRIANGLES(UNINDEXED, 1).indexType = VK_INDEX_TYPE_UINT8_KHR;
}

/* A few vertices far apart are no more than there are. */
static void few_vertices_far_apart(struct scene *scene)
{
    const uint16_t indices[6] = {0, 1, 900, 1, 0, 900};
    memcpy(short_indices(scene), indices, sizeof(indices));
}

/* ---- transforms: INDEXED's own, at an offset ---- */

static void use_transform(struct scene *scene, const float matrix[3][4])
{
    scene->ranges[INDEXED][0].transformOffset = SCENE_TRANSFORM_OFFSET;
    memcpy(scene->transforms.host + SCENE_TRANSFORM_OFFSET, matrix, 12 * sizeof(float));
}

#define TRANSFORM(name, ...)                                                                       \
    static void name(struct scene *scene)                                                          \
    {                                                                                              \
        static const float matrix[3][4] = {__VA_ARGS__};                                           \
        use_transform(scene, matrix);                                                              \
    }

TRANSFORM(zero_transform, {0})
TRANSFORM(tiny_transform, {1e-20f}, {0, 1e-20f}, {0, 0, 1e-20f})
TRANSFORM(small_transform, {1e-12f, 0, 0, 5}, {0, 1e-12f}, {0, 0, 1e-12f})
TRANSFORM(huge_transform, {1e15f}, {0, -1e15f}, {0, 0, 1e15f})
TRANSFORM(flat_transform, {1, 2, 3}, {4, 5, 6}, {7, 8, 9})
/* The last number is one float more than 9. */
TRANSFORM(almost_flat_transform, {1, 2, 3}, {4, 5, 6}, {7, 8, 9.00000095f})
TRANSFORM(undefined_transform, {NAN}, {0, 1}, {0, 0, 1})
TRANSFORM(infinite_transform, {1}, {0, INFINITY}, {0, 0, 1})
/* The fourth column moves, and is no part of it. */
TRANSFORM(infinite_move, {1, 0, 0, INFINITY}, {0, 1, 0, 0}, {0, 0, 1, 0})

/* At the offset that isn't read. */
static void zero_transform_elsewhere(struct scene *scene)
{
    memset(scene->transforms.host + SCENE_TRANSFORM_OFFSET, 0, 12 * sizeof(float));
}

#define BOXES_LEAD_TO(index)                                                                       \
    "pInfos[2].pGeometries[" #index "].geometry.aabbs.data.hostAddress leads to primitive "
#define TRANSFORM_LEADS                                                                            \
    "pInfos[0].pGeometries[0].geometry.triangles.transformData.hostAddress leads to a matrix"

static const struct test_case cases[] = {
    SHARED(RULE(aabb_min_x_is_at_most_max_x), .commands = ON_HOST, .setup = &with_content),
    CASE("box_min_x_beyond_max_x", EDITS(WRITE_FLOAT(boxes, 48 + 4 * MIN_X, 1.5f)),
         TWIN_EDITS(WRITE_FLOAT(boxes, 48 + 4 * MIN_X, 1.0f)),
         .path = BOXES_LEAD_TO(0) "2, whose minX 1.5 is not less than or equal to maxX (1)"),
    CASE("box_min_y_beyond_max_y", RULE(aabb_min_y_is_at_most_max_y),
         EDITS(WRITE_FLOAT(boxes, 24 + 4 * MIN_Y, 2.0f)), .mutate_twin = infinite_boxes,
         .path = BOXES_LEAD_TO(0) "1, whose minY 2 "),
    CASE("box_min_z_beyond_max_z_at_a_stride", RULE(aabb_min_z_is_at_most_max_z),
         EDITS(WRITE_FLOAT(boxes, 1024 + 32 + 4 * MAX_Z, -0.5f)),
         TWIN_EDITS(WRITE_FLOAT(boxes, 1024 + 24 + 4 * MIN_X, 9.0f)),
         .path = BOXES_LEAD_TO(1) "1, whose minZ 0 is not less than or equal to maxZ (-0.5)"),
    CASE("box_max_x_nan", EDITS(WRITE_FLOAT(boxes, 0 + 4 * MAX_X, NAN)),
         .mutate_twin = inactive_box_upside_down, .path = BOXES_LEAD_TO(0) "0"),
    CASE("box_min_y_nan", RULE(aabb_min_y_is_at_most_max_y),
         EDITS(WRITE_FLOAT(boxes, 0 + 4 * MIN_Y, NAN)), .mutate_twin = inactive_box_upside_down),
    CASE("box_max_z_nan", RULE(aabb_min_z_is_at_most_max_z),
         EDITS(WRITE_FLOAT(boxes, 0 + 4 * MAX_Z, NAN)), .mutate_twin = inactive_box_upside_down),
    CASE("box_upside_down_behind_the_last",
         EDITS(WRITE_FLOAT(boxes, 72 + 4 * MIN_X, 9.0f), SET(ranges[AABBS][0].primitiveOffset, 24)),
         TWIN_EDITS(WRITE_FLOAT(boxes, 72 + 4 * MIN_X, 9.0f)), .path = BOXES_LEAD_TO(0) "2"),
    CASE("boxes_upside_down_but_none_built", .silent = true, .mutate = two_boxes_upside_down,
         EDITS(SET(ranges[AABBS][0].primitiveCount, 0))),
    CASE("two_boxes_upside_down_are_told_once", .mutate = two_boxes_upside_down, .count = 1,
         .path = BOXES_LEAD_TO(0) "1"),
    CASE("boxes_of_two_geometries_upside_down", .mutate = two_boxes_upside_down,
         EDITS(WRITE_FLOAT(boxes, 1024 + 4 * MIN_X, 2.0f)), .count = 2,
         .path = BOXES_LEAD_TO(1) "0"),

    SHARED(RULE(aabb_min_x_is_at_most_max_x), .silent = true, .mutate = two_boxes_upside_down,
           .may_fail_on_cpu = true),
    CASE("boxes_upside_down_in_device_memory", .commands = ON_COMMAND_BUFFERS,
         .setup = &with_content, .is_for_the_call = true),
    CASE("boxes_upside_down_below_level_content", .commands = ON_HOST),

    SHARED(RULE(indices_are_within_max_vertex), .commands = ON_HOST, .setup = &with_content),
    CASE("short_index_beyond_max_vertex", EDITS(WRITE(indices, uint16_t, SHORTS + 8, 6)),
         TWIN_EDITS(WRITE(indices, uint16_t, SHORTS + 8, 5)),
         .path = "ppBuildRangeInfos[1][1].firstVertex 0 plus index 6 of primitive 1 is vertex 6"),
    CASE("short_index_beyond_max_vertex_by_first_vertex",
         EITHER_SET(ranges[UNINDEXED][1].firstVertex, 3, 2),
         .path = "ppBuildRangeInfos[1][1].firstVertex 3 plus index 3 of primitive 1 is vertex 6"),
    CASE("first_vertex_beyond_max_vertex", EDITS(SET(ranges[UNINDEXED][1].firstVertex, UINT32_MAX)),
         .is_wild = true,
         .path = "ppBuildRangeInfos[1][1].firstVertex 4294967295 plus index 0 of primitive 0"),
    CASE("short_index_beyond_max_vertex_by_offset",
         EDITS(WRITE(indices, uint16_t, SHORTS + 12, 600),
               SET(ranges[UNINDEXED][1].primitiveOffset, 2)),
         TWIN_EDITS(WRITE(indices, uint16_t, SHORTS + 12, 600)), .is_wild = true,
         .path = "index 600 of primitive 1"),
    CASE("largest_short_index_restarts_nothing",
         EDITS(WRITE(indices, uint16_t, SHORTS + 0, 0xffff)), .is_wild = true,
         .path = "index 65535 of primitive 0"),
    CASE("largest_short_index_but_none_built", .silent = true,
         EDITS(WRITE(indices, uint16_t, SHORTS + 0, 0xffff),
               SET(ranges[UNINDEXED][1].primitiveCount, 0))),
    CASE("wide_index_beyond_max_vertex", EITHER_CALL(wide_indices, UINT32_MAX, 5), .is_wild = true,
         .path = "index 4294967295 of primitive 1"),
    CASE("byte_index_beyond_max_vertex",
         RULES(RULE_indices_are_within_max_vertex, RULE_index_type_is_16_or_32_bits_or_none),
         .setup = &with_small_indices, .mutate = byte_index_beyond, .is_for_the_call = true),
    CASE("more_vertices_indexed_than_there_are", RULES(RULE_indices_are_within_max_vertex),
         NAMES(RULE_consumed_vertices_are_within_max_vertex),
         EITHER_SET(TRIANGLES(UNINDEXED, 1).maxVertex, 2, 3), .path = "ppBuildRangeInfos[1][1]."),
    CASE("few_vertices_far_apart", .mutate = few_vertices_far_apart,
         EDITS(SET(TRIANGLES(UNINDEXED, 1).maxVertex, 2)), .is_wild = true),
    CASE("more_vertices_consumed_than_there_are",
         RULES(RULE_unindexed_vertices_are_within_max_vertex),
         NAMES(RULE_consumed_vertices_are_within_max_vertex),
         EDITS(SET(TRIANGLES(UNINDEXED, 0).maxVertex, 4)), .is_for_the_call = true,
         .path = "ppBuildRangeInfos[1][0].primitiveCount 2"),

    SHARED(RULE(transform_matrix_is_invertible), .commands = ON_HOST, .setup = &with_content),
    CASE("as_many_vertices_consumed_as_there_are", RULE(unindexed_vertices_are_within_max_vertex),
         EDITS(SET(ranges[UNINDEXED][0].firstVertex, 1)), .is_for_the_call = true),
    CASE("transform_of_zeros", .mutate = zero_transform, .mutate_twin = zero_transform_elsewhere,
         .path =
             TRANSFORM_LEADS " that is not invertible: its first three columns have determinant 0"),
    CASE("transform_to_a_plane", .mutate = flat_transform, .mutate_twin = almost_flat_transform,
         .path = TRANSFORM_LEADS),
    CASE("transform_with_nan", .mutate = undefined_transform, .mutate_twin = small_transform,
         .path = TRANSFORM_LEADS
         " that is not invertible: its first three columns have an element that is not finite"),
    CASE("transform_with_infinity", .mutate = infinite_transform, .mutate_twin = infinite_move),
    CASE("transform_to_next_to_nothing", .silent = true, .mutate = tiny_transform),
    CASE("transform_to_far_away", .silent = true, .mutate = huge_transform),
    CASE("transform_of_zeros_of_nothing", .silent = true, .mutate = zero_transform,
         EDITS(SET(ranges[INDEXED][0].primitiveCount, 0))),
};

CASE_LIST(cases_content, cases);
