/* SPDX-License-Identifier: Apache-2.0 */
/* Opacity micromaps: their builds, and triangles that use them. */
#include "tests/rules/calls/placing.h"
#include "tests/rules/case.h"

static void add_second_data(struct scene *scene)
{
    static VkAccelerationStructureGeometryMicromapDataKHR second;
    scene_build_micromap(scene);
    second = scene->micromaps.data;
    scene->micromaps.data.pNext = &second;
}
#include "micromap.inc"

enum {
    LOSSY = VK_BUILD_ACCELERATION_STRUCTURE_MICROMAP_LOSSY_BIT_KHR,
    STATES_4 = VK_OPACITY_MICROMAP_FORMAT_4_STATE_KHR,
    /* As the null driver has them. */
    LIMIT_2_STATE = 6,
    LIMIT_4_STATE = 5,
    LIMIT_LOSSY = 4,
    LIMIT_DISPLACEMENT = 5,
    LIMIT_TRIANGLES = 4096,
    LEVEL_OF_NONE = 13,
};

static void offer_limits(struct null_driver_config *config)
{
    config->micromap_properties_khr.maxOpacity2StateSubdivisionLevel = LIMIT_2_STATE;
    config->micromap_properties_khr.maxOpacity4StateSubdivisionLevel = LIMIT_4_STATE;
    config->micromap_properties_khr.maxOpacityLossy4StateSubdivisionLevel = LIMIT_LOSSY;
    config->micromap_properties_khr.maxMicromapTriangles = LIMIT_TRIANGLES;
    config->micromap_properties.maxOpacity2StateSubdivisionLevel = LIMIT_2_STATE;
    config->micromap_properties.maxOpacity4StateSubdivisionLevel = LIMIT_4_STATE;
}

#include "micromap_data.inc"
#include "micromap_use.inc"

/* Rules of level state that take more to decide here. */

static void use_built(struct scene *scene)
{
    scene_use_micromap(scene);
    scene->micromaps.opacity.micromap = scene_record_micromap(scene, 4);
}

/* The structure may be a micromap, but is a BLAS. */
static void use_blas_as_micromap(struct scene *scene)
{
    scene_use_micromap(scene);
    const VkAccelerationStructureKHR accel =
        scene_micromap_structure(scene, VK_ACCELERATION_STRUCTURE_TYPE_GENERIC_KHR);
    VkAccelerationStructureBuildGeometryInfoKHR info = scene->infos[UNINDEXED];
    info.dstAccelerationStructure = accel;
    scene->vk->CmdBuildAccelerationStructuresKHR(scene->command_buffer, 1, &info,
                                                 &scene->range_pointers[UNINDEXED]);
    scene->micromaps.opacity.micromap = accel;
}

/* Recorded, and submitted before the call. */
static void submit_before(struct scene *scene, VkAccelerationStructureTypeKHR type)
{
    const VkCommandBuffer command_buffer = scene->command_buffer;
    scene->command_buffer = scene_begin_own(scene);
    if (type == VK_ACCELERATION_STRUCTURE_TYPE_OPACITY_MICROMAP_KHR)
        use_built(scene);
    else
        use_blas_as_micromap(scene);
    scene_run(scene, scene->command_buffer);
    scene->command_buffer = command_buffer;
}

static VkMicromapBuildInfoEXT build_info(struct scene *scene, bool is_on_host)
{
    return scene_build_of_micromap(scene, VK_MICROMAP_TYPE_OPACITY_MICROMAP_EXT,
                                   scene->micromaps.opacity_ext.micromap,
                                   scene->micromaps.usages_ext, is_on_host)
        .info;
}

#include "micromap_state.inc"

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
#define DATA_MAY_CHANGE VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_OPACITY_MICROMAP_DATA_UPDATE_BIT_EXT

/* Builds a source in the same command buffer, and makes UPDATE its update. */
static void update(struct scene *scene, uint32_t source_choice, VkDeviceSize update_choice)
{
    const VkBuildAccelerationStructureFlagsKHR flags =
        source_choice & (MAY_CHANGE | DATA_MAY_CHANGE);
    const VkAccelerationStructureKHR micromaps[2] = {scene_record_micromap(scene, 4),
                                                     scene_record_micromap(scene, 4)};
    scene_use_micromap(scene);
    scene->geometries[INDEXED][0].geometry.triangles.pNext = NULL;
    const uint32_t source = scene_reserve_build(scene, INDEXED);
    scene->infos[source].flags |= flags;
    scene->infos[UPDATE].flags |= flags;
    choose(scene, UPDATE, &scene->micromaps.opacity_of_update, (enum micromap_choice)update_choice,
           micromaps);
    choose(scene, source, &scene->micromaps.opacity, (enum micromap_choice)(source_choice & ~flags),
           micromaps);
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
#include "micromap_update.inc"
