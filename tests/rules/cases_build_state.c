/* SPDX-License-Identifier: Apache-2.0 */
/* Source and destination of a build: handles, types, memory, size. */
#include "case.h"
#include "placing.h"

/* ---- handles ---- */

static void destroy_another(struct scene *scene)
{
    scene_destroy(scene, (uint64_t)scene_accel_for(scene, INDEXED));
}

static void make_one_on_other_device(struct scene *scene)
{
    scene_accel_of_other_device(scene, AABBS);
}

/* ---- types ---- */

static void change_dst_type(struct scene *scene, uint32_t build, VkDeviceSize type)
{
    const VkDeviceSize size = scene_sizes(scene, build).accelerationStructureSize;
    const struct test_buffer buffer = scene_buffer(scene, size, ACCEL_USAGE);
    scene->infos[build].dstAccelerationStructure =
        scene_accel_in(scene, &buffer, 0, size, (VkAccelerationStructureTypeKHR)type);
}

/* ---- memory ---- */

static VkAccelerationStructureKHR make_unbound(struct scene *scene, uint32_t build,
                                               struct test_buffer *buffer)
{
    const VkDeviceSize size = scene_sizes(scene, build).accelerationStructureSize;
    *buffer = scene_create_buffer(scene, size, ACCEL_USAGE);
    return scene_accel_in(scene, buffer, 0, size, scene->infos[build].type);
}

static void leave_dst_unbound(struct scene *scene)
{
    struct test_buffer buffer;
    scene->infos[AABBS].dstAccelerationStructure = make_unbound(scene, AABBS, &buffer);
}

static void bind_dst_late(struct scene *scene)
{
    struct test_buffer buffer;
    scene->infos[AABBS].dstAccelerationStructure = make_unbound(scene, AABBS, &buffer);
    const struct test_memory memory =
        scene_allocate(scene, scene_buffer_memory_size(scene, &buffer));
    scene_bind(scene, &buffer, &memory, 0);
}

/* On the host it has been built, and lost its memory since. */
static void leave_update_src_unbound(struct scene *scene)
{
    struct test_buffer buffer;
    if (scene->command == COMMAND_HOST) {
        buffer = place_buffer(scene);
        place_src(scene, UPDATE, &buffer, 0);
        scene_destroy(scene, (uint64_t)buffer.memory);
        return;
    }
    scene->infos[UPDATE].srcAccelerationStructure = make_unbound(scene, UPDATE, &buffer);
}

static void leave_ignored_src_unbound(struct scene *scene)
{
    struct test_buffer buffer;
    scene->infos[INDEXED].srcAccelerationStructure = make_unbound(scene, INDEXED, &buffer);
}

/* ---- sizes ---- */

static void resize_dst(struct scene *scene, uint32_t build, VkDeviceSize less)
{
    const VkDeviceSize size = scene_sizes(scene, build).accelerationStructureSize;
    const struct test_buffer buffer = scene_buffer(scene, size + 256, ACCEL_USAGE);
    scene->infos[build].dstAccelerationStructure =
        scene_accel_in(scene, &buffer, 256, size - less, scene->infos[build].type);
}

enum { MANY_GEOMETRIES = 40 };

/* INDEXED, of so many geometries that each is alike; its dst and scratch as they were. */
static void give_many_geometries(struct scene *scene)
{
    static VkAccelerationStructureGeometryKHR geometries[MANY_GEOMETRIES];
    static VkAccelerationStructureBuildRangeInfoKHR ranges[MANY_GEOMETRIES];

    for (uint32_t i = 0; i < MANY_GEOMETRIES; i++) {
        geometries[i] = scene->geometries[INDEXED][0];
        ranges[i] = scene->ranges[INDEXED][0];
    }
    scene->infos[INDEXED].geometryCount = MANY_GEOMETRIES;
    scene->infos[INDEXED].pGeometries = geometries;
    scene->range_pointers[INDEXED] = ranges;
    const struct test_buffer scratch = scene_buffer(scene, 1 << 20, SCRATCH_USAGE);
    scene->infos[INDEXED].scratchData.deviceAddress = scene_address(scene, &scratch, 0);
}

static void give_many_geometries_and_room(struct scene *scene)
{
    const struct test_buffer buffer = scene_buffer(scene, 1 << 20, ACCEL_USAGE);
    give_many_geometries(scene);
    scene->infos[INDEXED].dstAccelerationStructure = scene_accel_in(
        scene, &buffer, 0, buffer.size, VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR);
}

/* A dst made for fewer primitives. */
static void grow_build(struct scene *scene)
{
    scene->ranges[AABBS][0].primitiveCount = 30;
    const VkDeviceSize size = scene_scratch_size(scene, AABBS);
    const struct test_buffer scratch = scene_buffer(scene, size, SCRATCH_USAGE);
    scene->infos[AABBS].scratchData.deviceAddress = scene_address(scene, &scratch, 0);
}

static void destroy_refit(struct scene *scene)
{
    scene_destroy(scene, (uint64_t)scene->infos[REFIT].dstAccelerationStructure);
}

static void free_refit(struct scene *scene)
{
    scene_destroy(scene, (uint64_t)scene->dst_buffers[REFIT].memory);
}

static const struct test_case cases[] = {
    CASE("dst_null", RULE(dst_is_a_valid_handle),
         EDITS(SET(infos[INDEXED].dstAccelerationStructure, 0)),
         .path = "pInfos[0].dstAccelerationStructure is VK_NULL_HANDLE."),
    CASE("dst_garbage", RULE(dst_is_a_valid_handle),
         EDITS(SET(infos[AABBS].dstAccelerationStructure, 0xdeadbeef))),
    CASE("dst_destroyed", RULE(dst_is_a_valid_handle),
         EDITS(DESTROY(infos[AABBS].dstAccelerationStructure)), .mutate_twin = destroy_another,
         .path = "pInfos[2].dstAccelerationStructure"),
    CASE("dst_is_a_buffer", RULE(dst_is_a_valid_handle),
         EDITS(COPY(infos[INDEXED].dstAccelerationStructure, vertices.handle)),
         .needs_null_driver = true),
    CASE("src_garbage", RULE(src_is_a_valid_handle),
         EDITS(SET(infos[UPDATE].srcAccelerationStructure, 0xdeadbeef)),
         .path = "pInfos[4].srcAccelerationStructure"),
    CASE("src_garbage_though_not_an_update", RULE(src_is_a_valid_handle),
         EDITS(SET(infos[TLAS].srcAccelerationStructure, 0xdeadbeef))),
    CASE("src_destroyed", RULE(src_is_a_valid_handle),
         EDITS(DESTROY(infos[UPDATE].srcAccelerationStructure)), .mutate_twin = destroy_another),
    CASE("src_destroyed_though_not_an_update", RULE(src_is_a_valid_handle),
         EDITS(
             MAKE_STRUCTURE_WITH(infos[INDEXED].srcAccelerationStructure, scene_accel_for, INDEXED),
             DESTROY(infos[INDEXED].srcAccelerationStructure)),
         TWIN_EDITS(MAKE_STRUCTURE_WITH(infos[INDEXED].srcAccelerationStructure, scene_accel_for,
                                        INDEXED))),
    CASE("dst_of_other_device", RULE(dst_and_src_share_the_device),
         EDITS(MAKE_STRUCTURE_WITH(infos[AABBS].dstAccelerationStructure,
                                   scene_accel_of_other_device, AABBS)),
         .mutate_twin = make_one_on_other_device, .path = "pInfos[2]"),
    CASE("src_of_other_device", RULE(dst_and_src_share_the_device),
         EDITS(MAKE_STRUCTURE_WITH(infos[UPDATE].srcAccelerationStructure,
                                   scene_accel_of_other_device, UPDATE)),
         .path = "pInfos[4]"),
    CASE("dst_and_src_of_other_device", RULE(dst_and_src_share_the_device),
         EDITS(MAKE_STRUCTURE_WITH(infos[UPDATE].srcAccelerationStructure,
                                   scene_accel_of_other_device, UPDATE),
               MAKE_STRUCTURE_WITH(infos[UPDATE].dstAccelerationStructure,
                                   scene_accel_of_other_device, UPDATE)),
         .count = 1, .path = " and srcAccelerationStructure VkAccelerationStructureKHR 0x"),
    CASE("src_of_other_device_though_not_an_update", RULE(dst_and_src_share_the_device),
         EDITS(MAKE_STRUCTURE_WITH(infos[INDEXED].srcAccelerationStructure,
                                   scene_accel_of_other_device, INDEXED))),
    CASE("tlas_into_blas", RULE(tlas_dst_is_top_level_or_generic),
         EITHER_CALL_FOR(change_dst_type, TLAS, VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR,
                         VK_ACCELERATION_STRUCTURE_TYPE_GENERIC_KHR),
         .path = "pInfos[3]"),
    CASE("blas_into_tlas", RULE(blas_dst_is_bottom_level_or_generic),
         EITHER_CALL_FOR(change_dst_type, UNINDEXED, VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR,
                         VK_ACCELERATION_STRUCTURE_TYPE_GENERIC_KHR),
         .path = "pInfos[1]"),

    SHARED(RULE(dst_is_backed_by_memory)),
    CASE("dst_unbound", .mutate = leave_dst_unbound, .mutate_twin = bind_dst_late,
         .path = "pInfos[2].dstAccelerationStructure"),
    CASE("dst_memory_freed", EDITS(DESTROY(dst_buffers[AABBS].memory))),
    CASE("dst_buffer_destroyed", EDITS(DESTROY(dst_buffers[AABBS].handle))),
    CASE("update_src_unbound", RULE(update_src_is_backed_by_memory),
         .mutate = leave_update_src_unbound, .mutate_twin = leave_ignored_src_unbound,
         .path = "pInfos[4].srcAccelerationStructure"),
    CASE("refit_destroyed_before_submission", RULE(dst_is_a_valid_handle),
         NAMES(RULE_src_is_a_valid_handle), SETUP(.level = "execution"), .commands = ON_DEVICE,
         .then = destroy_refit, .submits = true, .path = "pInfos[5]"),
    CASE("refit_freed_before_submission", RULE(dst_is_backed_by_memory),
         NAMES(RULE_update_src_is_backed_by_memory), SETUP(.level = "execution"),
         .commands = ON_DEVICE, .then = free_refit, .submits = true, .path = "pInfos[5]"),
    CASE("refit_destroyed", RULE(dst_is_a_valid_handle), NAMES(RULE_src_is_a_valid_handle),
         EDITS(DESTROY(infos[REFIT].dstAccelerationStructure)), .path = "pInfos[5]"),
    CASE("refit_memory_freed", RULE(dst_is_backed_by_memory),
         NAMES(RULE_update_src_is_backed_by_memory), EDITS(DESTROY(dst_buffers[REFIT].memory)),
         .path = "pInfos[5]"),

    SHARED(RULE(dst_is_large_enough)),
    CASE("dst_a_byte_too_small", EITHER_CALL_FOR(resize_dst, UNINDEXED, 1, 0),
         .path = "pInfos[1].dstAccelerationStructure"),
    CASE("tlas_a_byte_too_small", EDITS(CALL_FOR(resize_dst, TLAS, 1))),
    CASE("dst_made_for_fewer_geometries", .mutate = give_many_geometries,
         .mutate_twin = give_many_geometries_and_room),
    CASE("dst_made_for_fewer_primitives", .prepare = grow_build,
         TWIN_EDITS(
             MAKE_STRUCTURE_WITH(infos[AABBS].dstAccelerationStructure, scene_accel_for, AABBS))),
};

CASE_LIST(cases_build_state, cases);
