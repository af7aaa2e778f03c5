/* SPDX-License-Identifier: Apache-2.0 */
/* What updates may change of the micromaps that their source was built with. */
#include "case.h"

static const struct setup with_khr = {.enable = ENABLE_OPACITY_MICROMAP_KHR};

enum micromap_choice { NONE, NULL_MICROMAP, FIRST, SECOND };

struct update_choice {
    enum micromap_choice source, update;
    VkBuildAccelerationStructureFlagsKHR flags;
};

static void choose(struct scene *scene, uint32_t build,
                   VkAccelerationStructureTrianglesOpacityMicromapKHR *opacity,
                   enum micromap_choice choice, const VkAccelerationStructureKHR micromaps[2])
{
    if (choice == NONE)
        return;
    *opacity = scene->micromaps.opacity;
    opacity->micromap = choice == NULL_MICROMAP ? VK_NULL_HANDLE : micromaps[choice - FIRST];
    scene->geometries[build][0].geometry.triangles.pNext = opacity;
    scene_fit(scene, build);
}

/* Builds a source in the same command buffer, and makes UPDATE its update. */
static void update(struct scene *scene, struct update_choice choices)
{
    const VkAccelerationStructureKHR micromaps[2] = {scene_record_micromap(scene, 4),
                                                     scene_record_micromap(scene, 4)};
    scene_use_micromap(scene);
    scene->geometries[INDEXED][0].geometry.triangles.pNext = NULL;
    const uint32_t source = scene_add_build(scene, INDEXED);
    scene->info_count--;
    scene->infos[source].flags |= choices.flags;
    scene->infos[UPDATE].flags |= choices.flags;
    choose(scene, UPDATE, &scene->micromaps.opacity_of_update, choices.update, micromaps);
    choose(scene, source, &scene->micromaps.opacity, choices.source, micromaps);
    scene->vk->CmdBuildAccelerationStructuresKHR(scene->command_buffer, 1, &scene->infos[source],
                                                 &scene->range_pointers[source]);
    scene->infos[UPDATE].srcAccelerationStructure = scene->infos[source].dstAccelerationStructure;
}

#define UPDATE_FROM(name, source, updated, flags)                                                  \
    static void name(struct scene *scene)                                                          \
    {                                                                                              \
        update(scene, (struct update_choice){source, updated, flags});                             \
    }
#define MAY_CHANGE VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_OPACITY_MICROMAP_UPDATE_BIT_KHR

UPDATE_FROM(drop_micromap, FIRST, NONE, 0)
UPDATE_FROM(drop_micromap_that_may_change, FIRST, NONE, MAY_CHANGE)
UPDATE_FROM(null_micromap, FIRST, NULL_MICROMAP, 0)
UPDATE_FROM(keep_micromap, FIRST, FIRST, 0)
UPDATE_FROM(give_null_a_micromap, NULL_MICROMAP, FIRST, 0)
UPDATE_FROM(drop_null, NULL_MICROMAP, NONE, 0)
UPDATE_FROM(keep_null, NULL_MICROMAP, NULL_MICROMAP, 0)
UPDATE_FROM(add_micromap, NONE, FIRST, 0)
UPDATE_FROM(add_null, NONE, NULL_MICROMAP, 0)
UPDATE_FROM(keep_none, NONE, NONE, 0)
UPDATE_FROM(change_micromap, FIRST, SECOND, 0)
UPDATE_FROM(change_micromap_that_may_change, FIRST, SECOND, MAY_CHANGE)

/* UPDATE's own source is deserialized. */
static void update_deserialized(struct scene *scene, enum micromap_choice choice)
{
    const VkAccelerationStructureKHR micromaps[2] = {
        scene_record_micromap(scene, 4),
        scene_micromap_structure(scene, VK_ACCELERATION_STRUCTURE_TYPE_OPACITY_MICROMAP_KHR)};
    scene_use_micromap(scene);
    scene->geometries[INDEXED][0].geometry.triangles.pNext = NULL;
    scene_deserialize(scene, micromaps[1]);
    scene_deserialize(scene, scene->infos[UPDATE].srcAccelerationStructure);
    choose(scene, UPDATE, &scene->micromaps.opacity_of_update, choice, micromaps);
}

static void update_deserialized_with_built(struct scene *scene)
{
    update_deserialized(scene, FIRST);
}

static void update_deserialized_with_deserialized(struct scene *scene)
{
    update_deserialized(scene, SECOND);
}

#define UPDATE_CASE(name_, rule, mutate_, twin_)                                                   \
    {                                                                                              \
        .name = name_, RULES(rule), .setup = &with_khr, .mutate = mutate_, .mutate_twin = twin_,   \
        .path = "pInfos[4].pGeometries[0].geometry.triangles.pNext"                                \
    }

static const struct test_case cases[] = {
    UPDATE_CASE("update_drops_micromap", RULE_opacity_micromap_is_kept_where_source_had_one,
                drop_micromap, keep_micromap),
    UPDATE_CASE("update_drops_micromap_that_may_change",
                RULE_opacity_micromap_is_kept_where_source_had_one, drop_micromap_that_may_change,
                keep_micromap),
    UPDATE_CASE("update_nulls_micromap", RULE_opacity_micromap_is_kept_where_source_had_one,
                null_micromap, keep_micromap),
    UPDATE_CASE("update_gives_null_a_micromap",
                RULE_opacity_micromap_stays_null_where_source_had_null, give_null_a_micromap,
                keep_null),
    UPDATE_CASE("update_drops_null", RULE_opacity_micromap_stays_null_where_source_had_null,
                drop_null, keep_null),
    UPDATE_CASE("update_adds_micromap", RULE_opacity_micromap_stays_absent_where_source_had_none,
                add_micromap, keep_none),
    UPDATE_CASE("update_adds_null", RULE_opacity_micromap_stays_absent_where_source_had_none,
                add_null, keep_none),
    UPDATE_CASE("update_changes_micromap", RULE_opacity_micromap_matches_source, change_micromap,
                change_micromap_that_may_change),
    UPDATE_CASE("update_of_deserialized_with_built_micromap",
                RULE_opacity_micromap_of_deserialized_source_is_deserialized,
                update_deserialized_with_built, update_deserialized_with_deserialized),
    CASE("update_of_deserialized_that_may_change",
         RULE(opacity_micromap_of_deserialized_source_is_deserialized), .silent = true,
         .setup = &with_khr, .mutate = update_deserialized_with_built,
         EDITS(SET(infos[UPDATE].flags,
                   VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_UPDATE_BIT_KHR | MAY_CHANGE))),
};

CASE_LIST(cases_micromap_update, cases);
