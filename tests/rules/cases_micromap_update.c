/* SPDX-License-Identifier: Apache-2.0 */
/* What updates may change of the micromaps that their source was built with. */
#include "case.h"

static const struct setup with_khr = {.enable = ENABLE_OPACITY_MICROMAP_KHR};

enum micromap_choice { NONE, NULL_MICROMAP, FIRST, SECOND };

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

/* Or'ed to the choice of the source: the source and its update have this flag. */
#define MAY_CHANGE VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_OPACITY_MICROMAP_UPDATE_BIT_KHR

/* Builds a source in the same command buffer, and makes UPDATE its update. */
static void update(struct scene *scene, uint32_t source_choice, VkDeviceSize update_choice)
{
    const VkBuildAccelerationStructureFlagsKHR flags = source_choice & MAY_CHANGE;
    const VkAccelerationStructureKHR micromaps[2] = {scene_record_micromap(scene, 4),
                                                     scene_record_micromap(scene, 4)};
    scene_use_micromap(scene);
    scene->geometries[INDEXED][0].geometry.triangles.pNext = NULL;
    const uint32_t source = scene_reserve_build(scene, INDEXED);
    scene->infos[source].flags |= flags;
    scene->infos[UPDATE].flags |= flags;
    choose(scene, UPDATE, &scene->micromaps.opacity_of_update, (enum micromap_choice)update_choice,
           micromaps);
    choose(scene, source, &scene->micromaps.opacity,
           (enum micromap_choice)(source_choice & ~MAY_CHANGE), micromaps);
    scene->vk->CmdBuildAccelerationStructuresKHR(scene->command_buffer, 1, &scene->infos[source],
                                                 &scene->range_pointers[source]);
    scene->infos[UPDATE].srcAccelerationStructure = scene->infos[source].dstAccelerationStructure;
}

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

static const struct test_case cases[] = {
    SHARED(RULE(opacity_micromap_is_kept_where_source_had_one), .setup = &with_khr,
           .path = "pInfos[4].pGeometries[0].geometry.triangles.pNext"),
    CASE("update_drops_micromap", EITHER_CALL_FOR(update, FIRST, NONE, FIRST)),
    CASE("update_drops_micromap_that_may_change", EDITS(CALL_FOR(update, FIRST | MAY_CHANGE, NONE)),
         TWIN_EDITS(CALL_FOR(update, FIRST, FIRST))),
    CASE("update_nulls_micromap", EITHER_CALL_FOR(update, FIRST, NULL_MICROMAP, FIRST)),
    CASE("update_gives_null_a_micromap", RULE(opacity_micromap_stays_null_where_source_had_null),
         EITHER_CALL_FOR(update, NULL_MICROMAP, FIRST, NULL_MICROMAP)),
    CASE("update_drops_null", RULE(opacity_micromap_stays_null_where_source_had_null),
         EITHER_CALL_FOR(update, NULL_MICROMAP, NONE, NULL_MICROMAP)),

    SHARED(RULE(opacity_micromap_stays_absent_where_source_had_none), .setup = &with_khr,
           .path = "pInfos[4].pGeometries[0].geometry.triangles.pNext"),
    CASE("update_adds_micromap", EITHER_CALL_FOR(update, NONE, FIRST, NONE)),
    CASE("update_adds_null", EITHER_CALL_FOR(update, NONE, NULL_MICROMAP, NONE)),
    CASE("update_changes_micromap", RULE(opacity_micromap_matches_source),
         EDITS(CALL_FOR(update, FIRST, SECOND)),
         TWIN_EDITS(CALL_FOR(update, FIRST | MAY_CHANGE, SECOND))),

    SHARED(RULE(opacity_micromap_of_deserialized_source_is_deserialized), .setup = &with_khr),
    CASE("update_of_deserialized_with_built_micromap",
         EITHER_CALL(update_deserialized, FIRST, SECOND),
         .path = "pInfos[4].pGeometries[0].geometry.triangles.pNext"),
    CASE("update_of_deserialized_that_may_change", .silent = true,
         EDITS(CALL_WITH(update_deserialized, FIRST),
               SET(infos[UPDATE].flags,
                   VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_UPDATE_BIT_KHR | MAY_CHANGE))),
};

CASE_LIST(cases_micromap_update, cases);
