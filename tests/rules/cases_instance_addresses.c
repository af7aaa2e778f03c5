/* SPDX-License-Identifier: Apache-2.0 */
/* Instances that command buffers read: the addresses of structures in them, and those that lead to
 * them. */
#include <string.h>

#include "case.h"

static const struct setup with_content = {.level = "content"};

/* ---- of 3 instances ---- */

static VkAccelerationStructureInstanceKHR *instance_at(struct scene *scene, uint32_t index)
{
    return (VkAccelerationStructureInstanceKHR *)(void *)scene->instances.host + index;
}

static void refer(struct scene *scene, uint32_t index, uint64_t reference)
{
    instance_at(scene, index)->accelerationStructureReference = reference;
}

static void instance_of_no_address(struct scene *scene)
{
    refer(scene, 1, 0x123456780);
}

static void instance_of_a_destroyed_blas(struct scene *scene)
{
    const VkAccelerationStructureKHR blas = scene_accel_for(scene, INDEXED);
    refer(scene, 2, scene_reference(scene, blas));
    scene_destroy(scene, (uint64_t)blas);
}

static uint64_t built_before(struct scene *scene, uint32_t model)
{
    const uint32_t build = scene_add_build(scene, model);
    scene->info_count--;
    scene_build_before(scene, build, 1);
    return scene_reference(scene, scene->infos[build].dstAccelerationStructure);
}

static void instance_of_a_blas(struct scene *scene)
{
    refer(scene, 2, built_before(scene, INDEXED));
}

static void instance_of_a_tlas(struct scene *scene)
{
    refer(scene, 0, built_before(scene, TLAS));
}

static void instance_beside_a_blas(struct scene *scene)
{
    instance_of_a_blas(scene);
    refer(scene, 2, instance_at(scene, 2)->accelerationStructureReference + 256);
}

/* ---- pointers ---- */

/* To the instances in their places. */
static uint64_t *use_pointers(struct scene *scene)
{
    uint64_t *pointers = (void *)(scene->instances.host + SCENE_BUFFER_SIZE / 2);
    memset(pointers, 0, SCENE_BUFFER_SIZE / 2);
    for (uint32_t i = 0; i < 8; i++)
        pointers[i] =
            scene_address(scene, &scene->instances, i * sizeof(VkAccelerationStructureInstanceKHR));
    scene->INSTANCES(TLAS, 0).arrayOfPointers = VK_TRUE;
    scene->ranges[TLAS][0].primitiveOffset = SCENE_BUFFER_SIZE / 2;
    return pointers;
}

static void pointer_misaligned(struct scene *scene)
{
    use_pointers(scene)[1] = 8;
}

static void pointer_misaligned_behind_the_last(struct scene *scene)
{
    use_pointers(scene)[3] = 8;
}

/* To an instance of nothing. */
static void pointer_to_16_bytes(struct scene *scene)
{
    use_pointers(scene)[1] = scene_address(scene, &scene->instances, 3072 + 16);
}

#define LEADS_TO "pInfos[3].pGeometries[0].geometry.instances.data.deviceAddress leads to "

static const struct test_case cases[] = {
    SHARED(RULE(instance_references_are_zero_or_a_blas), .commands = ON_COMMAND_BUFFERS,
           .setup = &with_content),
    CASE("instance_of_no_address", .mutate = instance_of_no_address,
         TWIN_EDITS(CALL_FOR(refer, 3, 0x123456780)), .is_wild = true,
         .path = LEADS_TO "instance 1, whose accelerationStructureReference 0x123456780 is not"),
    CASE("instance_of_a_destroyed_blas", .mutate = instance_of_a_destroyed_blas,
         .mutate_twin = instance_of_a_blas, .is_wild = true, .path = LEADS_TO "instance 2,"),
    CASE("instance_beside_a_blas", .mutate = instance_beside_a_blas,
         .mutate_twin = instance_of_a_blas, .is_wild = true, .path = LEADS_TO "instance 2,"),
    CASE("instance_of_a_tlas", .mutate = instance_of_a_tlas, .mutate_twin = instance_of_a_blas,
         .is_wild = true, .path = "which is not a bottom-level acceleration structure"),
    CASE("pointer_to_instance_misaligned", RULE(instances_behind_pointers_are_aligned),
         .mutate = pointer_misaligned, .mutate_twin = pointer_misaligned_behind_the_last,
         .is_wild = true, .path = LEADS_TO "pointer 1, whose value 0x8"),
    CASE("pointer_to_instance_at_16_bytes", RULE(instances_behind_pointers_are_aligned),
         .silent = true, .mutate = pointer_to_16_bytes, .has_pointers = true),
};

CASE_LIST(cases_instance_addresses, cases);
