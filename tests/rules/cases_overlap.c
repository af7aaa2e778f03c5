/* SPDX-License-Identifier: Apache-2.0 */
/* Structures and scratch of one call that are the same or lie on each other, in one buffer. */
#include <string.h>

#include "case.h"
#include "placing.h"

/* ---- the same structure ---- */

enum { ADDED = SCENE_BASE_BUILDS };

static void add_build(struct scene *scene, uint32_t model)
{
    scene_add_build(scene, model);
}

/* ---- structures ---- */

static void put_two_dsts(struct scene *scene, enum place place)
{
    const struct test_buffer buffer = place_buffer(scene);
    place_dst(scene, INDEXED, &buffer, 0);
    place_dst(scene, AABBS, &buffer, place_offset(place_size(scene, INDEXED), place));
}

/* The second, in the order of builds, comes first in memory. */
static void put_two_dsts_far_inside(struct scene *scene, enum place place)
{
    const struct test_buffer buffer = place_buffer(scene);
    const VkDeviceSize offset = place_offset(place_size(scene, AABBS), place);
    place_dst(scene, INDEXED, &buffer, PLACE_FAR + offset);
    place_dst(scene, AABBS, &buffer, PLACE_FAR);
}

static void put_update(struct scene *scene, enum place dst)
{
    const struct test_buffer buffer = place_buffer(scene);
    place_src(scene, UPDATE, &buffer, PLACE_FAR);
    place_dst(scene, UPDATE, &buffer, PLACE_FAR + place_offset(place_size(scene, UPDATE), dst));
}

static void put_src_and_dst_of_another(struct scene *scene, enum place dst)
{
    const struct test_buffer buffer = place_buffer(scene);
    place_src(scene, UPDATE, &buffer, PLACE_FAR);
    place_dst(scene, TLAS, &buffer, PLACE_FAR + place_offset(place_size(scene, UPDATE), dst));
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

static void put_dst_and_scratch(struct scene *scene, uint32_t build_of_scratch,
                                VkDeviceSize scratch)
{
    const struct test_buffer buffer = place_buffer(scene);
    const VkDeviceSize offset =
        place_scratch_offset(scene, place_size(scene, AABBS), (enum place)scratch);
    place_dst(scene, AABBS, &buffer, PLACE_FAR);
    place_scratch(scene, build_of_scratch, &buffer, PLACE_FAR + offset);
}

static void put_two_scratches(struct scene *scene, enum place second)
{
    const struct test_buffer buffer = place_buffer(scene);
    const VkDeviceSize offset =
        place_scratch_offset(scene, scene_scratch_size(scene, TLAS), second);
    place_scratch(scene, TLAS, &buffer, PLACE_FAR);
    place_scratch(scene, INDEXED, &buffer, PLACE_FAR + offset);
}

static void put_src_and_scratch(struct scene *scene, uint32_t build_of_scratch,
                                VkDeviceSize scratch)
{
    const struct test_buffer buffer = place_buffer(scene);
    const VkDeviceSize offset =
        place_scratch_offset(scene, place_size(scene, UPDATE), (enum place)scratch);
    if (scene_scratch_size(scene, build_of_scratch) == 0)
        scene_skip(scene, "the driver wants no scratch for updates");
    place_src(scene, UPDATE, &buffer, PLACE_FAR);
    place_scratch(scene, build_of_scratch, &buffer, PLACE_FAR + offset);
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

static const struct test_case cases[] = {
    CASE("dst_built_twice", RULE(no_dst_is_built_twice),
         EDITS(CALL_WITH(add_build, INDEXED), COPY(infos[ADDED].dstAccelerationStructure,
                                                   infos[INDEXED].dstAccelerationStructure)),
         TWIN_EDITS(CALL_WITH(add_build, INDEXED)), .path = "pInfos[6]"),
    CASE(
        "refitted_twice", RULE(no_dst_is_built_twice),
        NAMES(RULE_no_src_is_the_dst_of_another_build),
        EDITS(COPY(infos[UPDATE].dstAccelerationStructure, infos[REFIT].dstAccelerationStructure),
              COPY(infos[UPDATE].srcAccelerationStructure, infos[REFIT].srcAccelerationStructure))),
    CASE("dst_updated_twice", RULE(no_dst_is_built_twice),
         EDITS(CALL_WITH(add_build, UPDATE),
               COPY(infos[ADDED].dstAccelerationStructure, infos[UPDATE].dstAccelerationStructure)),
         TWIN_EDITS(CALL_WITH(add_build, UPDATE), COPY(infos[ADDED].srcAccelerationStructure,
                                                       infos[UPDATE].srcAccelerationStructure))),
    CASE(
        "src_is_dst_of_another", RULE(no_src_is_the_dst_of_another_build),
        EDITS(COPY(infos[UPDATE].srcAccelerationStructure, infos[INDEXED].dstAccelerationStructure),
              CALL_WITH(scene_build_source, UPDATE)),
        TWIN_EDITS(CALL_WITH(add_build, UPDATE), COPY(infos[ADDED].srcAccelerationStructure,
                                                      infos[UPDATE].srcAccelerationStructure)),
        .path = "pInfos[4]"),
    CASE(
        "src_is_dst_of_another_though_not_an_update", RULE(no_src_is_the_dst_of_another_build),
        EDITS(COPY(infos[AABBS].srcAccelerationStructure, infos[INDEXED].dstAccelerationStructure)),
        TWIN_EDITS(
            COPY(infos[AABBS].srcAccelerationStructure, infos[AABBS].dstAccelerationStructure)),
        .path = "pInfos[2]"),
    CASE("update_overlaps_itself", RULE(update_src_and_dst_do_not_alias),
         EITHER_CALL(put_update, WITHIN, BEHIND), .path = "pInfos[4].srcAccelerationStructure"),
    CASE("update_aliases_itself", RULE(update_src_and_dst_do_not_alias),
         EITHER_CALL(put_update, AT_BEGINNING, BEHIND)),
    CASE("dst_overlaps_src_of_another", RULE(dst_and_update_src_are_apart),
         EITHER_CALL(put_src_and_dst_of_another, WITHIN, BEHIND),
         .path = "pInfos[3].dstAccelerationStructure"),
    CASE("dst_overlaps_ignored_src_of_another", RULE(dst_and_update_src_are_apart), .silent = true,
         .mutate = overlap_ignored_src_with_dst_of_another),
    CASE("src_overlaps_src", RULE(dst_and_update_src_are_apart), .silent = true,
         .mutate = overlap_two_srcs),
    CASE("dst_overlaps_dst", RULE(dst_and_dst_are_apart), EITHER_CALL(put_two_dsts, WITHIN, BEHIND),
         .count = 1, .path = "with pInfos[2].dstAccelerationStructure"),
    CASE("dst_overlaps_dst_far_inside", RULE(dst_and_dst_are_apart),
         EITHER_CALL(put_two_dsts_far_inside, WITHIN, BEHIND), .path = "pInfos[0]"),
    CASE("dst_overlaps_own_scratch", RULE(dst_and_scratch_are_apart),
         EITHER_CALL_FOR(put_dst_and_scratch, AABBS, WITHIN, BEHIND),
         .path = "with pInfos[2].scratchData"),
    CASE("dst_overlaps_scratch_of_another", RULE(dst_and_scratch_are_apart),
         EITHER_CALL_FOR(put_dst_and_scratch, REFIT, WITHIN, BEHIND),
         .path = "with pInfos[5].scratchData"),
    CASE("scratch_overlaps_scratch", RULE(scratch_and_scratch_are_apart),
         EITHER_CALL(put_two_scratches, WITHIN, BEHIND), .path = "pInfos[0].scratchData"),
    CASE("scratch_overlaps_own_src", RULE(scratch_and_update_src_are_apart),
         EITHER_CALL_FOR(put_src_and_scratch, UPDATE, WITHIN, BEHIND),
         .path = "pInfos[4].scratchData"),
    CASE("scratch_overlaps_src_of_another", RULE(scratch_and_update_src_are_apart),
         EITHER_CALL_FOR(put_src_and_scratch, AABBS, WITHIN, BEHIND),
         .path = "pInfos[2].scratchData"),
    CASE("scratch_overlaps_refit", RULES(RULE_dst_and_scratch_are_apart),
         NAMES(RULE_scratch_and_update_src_are_apart), .mutate = overlap_refit_with_scratch),
    CASE("dst_overlaps_scratch_alone", RULE(dst_and_scratch_are_apart),
         EDITS(CALL_FOR(put_dst_and_scratch, AABBS, WITHIN), CALL_WITH(leave_alone, AABBS)),
         TWIN_EDITS(CALL_FOR(put_dst_and_scratch, AABBS, BEHIND), CALL_WITH(leave_alone, AABBS)),
         .path = "with pInfos[0].scratchData"),
    CASE("update_overlaps_itself_alone", RULE(update_src_and_dst_do_not_alias),
         EDITS(CALL_WITH(put_update, WITHIN), CALL_WITH(leave_alone, UPDATE)),
         TWIN_EDITS(CALL_WITH(put_update, BEHIND), CALL_WITH(leave_alone, UPDATE)),
         .path = "pInfos[0].srcAccelerationStructure"),
    CASE("scratch_overlaps_src_alone", RULE(scratch_and_update_src_are_apart),
         EDITS(CALL_FOR(put_src_and_scratch, UPDATE, WITHIN), CALL_WITH(leave_alone, UPDATE)),
         TWIN_EDITS(CALL_FOR(put_src_and_scratch, UPDATE, BEHIND), CALL_WITH(leave_alone, UPDATE)),
         .path = "pInfos[0].scratchData"),
};

CASE_LIST(cases_overlap, cases);
