/* SPDX-License-Identifier: Apache-2.0 */
/* The instances of host builds, and the structures that they refer to. */
#include <math.h>

#include "case.h"
#include "placing.h"
#include "scene_extensions.h"

static const struct setup with_content = {.level = "content"};
static const struct setup with_micromaps = {.enable = ENABLE_OPACITY_MICROMAP_EXT,
                                            .level = "content"};
static const struct setup without_micromap_feature = {
    .enable = ENABLE_OPACITY_MICROMAP_EXT, .disable = DISABLE_MICROMAP_EXT, .level = "content"};
static const struct setup with_group = {.enable = ENABLE_GROUP, .level = "content"};
static const struct setup with_addresses = {.enable = ENABLE_OPACITY_MICROMAP_KHR,
                                            .level = "content"};

/* ---- plain instances, of which 3 are built ---- */

static void instances_of_a_blas(struct scene *scene)
{
    const VkAccelerationStructureKHR blas = scene_built(scene, INDEXED);
    scene_refer(scene, 0, blas);
    scene_refer(scene, 2, blas);
}

static void instance_of_a_destroyed_blas(struct scene *scene)
{
    const VkAccelerationStructureKHR blas = scene_accel_for(scene, INDEXED);
    scene_refer(scene, 1, blas);
    scene_destroy(scene, (uint64_t)blas);
}

static void instance_of_another_device(struct scene *scene)
{
    scene_refer(scene, 1, scene_accel_of_other_device(scene, INDEXED));
}

/* What pointers that lead nowhere would lead to isn't known; those beside them are looked at. */
static void use_pointers_to_nowhere(struct scene *scene)
{
    const void **pointers = (void *)(scene->instances.host + SCENE_BUFFER_SIZE / 2);
    scene_use_instance_pointers(scene);
    pointers[0] = unreadable_page();
    pointers[1] = NULL;
}

/* ---- what they refer to ---- */

static void refer_to_blas_in(struct scene *scene, const struct test_buffer *buffer)
{
    scene_refer(
        scene, 1,
        scene_accel_in(scene, buffer, 0, place_size(scene, INDEXED), scene->infos[INDEXED].type));
}

static void instance_of_unbound_blas(struct scene *scene)
{
    const struct test_buffer buffer = scene_create_buffer(scene, PLACE_SIZE, PLACE_USAGE);
    refer_to_blas_in(scene, &buffer);
}

static void instance_of_blas_bound_late(struct scene *scene)
{
    struct test_buffer buffer = scene_create_buffer(scene, PLACE_SIZE, PLACE_USAGE);
    const uint32_t build = scene_reserve_build(scene, INDEXED);
    place_dst(scene, build, &buffer, 0);
    const struct test_memory memory =
        scene_allocate(scene, scene_buffer_memory_size(scene, &buffer));
    scene_bind(scene, &buffer, &memory, 0);
    scene_build_before(scene, build, 1);
    scene_refer(scene, 1, scene->infos[build].dstAccelerationStructure);
}

static void instance_in_device_memory(struct scene *scene)
{
    const struct test_buffer buffer = place_device_local_buffer(scene);
    refer_to_blas_in(scene, &buffer);
}

static void instance_of_two_instances(struct scene *scene)
{
    const struct test_buffer buffer = place_buffer_of_instances(scene, 3);
    refer_to_blas_in(scene, &buffer);
}

static void instance_by_address(struct scene *scene)
{
    scene_refer(scene, 1, place_accel_by_address(scene, INDEXED));
}

/* ---- and other builds of the call ---- */

static void refer_to_dst(struct scene *scene, uint32_t build)
{
    scene_refer(scene, 1, scene->infos[build].dstAccelerationStructure);
}

/* A dst, and a BLAS behind what that takes, or in it. */
static void place_instance(struct scene *scene, uint32_t build, VkDeviceSize place)
{
    const struct test_buffer buffer = place_buffer(scene);
    const uint32_t blas = scene_add_build(scene, INDEXED);
    const VkDeviceSize size = place_size(scene, build);
    scene->info_count--;
    place_dst(scene, build, &buffer, 0);
    place_dst(scene, blas, &buffer, place_offset(size, (enum place)place));
    scene_build_before(scene, blas, 1);
    scene_refer(scene, 1, scene->infos[blas].dstAccelerationStructure);
}

#define LEADS_TO(index)                                                                            \
    "pInfos[3].pGeometries[0].geometry.instances.data.hostAddress leads to instance " #index ", "

static const struct test_case cases[] = {
    SHARED(RULE(instance_micromap_flags_have_their_feature), .commands = ON_HOST,
           .setup = &with_content, .mutate = instances_of_a_blas,
           .mutate_twin = instances_of_a_blas, .path = LEADS_TO(0)),
    CASE("instance_with_undefined_flags", RULE(instance_flags_are_valid),
         EDITS(WRITE_FLAGS(instances, 2, 0x40)),
         TWIN_EDITS(WRITE_FLAGS(instances, 2, VK_GEOMETRY_INSTANCE_FORCE_OPAQUE_BIT_KHR)),
         .path = LEADS_TO(2) "whose flags 0x40 have bits 0x40"),
    CASE("instance_with_flags_of_micromaps", EDITS(WRITE_FLAGS(instances, 0, 0x10)), .count = 1),
    /* A micromap flag without the feature, and an undefined flag: two mistakes. */
    CASE("instance_with_flags_of_micromaps_and_undefined_flags",
         RULES(RULE_instance_flags_are_valid, RULE_instance_micromap_flags_have_their_feature),
         EDITS(WRITE_FLAGS(instances, 0, 0x50)), .count = 1),
    CASE("instance_disables_micromaps_without_feature", .setup = &without_micromap_feature,
         EDITS(WRITE_FLAGS(instances, 0, 0x20)), .count = 1),
    CASE("instance_with_flags_of_micromaps_without_feature", .setup = &without_micromap_feature,
         .twin_setup = &with_micromaps, EDITS(WRITE_FLAGS(instances, 0, 0x10)),
         TWIN_EDITS(WRITE_FLAGS(instances, 0, 0x10))),

    SHARED(RULE(instance_references_are_valid_handles), .commands = ON_HOST, .setup = &with_content,
           .mutate = instances_of_a_blas),
    CASE("instance_of_no_structure", EDITS(WRITE_REFERENCE(instances, 2, 0x123456)),
         .mutate_twin = instances_of_a_blas, TWIN_EDITS(WRITE_REFERENCE(instances, 3, 0x123456)),
         .path = LEADS_TO(2) "whose accelerationStructureReference 0x123456"),
    CASE("instance_of_no_structure_at_an_offset",
         EDITS(WRITE_REFERENCE(instances, 3, 0x123456), SET(ranges[TLAS][0].primitiveOffset, 128)),
         .mutate_twin = instances_of_a_blas, TWIN_EDITS(WRITE_REFERENCE(instances, 3, 0x123456)),
         .path = LEADS_TO(1)),
    CASE("instance_of_no_structure_but_none_built", .silent = true,
         EDITS(WRITE_REFERENCE(instances, 2, 0x123456), SET(ranges[TLAS][0].primitiveCount, 0))),
    CASE("instance_of_a_destroyed_blas", .mutate = instance_of_a_destroyed_blas,
         .mutate_twin = instances_of_a_blas, TWIN_EDITS(WRITE_REFERENCE(instances, 1, 0)),
         .path = LEADS_TO(1)),
    CASE("instance_of_another_device", .mutate = instance_of_another_device, .path = LEADS_TO(1)),
    CASE("pointer_to_instance_of_no_structure",
         EDITS(WRITE_REFERENCE(instances, 2, 0x123456), CALL(scene_use_instance_pointers)),
         .mutate_twin = instances_of_a_blas,
         TWIN_EDITS(WRITE_REFERENCE(instances, 3, 0x123456), CALL(scene_use_instance_pointers)),
         .path = LEADS_TO(2)),
    CASE("pointers_to_nowhere",
         EDITS(WRITE_REFERENCE(instances, 2, 0x123456), CALL(use_pointers_to_nowhere)),
         .mutate_twin = instances_of_a_blas,
         TWIN_EDITS(CALL(use_pointers_to_nowhere), WRITE_REFERENCE(instances, 2, 0)),
         .may_fail_on_cpu = true, .path = LEADS_TO(2)),
    CASE("instances_of_no_structure_in_device_memory", .silent = true,
         .commands = ON_COMMAND_BUFFERS, EDITS(WRITE_FLAGS(instances, 2, 0x40)),
         .is_for_the_call = true),
    CASE("flat_instance", RULE(transform_matrix_is_invertible),
         EDITS(WRITE_MATRIX(instances, 2, 1, 1, 0)), .mutate_twin = instances_of_a_blas,
         TWIN_EDITS(WRITE_MATRIX(instances, 2, 1, 1, 1e-38f)),
         .path = LEADS_TO(
             2) "whose transform is not invertible: its first three columns have determinant 0"),
    CASE("undefined_instance", RULE(transform_matrix_is_invertible),
         EDITS(WRITE_MATRIX(instances, 0, 2, 0, NAN)), .mutate_twin = instances_of_a_blas,
         TWIN_EDITS(WRITE_MATRIX(instances, 0, 2, 3, INFINITY)), .path = LEADS_TO(0)),
    CASE("flat_instance_of_nothing", RULE(transform_matrix_is_invertible), .silent = true,
         EDITS(WRITE_MATRIX(instances, 1, 1, 1, 0))),

    SHARED(.commands = ON_HOST, .setup = &with_content, .mutate_twin = instances_of_a_blas,
           .path = LEADS_TO(1)),
    CASE("instance_of_unbound_blas", RULE(instances_are_backed_by_memory),
         .mutate = instance_of_unbound_blas, .mutate_twin = instance_of_blas_bound_late,
         .is_wild = true),
    CASE("instance_in_device_memory", RULE(instances_are_host_visible),
         .mutate = instance_in_device_memory, .mutate_twin = instance_of_blas_bound_late),
    CASE("instance_of_two_instances", RULE(instances_have_one_memory_instance),
         .setup = &with_group, .mutate = instance_of_two_instances),
    CASE("instance_by_address", RULE(instances_were_created_with_a_buffer),
         .setup = &with_addresses, .mutate = instance_by_address),
    CASE("instance_of_a_dst", RULE(no_dst_is_an_instance_of_another_build),
         EDITS(CALL_WITH(refer_to_dst, AABBS)), .path = "pInfos[2].dstAccelerationStructure"),

    SHARED(RULE(dst_and_instances_of_other_builds_are_apart), .commands = ON_HOST,
           .setup = &with_content),
    CASE("instance_of_the_tlas_itself", RULE(no_dst_is_an_instance_of_another_build),
         .silent = true, EDITS(CALL_WITH(refer_to_dst, TLAS)), .may_fail_on_cpu = true,
         .is_for_the_call = true),
    CASE("instance_in_the_memory_of_a_dst", EITHER_CALL_FOR(place_instance, AABBS, WITHIN, BEHIND),
         .path = "pInfos[2].dstAccelerationStructure"),
    CASE("instance_in_the_memory_of_its_tlas", .silent = true,
         EDITS(CALL_FOR(place_instance, TLAS, WITHIN)), .needs_null_driver = true),
};

CASE_LIST(cases_instances, cases);
