/* SPDX-License-Identifier: Apache-2.0 */
/* Updates of VK_NV_ray_tracing by what their source was built with earlier in the same command
 * buffer. */
#include "case.h"

/* A source that was created and built with these flags. */
static VkAccelerationStructureNV built_with(struct scene *scene,
                                            VkBuildAccelerationStructureFlagsNV flags)
{
    const VkBuildAccelerationStructureFlagsNV own = scene->nv.info.flags;
    scene->nv.info.flags = flags;
    scene_nv_give_large_scratch(scene);
    const VkAccelerationStructureNV source = scene_nv_accel(scene);
    scene_nv_build(scene, source);
    scene->nv.info.flags = own;
    return source;
}

static void update_from(struct scene *scene, VkAccelerationStructureNV source)
{
    scene->nv.src = source;
    scene->nv.update = VK_TRUE;
}

static void update_built(struct scene *scene, VkBuildAccelerationStructureFlagsNV flags)
{
    update_from(scene, built_with(scene, flags));
}

static void update_clone(struct scene *scene, VkBuildAccelerationStructureFlagsNV flags)
{
    const VkAccelerationStructureNV source = built_with(scene, flags);
    const VkAccelerationStructureNV clone = scene_nv_accel(scene);
    scene->vk->CmdCopyAccelerationStructureNV(scene->command_buffer, clone, source,
                                              VK_COPY_ACCELERATION_STRUCTURE_MODE_CLONE_KHR);
    update_from(scene, clone);
}

#define ALLOW_UPDATE VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_UPDATE_BIT_NV

/* The original build counts, not the update after it. */
static void update_an_update(struct scene *scene)
{
    scene_nv_use_update(scene);
    scene_nv_call(scene);
    update_from(scene, scene->nv.dst);
}

/* A KHR structure of the same handle, had it one, would be another thing. */
static void build_a_khr_structure_between(struct scene *scene)
{
    scene_nv_use_update(scene);
    scene->vk->CmdBuildAccelerationStructuresKHR(scene->command_buffer, 1, &scene->infos[INDEXED],
                                                 &scene->range_pointers[INDEXED]);
}

static const struct test_case cases[] = {
    SHARED(RULE(update_source_was_built_with_allow_update), .commands = ON_NV),
    CASE("not_allowed", EITHER_CALL(update_built, 0, ALLOW_UPDATE),
         .path = "): src VkAccelerationStructureNV 0x"),
    /* Flags need not be equal, as those of the other extension's updates. */
    CASE("allowed_with_other_flags", .silent = true,
         EDITS(CALL_WITH(update_built,
                         ALLOW_UPDATE | VK_BUILD_ACCELERATION_STRUCTURE_LOW_MEMORY_BIT_NV))),
    CASE("clone_of_what_is_not_allowed", EITHER_CALL(update_clone, 0, ALLOW_UPDATE)),
    CASE("update_of_an_update", .silent = true, .mutate = update_an_update),
    CASE("in_place", .silent = true, .mutate = scene_nv_use_update, EDITS(COPY(nv.dst, nv.src))),
    CASE("beside_the_other_extension", .silent = true, .mutate = build_a_khr_structure_between),
};

CASE_LIST(cases_nv_update, cases);
