/* SPDX-License-Identifier: Apache-2.0 */
/* Many structures and scratches that meet: every pair is told, and no other. */
#include "case.h"
#include "placing.h"

enum { MANY = 8, PAIRS_OF_MANY = MANY * (MANY - 1) / 2 };

/* MANY builds more, in `groups` groups of one dst each. */
static void share_dst_in_groups(struct scene *scene, uint32_t groups)
{
    VkAccelerationStructureKHR dst[MANY];
    for (uint32_t i = 0; i < MANY; i++) {
        const uint32_t build = scene_add_build(scene, INDEXED);
        dst[i] = scene->infos[build].dstAccelerationStructure;
        scene->infos[build].dstAccelerationStructure = dst[i % groups];
    }
}

/* Each has its own, in the opposite order of creation. */
static void reverse_many_dsts(struct scene *scene)
{
    share_dst_in_groups(scene, MANY);
    for (uint32_t first = SCENE_BASE_BUILDS, last = first + MANY - 1; first < last;
         first++, last--) {
        const VkAccelerationStructureKHR dst = scene->infos[first].dstAccelerationStructure;
        scene->infos[first].dstAccelerationStructure = scene->infos[last].dstAccelerationStructure;
        scene->infos[last].dstAccelerationStructure = dst;
    }
}

static void update_many_from_dst_of_another(struct scene *scene)
{
    if (scene->command == COMMAND_HOST)
        scene_build_before(scene, INDEXED, 1);
    for (int i = 0; i < MANY; i++)
        scene->infos[scene_add_build(scene, UPDATE)].srcAccelerationStructure =
            scene->infos[INDEXED].dstAccelerationStructure;
}

static void update_many_from_one(struct scene *scene)
{
    for (int i = 0; i < MANY; i++)
        scene->infos[scene_add_build(scene, UPDATE)].srcAccelerationStructure =
            scene->infos[UPDATE].srcAccelerationStructure;
}

static void alias_many_dsts(struct scene *scene)
{
    const struct test_buffer buffer = place_buffer(scene);
    for (int i = 0; i < MANY; i++)
        place_dst(scene, scene_add_build(scene, INDEXED), &buffer, 0);
}

static void line_up_many_dsts(struct scene *scene)
{
    const struct test_buffer buffer = place_buffer(scene);
    const VkDeviceSize step = place_behind(place_size(scene, INDEXED));
    for (VkDeviceSize i = 0; i < MANY; i++)
        place_dst(scene, scene_add_build(scene, INDEXED), &buffer, i * step);
}

/* Each lies on the one before it and on the one behind it, on no other. */
static void chain_many_dsts(struct scene *scene)
{
    const struct test_buffer buffer = place_buffer(scene);
    for (VkDeviceSize i = 0; i < MANY; i++) {
        const uint32_t build = scene_add_build(scene, INDEXED);
        place_grow(scene, build, 256);
        place_dst(scene, build, &buffer, i * place_within(place_size(scene, build)));
    }
}

/* A large one over many small ones. */
static void cover_many_dsts(struct scene *scene)
{
    const struct test_buffer buffer = place_buffer(scene);
    const VkDeviceSize step = place_behind(place_size(scene, INDEXED));
    const uint32_t large = scene_add_build(scene, INDEXED);
    place_grow(scene, large, MANY * step);
    place_dst(scene, large, &buffer, 0);
    for (VkDeviceSize i = 0; i < MANY; i++)
        place_dst(scene, scene_add_build(scene, INDEXED), &buffer, i * step);
}

/* The same, but the large one is only built small: the rest of it isn't touched. */
static void cover_many_dsts_unused(struct scene *scene)
{
    const struct test_buffer buffer = place_buffer(scene);
    const VkDeviceSize step = place_behind(place_size(scene, INDEXED));
    const uint32_t large = scene_add_build(scene, INDEXED);
    scene->infos[large].dstAccelerationStructure =
        scene_accel_in(scene, &buffer, 0, PLACE_SIZE, scene->infos[large].type);
    for (VkDeviceSize i = 1; i < MANY; i++)
        place_dst(scene, scene_add_build(scene, INDEXED), &buffer, i * step);
}

static void alias_many_refits(struct scene *scene)
{
    const struct test_buffer buffer = place_buffer(scene);
    for (int i = 0; i < MANY; i++) {
        const uint32_t build = scene_add_build(scene, REFIT);
        place_dst(scene, build, &buffer, 0);
        scene->infos[build].srcAccelerationStructure = scene->infos[build].dstAccelerationStructure;
        scene_build_source(scene, build);
    }
}

static void share_scratch_among_many(struct scene *scene)
{
    for (int i = 1; i < MANY; i++)
        scene->infos[scene_add_build(scene, INDEXED)].scratchData =
            scene->infos[INDEXED].scratchData;
}

static const struct setup without_pairs_of_dsts = {.muted = "03702"};

static const struct test_case cases[] = {
    CASE("all_pairs_of_one_dst", RULE(no_dst_is_built_twice),
         EDITS(CALL_WITH(share_dst_in_groups, 1)), .mutate_twin = reverse_many_dsts,
         .count = PAIRS_OF_MANY),
    CASE("all_pairs_of_two_dsts", RULE(no_dst_is_built_twice),
         EDITS(CALL_WITH(share_dst_in_groups, 2)), .count = MANY / 2 * (MANY / 2 - 1)),
    CASE("all_pairs_of_srcs_and_a_dst", RULE(no_src_is_the_dst_of_another_build),
         .mutate = update_many_from_dst_of_another, .mutate_twin = update_many_from_one,
         .count = MANY),
    CASE("all_pairs_of_aliasing_dsts", RULE(dst_and_dst_are_apart), .mutate = alias_many_dsts,
         .mutate_twin = line_up_many_dsts, .count = PAIRS_OF_MANY),
    CASE("all_pairs_of_a_chain", RULE(dst_and_dst_are_apart), .mutate = chain_many_dsts,
         .count = MANY - 1),
    CASE("all_pairs_under_a_large_one", RULE(dst_and_dst_are_apart), .mutate = cover_many_dsts,
         .mutate_twin = cover_many_dsts_unused, .count = MANY),
    CASE("all_pairs_of_aliasing_refits_dst", RULES(RULE_dst_and_dst_are_apart),
         NAMES(RULE_dst_and_update_src_are_apart), .mutate = alias_many_refits,
         .count = PAIRS_OF_MANY),
    CASE("all_pairs_of_aliasing_refits_src", RULE(dst_and_update_src_are_apart),
         .setup = &without_pairs_of_dsts, .mutate = alias_many_refits, .count = 2 * PAIRS_OF_MANY),
    CASE("all_pairs_of_shared_scratch", RULE(scratch_and_scratch_are_apart),
         .mutate = share_scratch_among_many, .count = PAIRS_OF_MANY),
};

CASE_LIST(cases_pairs, cases);
