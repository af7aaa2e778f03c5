/* SPDX-License-Identifier: Apache-2.0 */
/* The instances of host builds, and the structures that they refer to. */
#include <math.h>
#include <string.h>

#include "case.h"
#include "placing.h"

static const struct setup with_content = {.level = "content"};
static const struct setup with_micromaps = {.enable = ENABLE_OPACITY_MICROMAP_EXT,
                                            .level = "content"};
static const struct setup without_micromap_feature = {
    .enable = ENABLE_OPACITY_MICROMAP_EXT, .disable = DISABLE_MICROMAP_EXT, .level = "content"};
static const struct setup with_group = {.enable = ENABLE_GROUP, .level = "content"};
static const struct setup with_addresses = {.enable = ENABLE_OPACITY_MICROMAP_KHR,
                                            .level = "content"};

/* ---- plain instances, of which 3 are built ---- */

static VkAccelerationStructureInstanceKHR *instance_at(struct scene *scene, uint32_t index)
{
    return (VkAccelerationStructureInstanceKHR *)(void *)scene->instances.host + index;
}

static void refer(struct scene *scene, uint32_t index, VkAccelerationStructureKHR accel)
{
    instance_at(scene, index)->accelerationStructureReference = scene_reference(scene, accel);
}

/* A BLAS that was built before the call. */
static VkAccelerationStructureKHR built_blas(struct scene *scene)
{
    const uint32_t build = scene_add_build(scene, INDEXED);
    scene->info_count--;
    scene_build_before(scene, build, 1);
    return scene->infos[build].dstAccelerationStructure;
}

static void instances_of_a_blas(struct scene *scene)
{
    const VkAccelerationStructureKHR blas = built_blas(scene);
    refer(scene, 0, blas);
    refer(scene, 2, blas);
}

/* Sets something of an instance, of which two refer to a BLAS and one to nothing. */
#define INSTANCES_OF_A_BLAS(name, index, assignment)                                               \
    static void name(struct scene *scene)                                                          \
    {                                                                                              \
        instances_of_a_blas(scene);                                                                \
        instance_at(scene, index)->assignment;                                                     \
    }

INSTANCES_OF_A_BLAS(instance_with_undefined_flags, 2, flags = 0x40)
INSTANCES_OF_A_BLAS(instance_forced_opaque, 2, flags = VK_GEOMETRY_INSTANCE_FORCE_OPAQUE_BIT_KHR)
INSTANCES_OF_A_BLAS(instance_with_flags_of_micromaps, 0, flags = 0x10)
INSTANCES_OF_A_BLAS(instance_with_two_wrong_flags, 0, flags = 0x50)
INSTANCES_OF_A_BLAS(instance_of_a_built_blas_disables_micromaps, 0, flags = 0x20)
INSTANCES_OF_A_BLAS(instance_of_no_structure, 2, accelerationStructureReference = 0x123456)
INSTANCES_OF_A_BLAS(instance_of_nothing, 1, accelerationStructureReference = 0)
INSTANCES_OF_A_BLAS(instance_behind_the_last, 3, accelerationStructureReference = 0x123456)
INSTANCES_OF_A_BLAS(flat_instance, 2, transform.matrix[1][1] = 0)
INSTANCES_OF_A_BLAS(small_instance, 2, transform.matrix[1][1] = 1e-38f)
INSTANCES_OF_A_BLAS(undefined_instance, 0, transform.matrix[2][0] = NAN)
INSTANCES_OF_A_BLAS(instance_moved_out_of_sight, 0, transform.matrix[2][3] = INFINITY)
INSTANCES_OF_A_BLAS(flat_instance_of_nothing, 1, transform.matrix[1][1] = 0)

static void instance_of_a_destroyed_blas(struct scene *scene)
{
    const VkAccelerationStructureKHR blas = scene_accel_for(scene, INDEXED);
    refer(scene, 1, blas);
    scene_destroy(scene, (uint64_t)blas);
}

static void instance_of_another_device(struct scene *scene)
{
    refer(scene, 1, scene_accel_of_other_device(scene, INDEXED));
}

/* The entries at their places, from an offset on. */
static void use_pointers(struct scene *scene)
{
    uint64_t *pointers = (void *)(scene->instances.host + SCENE_BUFFER_SIZE / 2);
    for (uint32_t i = 0; i < 8; i++)
        pointers[i] = scene_address(scene, &scene->instances, i * sizeof(*instance_at(scene, i)));
    scene->INSTANCES(TLAS, 0).arrayOfPointers = VK_TRUE;
    scene->ranges[TLAS][0].primitiveOffset = SCENE_BUFFER_SIZE / 2;
}

static void pointer_to_instance_of_no_structure(struct scene *scene)
{
    instance_of_no_structure(scene);
    use_pointers(scene);
}

static void pointer_to_instance_behind_the_last(struct scene *scene)
{
    instance_behind_the_last(scene);
    use_pointers(scene);
}

/* What pointers that lead nowhere would lead to isn't known; those beside them are looked at. */
static void pointers_to_nowhere(struct scene *scene)
{
    pointer_to_instance_of_no_structure(scene);
    const void **pointers = (void *)(scene->instances.host + SCENE_BUFFER_SIZE / 2);
    pointers[0] = unreadable_page();
    pointers[1] = NULL;
}

static void pointers_to_nowhere_alone(struct scene *scene)
{
    pointers_to_nowhere(scene);
    refer(scene, 2, VK_NULL_HANDLE);
}

/* ---- what they refer to ---- */

static void instance_of_unbound_blas(struct scene *scene)
{
    const struct test_buffer buffer = scene_create_buffer(scene, PLACE_SIZE, PLACE_USAGE);
    refer(
        scene, 1,
        scene_accel_in(scene, &buffer, 0, place_size(scene, INDEXED), scene->infos[INDEXED].type));
}

static void instance_of_blas_bound_late(struct scene *scene)
{
    struct test_buffer buffer = scene_create_buffer(scene, PLACE_SIZE, PLACE_USAGE);
    const uint32_t build = scene_add_build(scene, INDEXED);
    scene->info_count--;
    place_dst(scene, build, &buffer, 0);
    const struct test_memory memory =
        scene_allocate(scene, scene_buffer_memory_size(scene, &buffer));
    scene_bind(scene, &buffer, &memory, 0);
    scene_build_before(scene, build, 1);
    refer(scene, 1, scene->infos[build].dstAccelerationStructure);
}

static void instance_in_device_memory(struct scene *scene)
{
    const struct test_buffer buffer = place_device_local_buffer(scene);
    refer(
        scene, 1,
        scene_accel_in(scene, &buffer, 0, place_size(scene, INDEXED), scene->infos[INDEXED].type));
}

static void instance_of_two_instances(struct scene *scene)
{
    const struct test_buffer buffer = place_buffer_of_instances(scene, 3);
    refer(
        scene, 1,
        scene_accel_in(scene, &buffer, 0, place_size(scene, INDEXED), scene->infos[INDEXED].type));
}

static void instance_by_address(struct scene *scene)
{
    refer(scene, 1, place_accel_by_address(scene, INDEXED));
}

/* ---- and other builds of the call ---- */

static void instance_of_a_dst(struct scene *scene)
{
    refer(scene, 1, scene->infos[AABBS].dstAccelerationStructure);
}

static void instance_of_the_tlas_itself(struct scene *scene)
{
    refer(scene, 1, scene->infos[TLAS].dstAccelerationStructure);
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
    refer(scene, 1, scene->infos[blas].dstAccelerationStructure);
}

static void instance_in_the_memory_of_a_dst(struct scene *scene)
{
    place_instance(scene, AABBS, WITHIN);
}

static void instance_in_the_memory_of_its_tlas(struct scene *scene)
{
    place_instance(scene, TLAS, WITHIN);
}

#define LEADS_TO(index)                                                                            \
    "pInfos[3].pGeometries[0].geometry.instances.data.hostAddress leads to instance " #index ", "

static const struct test_case cases[] = {
    SHARED(.commands = ON_HOST, .setup = &with_content, .mutate_twin = instances_of_a_blas),
    CASE("instance_with_undefined_flags", RULES(RULE_instance_flags_are_valid),
         .mutate = instance_with_undefined_flags, .mutate_twin = instance_forced_opaque,
         .path = LEADS_TO(2) "whose flags 0x40 have bits 0x40"),
    CASE("instance_with_flags_of_micromaps", RULES(RULE_instance_micromap_flags_have_their_feature),
         .mutate = instance_with_flags_of_micromaps, .count = 1, .path = LEADS_TO(0)),
    /* A micromap flag without the feature, and an undefined flag: two mistakes. */
    CASE("instance_with_flags_of_micromaps_and_undefined_flags",
         RULES(RULE_instance_flags_are_valid, RULE_instance_micromap_flags_have_their_feature),
         .mutate = instance_with_two_wrong_flags, .count = 1, .path = LEADS_TO(0)),
    CASE("instance_disables_micromaps_without_feature",
         RULES(RULE_instance_micromap_flags_have_their_feature), .setup = &without_micromap_feature,
         .mutate = instance_of_a_built_blas_disables_micromaps, .count = 1, .path = LEADS_TO(0)),
    CASE("instance_with_flags_of_micromaps_without_feature",
         RULES(RULE_instance_micromap_flags_have_their_feature), .setup = &without_micromap_feature,
         .twin_setup = &with_micromaps, .mutate = instance_with_flags_of_micromaps,
         .mutate_twin = instance_with_flags_of_micromaps, .path = LEADS_TO(0)),

    SHARED(.commands = ON_HOST, .setup = &with_content,
           RULES(RULE_instance_references_are_valid_handles)),
    CASE("instance_of_no_structure", .mutate = instance_of_no_structure,
         .mutate_twin = instance_behind_the_last,
         .path = LEADS_TO(2) "whose accelerationStructureReference 0x123456"),
    CASE("instance_of_no_structure_at_an_offset", .mutate = instance_behind_the_last,
         .edits = EDITS(SET(ranges[TLAS][0].primitiveOffset, 128)),
         .mutate_twin = instance_behind_the_last, .path = LEADS_TO(1)),
    CASE("instance_of_no_structure_but_none_built", .silent = true,
         .mutate = instance_of_no_structure,
         .edits = EDITS(SET(ranges[TLAS][0].primitiveCount, 0))),
    CASE("instance_of_a_destroyed_blas", .mutate = instance_of_a_destroyed_blas,
         .mutate_twin = instance_of_nothing, .path = LEADS_TO(1)),
    CASE("instance_of_another_device", .mutate = instance_of_another_device, .path = LEADS_TO(1)),
    CASE("pointer_to_instance_of_no_structure", .mutate = pointer_to_instance_of_no_structure,
         .mutate_twin = pointer_to_instance_behind_the_last, .path = LEADS_TO(2)),
    CASE("pointers_to_nowhere", .mutate = pointers_to_nowhere,
         .mutate_twin = pointers_to_nowhere_alone, .may_fail_on_cpu = true, .path = LEADS_TO(2)),
    CASE("instances_of_no_structure_in_device_memory", .silent = true,
         .commands = ON_COMMAND_BUFFERS, .mutate = instance_with_undefined_flags,
         .is_for_the_call = true),

    SHARED(.commands = ON_HOST, .setup = &with_content, RULES(RULE_transform_matrix_is_invertible)),
    CASE("flat_instance", .mutate = flat_instance, .mutate_twin = small_instance,
         .path = LEADS_TO(2) "whose first three columns of transform have determinant 0"),
    CASE("undefined_instance", .mutate = undefined_instance,
         .mutate_twin = instance_moved_out_of_sight, .path = LEADS_TO(0)),
    CASE("flat_instance_of_nothing", .silent = true, .mutate = flat_instance_of_nothing),

    SHARED(.commands = ON_HOST, .setup = &with_content, .mutate_twin = instances_of_a_blas),
    CASE("instance_of_unbound_blas", RULES(RULE_instances_are_backed_by_memory),
         .mutate = instance_of_unbound_blas, .mutate_twin = instance_of_blas_bound_late,
         .is_wild = true, .path = LEADS_TO(1)),
    CASE("instance_in_device_memory", RULES(RULE_instances_are_host_visible),
         .mutate = instance_in_device_memory, .mutate_twin = instance_of_blas_bound_late,
         .path = LEADS_TO(1)),
    CASE("instance_of_two_instances", RULES(RULE_instances_have_one_memory_instance),
         .setup = &with_group, .mutate = instance_of_two_instances, .path = LEADS_TO(1)),
    CASE("instance_by_address", RULES(RULE_instances_were_created_with_a_buffer),
         .setup = &with_addresses, .mutate = instance_by_address, .path = LEADS_TO(1)),

    CASE("instance_of_a_dst", RULES(RULE_no_dst_is_an_instance_of_another_build),
         .mutate = instance_of_a_dst, .path = "pInfos[2].dstAccelerationStructure"),

    SHARED(.commands = ON_HOST, .setup = &with_content),
    CASE("instance_of_the_tlas_itself", RULES(RULE_no_dst_is_an_instance_of_another_build),
         .silent = true, .mutate = instance_of_the_tlas_itself, .is_for_the_call = true,
         .may_fail_on_cpu = true),
    CASE("instance_in_the_memory_of_a_dst", RULES(RULE_dst_and_instances_of_other_builds_are_apart),
         .mutate = instance_in_the_memory_of_a_dst,
         .twin_edits = EDITS(CALL_FOR(place_instance, AABBS, BEHIND)),
         .path = "pInfos[2].dstAccelerationStructure"),
    CASE("instance_in_the_memory_of_its_tlas",
         RULES(RULE_dst_and_instances_of_other_builds_are_apart), .silent = true,
         .mutate = instance_in_the_memory_of_its_tlas, .needs_null_driver = true),
};

CASE_LIST(cases_instances, cases);
