/* SPDX-License-Identifier: Apache-2.0 */
/* The parameters of vkCmdBuildAccelerationStructureNV: handles, memory, scratch. */
#include "case.h"

/* ---- handles ---- */

static void use_an_own_src_that_is_not_read(struct scene *scene)
{
    scene->nv.src = scene_nv_accel(scene);
}

static uint64_t foreign_accel(struct scene *scene)
{
    scene_enter_other_device(scene);
    const VkAccelerationStructureNV accel = scene_nv_accel(scene);
    scene_leave_other_device(scene);
    return (uint64_t)accel;
}

/* ---- memory ---- */

static void use_an_unbound_dst(struct scene *scene)
{
    scene->nv.dst = scene_nv_create(scene);
}

static void free_the_memory_of_dst(struct scene *scene)
{
    scene->nv.dst = scene_nv_create(scene);
    const struct test_memory memory = scene_nv_allocate(scene, scene->nv.dst, 0);
    scene_nv_bind(scene, scene->nv.dst, memory.handle, 0);
    scene_destroy(scene, (uint64_t)memory.handle);
}

static VkMemoryRequirements of_object(const struct scene *scene, VkAccelerationStructureNV accel)
{
    return scene_nv_requirements(scene, accel,
                                 VK_ACCELERATION_STRUCTURE_MEMORY_REQUIREMENTS_TYPE_OBJECT_NV);
}

/* Binds dst so far behind the beginning of its memory that its end is that much beyond the end. */
static void bind_dst_beyond(struct scene *scene, VkDeviceSize alignments)
{
    scene->nv.dst = scene_nv_create(scene);
    const VkMemoryRequirements needs = of_object(scene, scene->nv.dst);
    const struct test_memory memory =
        scene_nv_allocate(scene, scene->nv.dst, needs.size + needs.alignment);
    scene_nv_bind(scene, scene->nv.dst, memory.handle, needs.alignment * (1 + alignments));
}

/* An update whose dst begins `alignments` alignments behind its source, which ends as many behind
 * that. */
static void update_behind(struct scene *scene, VkDeviceSize alignments)
{
    struct scene_nv *nv = &scene->nv;
    nv->src = scene_nv_create(scene);
    nv->dst = scene_nv_create(scene);
    const VkMemoryRequirements needs = of_object(scene, nv->dst);
    const VkDeviceSize size =
        (needs.size + needs.alignment - 1) / needs.alignment * needs.alignment;
    const struct test_memory memory = scene_nv_allocate(scene, nv->dst, 2 * size);
    scene_nv_bind(scene, nv->src, memory.handle, 0);
    scene_nv_bind(scene, nv->dst, memory.handle, size - alignments * needs.alignment);
    scene_nv_build(scene, nv->src);
    nv->update = VK_TRUE;
}

static void update_in_another_object_of_the_same_memory(struct scene *scene)
{
    struct scene_nv *nv = &scene->nv;
    nv->src = scene_nv_create(scene);
    nv->dst = scene_nv_create(scene);
    const struct test_memory memory = scene_nv_allocate(scene, nv->dst, 0);
    scene_nv_bind(scene, nv->src, memory.handle, 0);
    scene_nv_bind(scene, nv->dst, memory.handle, 0);
    scene_nv_build(scene, nv->src);
    nv->update = VK_TRUE;
}

/* ---- scratch ---- */

static VkDeviceSize scratch_size(const struct scene *scene)
{
    const VkDeviceSize size =
        scene_nv_requirements(
            scene, scene->nv.dst,
            scene->nv.update ? VK_ACCELERATION_STRUCTURE_MEMORY_REQUIREMENTS_TYPE_UPDATE_SCRATCH_NV
                             : VK_ACCELERATION_STRUCTURE_MEMORY_REQUIREMENTS_TYPE_BUILD_SCRATCH_NV)
            .size;
    return size != 0 ? size : 1;
}

static void use_scratch(struct scene *scene, VkBufferUsageFlags usage, VkDeviceSize less)
{
    scene->nv.scratch = scene_buffer(scene, scratch_size(scene) - less, usage).handle;
}

static void use_instances_of_another_usage(struct scene *scene)
{
    scene->nv.instance_data =
        scene_buffer(scene, SCENE_BUFFER_SIZE, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT).handle;
}

static void use_scratch_behind(struct scene *scene, VkDeviceSize less)
{
    const VkDeviceSize size = 4096 + scratch_size(scene);
    scene->nv.scratch = scene_buffer(scene, size, VK_BUFFER_USAGE_RAY_TRACING_BIT_NV).handle;
    scene->nv.scratch_offset = 4096 + less;
}

#define RAY_TRACING VK_BUFFER_USAGE_RAY_TRACING_BIT_NV

static const struct test_case cases[] = {
    CASE("info_null", RULE(nv_info_is_readable), EDITS(SET(nv.info_argument, 0))),
    CASE("info_low_address", RULE(nv_info_is_readable), EDITS(SET(nv.info_argument, 16))),
    CASE("update_without_source", RULE(nv_update_has_a_source), EDITS(SET(nv.update, VK_TRUE)),
         .mutate_twin = scene_nv_use_update),
    CASE("dst_and_scratch_null",
         RULES(RULE_nv_dst_is_a_valid_handle, RULE_nv_scratch_is_a_valid_buffer),
         EDITS(SET(nv.dst, 0), SET(nv.scratch, 0)), .path = " is VK_NULL_HANDLE. "),
    CASE("dst_destroyed", RULE(nv_dst_is_a_valid_handle), EDITS(DESTROY(nv.dst)),
         .path = "): dst VkAccelerationStructureNV 0x"),
    CASE("dst_never_created", RULE(nv_dst_is_a_valid_handle), EDITS(SET(nv.dst, 0x1234567))),
    CASE("dst_of_the_other_extension", RULE(nv_dst_is_a_valid_handle),
         EDITS(COPY(nv.dst, infos[INDEXED].dstAccelerationStructure))),
    CASE("refit_destroyed", RULE(nv_dst_is_a_valid_handle), NAMES(RULE_nv_src_is_a_valid_handle),
         .prepare = scene_nv_use_update, EDITS(COPY(nv.src, nv.dst), DESTROY(nv.dst))),
    CASE("src_destroyed", RULE(nv_src_is_a_valid_handle), .prepare = scene_nv_use_update,
         EDITS(DESTROY(nv.src))),
    CASE("src_destroyed_and_not_read", RULE(nv_src_is_a_valid_handle),
         .mutate = scene_nv_use_update, EDITS(DESTROY(nv.src), SET(nv.update, VK_FALSE)),
         .mutate_twin = use_an_own_src_that_is_not_read),
    CASE("scratch_destroyed", RULE(nv_scratch_is_a_valid_buffer), EDITS(DESTROY(nv.scratch))),
    CASE("scratch_never_created", RULE(nv_scratch_is_a_valid_buffer),
         EDITS(SET(nv.scratch, 0x1234567))),
    CASE("instances_destroyed", RULE(nv_instance_data_is_a_valid_buffer),
         .prepare = scene_nv_use_instances, EDITS(DESTROY(nv.instance_data))),
    CASE("instances_never_created_of_a_blas", RULE(nv_instance_data_is_a_valid_buffer),
         EDITS(SET(nv.instance_data, 0x1234567))),

    SHARED(RULE(nv_objects_share_the_device)),
    CASE("dst_of_another_device", EDITS(MAKE_HANDLE(nv.dst, foreign_accel))),
    CASE("src_of_another_device",
         PREPARE_EDITS(MAKE_HANDLE(nv.src, foreign_accel), SET(nv.update, VK_TRUE)),
         TWIN_EDITS(SET(nv.update, VK_FALSE))),
    CASE("scratch_of_another_device", EDITS(MAKE_HANDLE(nv.scratch, scene_nv_foreign_buffer))),
    CASE("instances_of_another_device", .prepare = scene_nv_use_instances,
         EDITS(MAKE_HANDLE(nv.instance_data, scene_nv_foreign_buffer))),
    CASE("dst_unbound", RULE(nv_dst_is_bound_to_memory), .mutate = use_an_unbound_dst),
    CASE("dst_of_freed_memory", RULE(nv_dst_is_bound_to_memory), .mutate = free_the_memory_of_dst),

    SHARED(RULE(nv_dst_is_bound_to_memory), .spares_drivers = true),
    CASE("dst_bound_beyond_the_end", EITHER_CALL_SIZE(bind_dst_beyond, 1, 0)),
    CASE("dst_bound_behind_the_end", EDITS(CALL_WITH_SIZE(bind_dst_beyond, 1 << 20))),

    SHARED(RULE(nv_update_src_and_dst_do_not_alias)),
    CASE("dst_over_the_end_of_src", EITHER_CALL_SIZE(update_behind, 1, 0)),
    CASE("dst_in_the_place_of_src", .mutate = update_in_another_object_of_the_same_memory,
         .mutate_twin = scene_nv_use_update, TWIN_EDITS(COPY(nv.dst, nv.src))),
    CASE("dst_over_what_is_not_read", .silent = true,
         EDITS(CALL_WITH_SIZE(update_behind, 1), SET(nv.update, VK_FALSE))),

    SHARED(RULE(nv_build_scratch_is_large_enough)),
    CASE("scratch_usage", RULES(RULE_nv_scratch_has_ray_tracing_usage),
         NAMES(RULE_nv_info_scratch_has_ray_tracing_usage),
         EDITS(CALL_FOR(use_scratch, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, 0)),
         TWIN_EDITS(CALL_FOR(use_scratch, RAY_TRACING | VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, 0))),
    CASE("instance_usage", RULES(RULE_nv_instance_data_has_ray_tracing_usage),
         NAMES(RULE_nv_info_instance_data_has_ray_tracing_usage), .prepare = scene_nv_use_instances,
         .mutate = use_instances_of_another_usage),
    CASE("build_scratch_short", EITHER_CALL_FOR(use_scratch, RAY_TRACING, 1, 0),
         .path = "scratchOffset 0 leaves less of VkBuffer 0x"),
    /* Building needs more. */
    CASE("build_scratch_of_an_update",
         EDITS(SET(nv.update, VK_TRUE), CALL_FOR(use_scratch, RAY_TRACING, 0),
               SET(nv.update, VK_FALSE)),
         .spares_drivers = true),
    CASE("build_scratch_over_its_end", EITHER_CALL_SIZE(use_scratch_behind, 1, 0)),
    CASE("build_scratch_offset_behind_the_end", EDITS(SET(nv.scratch_offset, 1ull << 40))),
    CASE("build_scratch_offset_that_wraps", EDITS(SET(nv.scratch_offset, UINT64_MAX - 255))),

    SHARED(RULE(nv_update_scratch_is_large_enough), .prepare = scene_nv_use_update),
    CASE("update_scratch_short", EITHER_CALL_FOR(use_scratch, RAY_TRACING, 1, 0)),
    CASE("update_scratch_offset_behind_the_end", EDITS(SET(nv.scratch_offset, 1ull << 40))),
};

CASE_LIST(cases_nv, cases);
