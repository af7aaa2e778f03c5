/* SPDX-License-Identifier: Apache-2.0 */
/* Structures and scratch of one call that are the same or lie on each other, in one buffer. */
#include <string.h>

#include "case.h"
#include "placing.h"

/* ---- the same structure ---- */

static void share_dst(struct scene *scene)
{
    const uint32_t build = scene_add_build(scene, INDEXED);
    scene->infos[build].dstAccelerationStructure = scene->infos[INDEXED].dstAccelerationStructure;
}

static void add_another(struct scene *scene)
{
    scene_add_build(scene, INDEXED);
}

static void share_dst_of_updates(struct scene *scene)
{
    const uint32_t build = scene_add_build(scene, UPDATE);
    scene->infos[build].dstAccelerationStructure = scene->infos[UPDATE].dstAccelerationStructure;
}

static void update_two_from_one(struct scene *scene)
{
    const uint32_t build = scene_add_build(scene, UPDATE);
    scene->infos[build].srcAccelerationStructure = scene->infos[UPDATE].srcAccelerationStructure;
}

/* ---- structures ---- */

static void put_two_dsts(struct scene *scene, VkDeviceSize first, VkDeviceSize second)
{
    const struct test_buffer buffer = place_buffer(scene);
    place_dst(scene, INDEXED, &buffer, first);
    place_dst(scene, AABBS, &buffer, second);
}

static void overlap_dsts(struct scene *scene)
{
    put_two_dsts(scene, 0, place_within(place_size(scene, INDEXED)));
}

static void put_dsts_side_by_side(struct scene *scene)
{
    put_two_dsts(scene, 0, place_behind(place_size(scene, INDEXED)));
}

/* The second, in the order of builds, comes first in memory. */
static void overlap_dsts_far_inside(struct scene *scene)
{
    put_two_dsts(scene, PLACE_FAR + place_within(place_size(scene, AABBS)), PLACE_FAR);
}

static void put_dsts_side_by_side_far_inside(struct scene *scene)
{
    put_two_dsts(scene, PLACE_FAR + place_behind(place_size(scene, AABBS)), PLACE_FAR);
}

static void put_update(struct scene *scene, VkDeviceSize dst)
{
    const struct test_buffer buffer = place_buffer(scene);
    place_src(scene, UPDATE, &buffer, PLACE_FAR);
    place_dst(scene, UPDATE, &buffer, PLACE_FAR + dst);
}

static void overlap_update(struct scene *scene)
{
    put_update(scene, place_within(place_size(scene, UPDATE)));
}

static void put_update_side_by_side(struct scene *scene)
{
    put_update(scene, place_behind(place_size(scene, UPDATE)));
}

static void put_src_and_dst_of_another(struct scene *scene, VkDeviceSize offset)
{
    const struct test_buffer buffer = place_buffer(scene);
    place_src(scene, UPDATE, &buffer, PLACE_FAR);
    place_dst(scene, TLAS, &buffer, PLACE_FAR + offset);
}

static void overlap_src_with_dst_of_another(struct scene *scene)
{
    put_src_and_dst_of_another(scene, place_within(place_size(scene, UPDATE)));
}

static void put_src_beside_dst_of_another(struct scene *scene)
{
    put_src_and_dst_of_another(scene, place_behind(place_size(scene, UPDATE)));
}

/* The source of a build that is no update is not read. */
static void overlap_ignored_src_with_dst_of_another(struct scene *scene)
{
    const struct test_buffer buffer = place_buffer(scene);
    place_src(scene, INDEXED, &buffer, 0);
    place_dst(scene, TLAS, &buffer, 0);
}

static void overlap_two_srcs(struct scene *scene)
{
    const uint32_t build = scene_add_build(scene, UPDATE);
    const struct test_buffer buffer = place_buffer(scene);
    place_src(scene, UPDATE, &buffer, 0);
    place_src(scene, build, &buffer, 0);
}

/* ---- scratch ---- */

static void put_dst_and_scratch(struct scene *scene, uint32_t build_of_scratch, VkDeviceSize offset)
{
    const struct test_buffer buffer = place_buffer(scene);
    place_dst(scene, AABBS, &buffer, PLACE_FAR);
    place_scratch(scene, build_of_scratch, &buffer, PLACE_FAR + offset);
}

static void overlap_dst_with_own_scratch(struct scene *scene)
{
    put_dst_and_scratch(scene, AABBS, place_scratch_within(scene, place_size(scene, AABBS)));
}

static void put_dst_beside_own_scratch(struct scene *scene)
{
    put_dst_and_scratch(scene, AABBS, place_scratch_behind(scene, place_size(scene, AABBS)));
}

static void overlap_dst_with_scratch_of_another(struct scene *scene)
{
    put_dst_and_scratch(scene, REFIT, place_scratch_within(scene, place_size(scene, AABBS)));
}

static void put_dst_beside_scratch_of_another(struct scene *scene)
{
    put_dst_and_scratch(scene, REFIT, place_scratch_behind(scene, place_size(scene, AABBS)));
}

static void put_two_scratches(struct scene *scene, VkDeviceSize offset)
{
    const struct test_buffer buffer = place_buffer(scene);
    place_scratch(scene, TLAS, &buffer, PLACE_FAR);
    place_scratch(scene, INDEXED, &buffer, PLACE_FAR + offset);
}

static void overlap_scratches(struct scene *scene)
{
    put_two_scratches(scene, place_scratch_within(scene, scene_scratch_size(scene, TLAS)));
}

static void put_scratches_side_by_side(struct scene *scene)
{
    put_two_scratches(scene, place_scratch_behind(scene, scene_scratch_size(scene, TLAS)));
}

static void put_src_and_scratch(struct scene *scene, uint32_t build_of_scratch, VkDeviceSize offset)
{
    const struct test_buffer buffer = place_buffer(scene);
    if (scene_scratch_size(scene, build_of_scratch) == 0)
        scene_skip(scene, "the driver wants no scratch for updates");
    place_src(scene, UPDATE, &buffer, PLACE_FAR);
    place_scratch(scene, build_of_scratch, &buffer, PLACE_FAR + offset);
}

static void overlap_src_with_own_scratch(struct scene *scene)
{
    put_src_and_scratch(scene, UPDATE, place_scratch_within(scene, place_size(scene, UPDATE)));
}

static void put_src_beside_own_scratch(struct scene *scene)
{
    put_src_and_scratch(scene, UPDATE, place_scratch_behind(scene, place_size(scene, UPDATE)));
}

static void overlap_src_with_scratch_of_another(struct scene *scene)
{
    put_src_and_scratch(scene, AABBS, place_scratch_within(scene, place_size(scene, UPDATE)));
}

static void put_src_beside_scratch_of_another(struct scene *scene)
{
    put_src_and_scratch(scene, AABBS, place_scratch_behind(scene, place_size(scene, UPDATE)));
}

static void overlap_refit_with_scratch(struct scene *scene)
{
    const struct test_buffer buffer = place_buffer(scene);
    if (scene_scratch_size(scene, REFIT) == 0)
        scene_skip(scene, "the driver wants no scratch for updates");
    place_dst(scene, REFIT, &buffer, 0);
    scene->infos[REFIT].srcAccelerationStructure = scene->infos[REFIT].dstAccelerationStructure;
    scene_build_source(scene, REFIT);
    place_scratch(scene, REFIT, &buffer, 0);
}

/* ---- a call of one build ---- */

static void leave_alone(struct scene *scene, uint32_t build)
{
    memcpy(scene->geometries[0], scene->geometries[build], sizeof(scene->geometries[0]));
    memcpy(scene->ranges[0], scene->ranges[build], sizeof(scene->ranges[0]));
    scene->infos[0] = scene->infos[build];
    scene->infos[0].pGeometries = scene->geometries[0];
    scene->info_count = 1;
}

#define ALONE(place, build)                                                                        \
    static void place##_alone(struct scene *scene)                                                 \
    {                                                                                              \
        place(scene);                                                                              \
        leave_alone(scene, build);                                                                 \
    }

ALONE(overlap_dst_with_own_scratch, AABBS)
ALONE(put_dst_beside_own_scratch, AABBS)
ALONE(overlap_update, UPDATE)
ALONE(put_update_side_by_side, UPDATE)
ALONE(overlap_src_with_own_scratch, UPDATE)
ALONE(put_src_beside_own_scratch, UPDATE)

static const struct test_case cases[] = {
    CASE("dst_built_twice", RULES(RULE_no_dst_is_built_twice), .mutate = share_dst,
         .mutate_twin = add_another, .path = "pInfos[6]"),
    CASE("dst_updated_twice", RULES(RULE_no_dst_is_built_twice), .mutate = share_dst_of_updates,
         .mutate_twin = update_two_from_one),
    CASE("src_is_dst_of_another", RULES(RULE_no_src_is_the_dst_of_another_build),
         .edits = EDITS(
             COPY(infos[UPDATE].srcAccelerationStructure, infos[INDEXED].dstAccelerationStructure),
             CALL_WITH(scene_build_source, UPDATE)),
         .mutate_twin = update_two_from_one, .path = "pInfos[4]"),
    CASE("src_is_dst_of_another_though_not_an_update",
         RULES(RULE_no_src_is_the_dst_of_another_build),
         .edits = EDITS(
             COPY(infos[AABBS].srcAccelerationStructure, infos[INDEXED].dstAccelerationStructure)),
         .twin_edits = EDITS(
             COPY(infos[AABBS].srcAccelerationStructure, infos[AABBS].dstAccelerationStructure)),
         .path = "pInfos[2]"),
    CASE("update_overlaps_itself", RULES(RULE_update_src_and_dst_do_not_alias),
         .mutate = overlap_update, .mutate_twin = put_update_side_by_side,
         .path = "pInfos[4].srcAccelerationStructure"),
    CASE("update_aliases_itself", RULES(RULE_update_src_and_dst_do_not_alias),
         .edits = EDITS(CALL_WITH_SIZE(put_update, 0)), .mutate_twin = put_update_side_by_side),
    CASE("dst_overlaps_src_of_another", RULES(RULE_dst_and_update_src_are_apart),
         .mutate = overlap_src_with_dst_of_another, .mutate_twin = put_src_beside_dst_of_another,
         .path = "pInfos[3].dstAccelerationStructure"),
    CASE("dst_overlaps_ignored_src_of_another", RULES(RULE_dst_and_update_src_are_apart),
         .silent = true, .mutate = overlap_ignored_src_with_dst_of_another),
    CASE("src_overlaps_src", RULES(RULE_dst_and_update_src_are_apart), .silent = true,
         .mutate = overlap_two_srcs),
    CASE("dst_overlaps_dst", RULES(RULE_dst_and_dst_are_apart), .mutate = overlap_dsts,
         .mutate_twin = put_dsts_side_by_side, .path = "with pInfos[2].dstAccelerationStructure",
         .count = 1),
    CASE("dst_overlaps_dst_far_inside", RULES(RULE_dst_and_dst_are_apart),
         .mutate = overlap_dsts_far_inside, .mutate_twin = put_dsts_side_by_side_far_inside,
         .path = "pInfos[0]"),
    CASE("dst_overlaps_own_scratch", RULES(RULE_dst_and_scratch_are_apart),
         .mutate = overlap_dst_with_own_scratch, .mutate_twin = put_dst_beside_own_scratch,
         .path = "with pInfos[2].scratchData"),
    CASE("dst_overlaps_scratch_of_another", RULES(RULE_dst_and_scratch_are_apart),
         .mutate = overlap_dst_with_scratch_of_another,
         .mutate_twin = put_dst_beside_scratch_of_another, .path = "with pInfos[5].scratchData"),
    CASE("scratch_overlaps_scratch", RULES(RULE_scratch_and_scratch_are_apart),
         .mutate = overlap_scratches, .mutate_twin = put_scratches_side_by_side,
         .path = "pInfos[0].scratchData"),
    CASE("scratch_overlaps_own_src", RULES(RULE_scratch_and_update_src_are_apart),
         .mutate = overlap_src_with_own_scratch, .mutate_twin = put_src_beside_own_scratch,
         .path = "pInfos[4].scratchData"),
    CASE("scratch_overlaps_src_of_another", RULES(RULE_scratch_and_update_src_are_apart),
         .mutate = overlap_src_with_scratch_of_another,
         .mutate_twin = put_src_beside_scratch_of_another, .path = "pInfos[2].scratchData"),
    CASE("scratch_overlaps_refit",
         RULES(RULE_dst_and_scratch_are_apart, RULE_scratch_and_update_src_are_apart),
         .mutate = overlap_refit_with_scratch),
    CASE("dst_overlaps_scratch_alone", RULES(RULE_dst_and_scratch_are_apart),
         .mutate = overlap_dst_with_own_scratch_alone,
         .mutate_twin = put_dst_beside_own_scratch_alone, .path = "with pInfos[0].scratchData"),
    CASE("update_overlaps_itself_alone", RULES(RULE_update_src_and_dst_do_not_alias),
         .mutate = overlap_update_alone, .mutate_twin = put_update_side_by_side_alone,
         .path = "pInfos[0].srcAccelerationStructure"),
    CASE("scratch_overlaps_src_alone", RULES(RULE_scratch_and_update_src_are_apart),
         .mutate = overlap_src_with_own_scratch_alone,
         .mutate_twin = put_src_beside_own_scratch_alone, .path = "pInfos[0].scratchData"),
};

CASE_LIST(cases_overlap, cases);
