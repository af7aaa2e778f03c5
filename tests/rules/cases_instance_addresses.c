/* SPDX-License-Identifier: Apache-2.0 */
/* Instances that command buffers read: the addresses of structures in them, and those that lead to
 * them. */
#include "case.h"
#include "scene_extensions.h"

static const struct setup with_content = {.level = "content"};

/* ---- of 3 instances ---- */

static void instance_of_a_destroyed_blas(struct scene *scene)
{
    const VkAccelerationStructureKHR blas = scene_accel_for(scene, INDEXED);
    scene_refer(scene, 2, blas);
    scene_destroy(scene, (uint64_t)blas);
}

static void instance_of_a_blas(struct scene *scene)
{
    scene_refer(scene, 2, scene_built(scene, INDEXED));
}

static void instance_of_a_tlas(struct scene *scene)
{
    scene_refer(scene, 0, scene_built(scene, TLAS));
}

static void instance_beside_a_blas(struct scene *scene)
{
    instance_of_a_blas(scene);
    scene_instance(scene, 2)->accelerationStructureReference += 256;
}

/* ---- pointers ---- */

/* To an instance of nothing. */
static void pointer_to_16_bytes(struct scene *scene)
{
    uint64_t *pointers = (void *)(scene->instances.host + SCENE_BUFFER_SIZE / 2);
    scene_use_instance_pointers(scene);
    pointers[1] = scene_address(scene, &scene->instances, 3072 + 16);
}

#define LEADS_TO "pInfos[3].pGeometries[0].geometry.instances.data.deviceAddress leads to "

static const struct test_case cases[] = {
    SHARED(RULE(instance_references_are_zero_or_a_blas), .commands = ON_COMMAND_BUFFERS,
           .setup = &with_content),
    CASE("instance_of_no_address", EDITS(WRITE_REFERENCE(instances, 1, 0x123456780)),
         TWIN_EDITS(WRITE_REFERENCE(instances, 3, 0x123456780)), .is_wild = true,
         .path = LEADS_TO "instance 1, whose accelerationStructureReference 0x123456780 is not"),
    CASE("instance_of_a_destroyed_blas", .mutate = instance_of_a_destroyed_blas,
         .mutate_twin = instance_of_a_blas, .is_wild = true, .path = LEADS_TO "instance 2,"),
    CASE("instance_beside_a_blas", .mutate = instance_beside_a_blas,
         .mutate_twin = instance_of_a_blas, .is_wild = true, .path = LEADS_TO "instance 2,"),
    CASE("instance_of_a_tlas", .mutate = instance_of_a_tlas, .mutate_twin = instance_of_a_blas,
         .is_wild = true, .path = "which is not a bottom-level acceleration structure"),
    CASE("pointer_to_instance_misaligned", RULE(instances_behind_pointers_are_aligned),
         .mutate = scene_use_instance_pointers,
         EDITS(WRITE(instances, uint64_t, SCENE_BUFFER_SIZE / 2 + 8, 8)),
         .mutate_twin = scene_use_instance_pointers,
         TWIN_EDITS(WRITE(instances, uint64_t, SCENE_BUFFER_SIZE / 2 + 24, 8)), .is_wild = true,
         .path = LEADS_TO "pointer 1, whose value 0x8"),
    CASE("pointer_to_instance_at_16_bytes", RULE(instances_behind_pointers_are_aligned),
         .silent = true, .mutate = pointer_to_16_bytes, .has_pointers = true),
};

CASE_LIST(cases_instance_addresses, cases);
