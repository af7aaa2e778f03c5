/* SPDX-License-Identifier: Apache-2.0 */
/* The data of builds of VK_NV_ray_tracing. */
#include <math.h>
#include <string.h>

#include "case.h"

static const struct setup with_content = {.level = "content"};

/* Vertex 5 is in the second triangle of the second geometry alone. */
enum { SECOND_BOXES = 1024, VERTEX_5 = 60 };

/* ---- boxes, transforms and indices ---- */

static void clear_transform(struct scene *scene, uint32_t offset)
{
    memset(scene->nv.transforms.host + offset, 0, 12 * sizeof(float));
}

/* ---- instances ---- */

static VkAccelerationStructureInstanceKHR *instance_at(struct scene *scene, uint32_t index)
{
    return (VkAccelerationStructureInstanceKHR *)(void *)scene->nv.instances.host + index;
}

static uint64_t reference_of(struct scene *scene, VkAccelerationStructureNV accel)
{
    uint64_t reference = 0;
    expect_success(scene->vk->GetAccelerationStructureHandleNV(scene->fixture->device, accel,
                                                               sizeof(reference), &reference),
                   "vkGetAccelerationStructureHandleNV");
    return reference;
}

/* The BLAS that the scene has until it builds instances. */
static uint64_t built_blas(struct scene *scene)
{
    const VkAccelerationStructureNV blas = scene_nv_accel(scene);
    scene_nv_build(scene, blas);
    return reference_of(scene, blas);
}

static void use_instances_of_a_blas(struct scene *scene)
{
    const uint64_t reference = built_blas(scene);
    scene_nv_use_instances(scene);
    instance_at(scene, 0)->accelerationStructureReference = reference;
    instance_at(scene, 2)->accelerationStructureReference = reference;
}

enum { KEPT = 5 }; /* an instance behind the last, for a reference that a mutation uses */

static void keep_a_destroyed_structure(struct scene *scene)
{
    const uint64_t reference = built_blas(scene);
    const VkAccelerationStructureNV destroyed = scene_nv_accel(scene);
    const uint64_t kept = reference_of(scene, destroyed);
    scene_destroy(scene, (uint64_t)destroyed);
    scene_nv_use_instances(scene);
    instance_at(scene, 0)->accelerationStructureReference = reference;
    instance_at(scene, KEPT)->accelerationStructureReference = kept;
}

static void copy_reference(struct scene *scene, uint32_t to, VkDeviceSize from)
{
    instance_at(scene, to)->accelerationStructureReference =
        instance_at(scene, (uint32_t)from)->accelerationStructureReference;
}

static void instance_of_a_tlas(struct scene *scene)
{
    instance_at(scene, 0)->accelerationStructureReference = reference_of(scene, scene->nv.dst);
}

static const struct test_case cases[] = {
    SHARED(.commands = ON_NV, .setup = &with_content),
    CASE("nv_box_upside_down", RULE(aabb_min_x_is_at_most_max_x), .prepare = scene_nv_use_boxes,
         EDITS(WRITE_FLOAT(nv.boxes, SECOND_BOXES + 32, 2)),
         TWIN_EDITS(WRITE_FLOAT(nv.boxes, SECOND_BOXES + 96, 2)),
         .path =
             "pInfo->pGeometries[1].geometry.aabbs.aabbData leads to primitive 1, whose minX 2 "),
    CASE("nv_transform_of_zeros", RULE(transform_matrix_is_invertible),
         EITHER_CALL(clear_transform, 0, SCENE_TRANSFORM_OFFSET),
         .path = "pInfo->pGeometries[0].geometry.triangles.transformData leads to a matrix"),
    /* The rule is about ranges, which this command hasn't. */
    CASE("nv_index_beyond_the_vertices", RULE(indices_are_within_max_vertex), .silent = true,
         EDITS(WRITE(nv.indices, uint32_t, 4 * sizeof(uint32_t), 6))),
    /* A driver may follow such handles. */
    CASE("nv_instance_of_unknown_handle", RULE(nv_instance_references_are_blas_handles),
         .prepare = use_instances_of_a_blas, EDITS(WRITE_REFERENCE(nv.instances, 2, 0x123456)),
         TWIN_EDITS(WRITE_REFERENCE(nv.instances, 3, 0x123456)), .spares_drivers = true,
         .path =
             "instanceData leads to instance 2, whose accelerationStructureReference 0x123456 was "
             "never returned by vkGetAccelerationStructureHandleNV"),
    CASE("nv_instance_of_a_tlas", RULE(nv_instance_references_are_blas_handles),
         .prepare = use_instances_of_a_blas, .mutate = instance_of_a_tlas,
         TWIN_EDITS(WRITE_REFERENCE(nv.instances, 0, 0)), .spares_drivers = true,
         .path = "instanceData leads to instance 0"),
    CASE("nv_instance_of_a_destroyed_structure",
         RULE(nv_instance_references_are_of_live_structures), .prepare = keep_a_destroyed_structure,
         EDITS(CALL_FOR(copy_reference, 2, KEPT)),
         TWIN_EDITS(WRITE_REFERENCE(nv.instances, 3, 0x123456)), .spares_drivers = true,
         .path = "instanceData leads to instance 2, whose accelerationStructureReference 0x"),
    CASE("nv_instance_with_undefined_flags", RULE(instance_flags_are_valid),
         .prepare = use_instances_of_a_blas, EDITS(WRITE_FLAGS(nv.instances, 1, 0x40)),
         TWIN_EDITS(WRITE_REFERENCE(nv.instances, 3, 0x123456)),
         .path = "instanceData leads to instance 1"),
    CASE("nv_flat_instance", RULE(transform_matrix_is_invertible),
         .prepare = use_instances_of_a_blas, EDITS(WRITE_MATRIX(nv.instances, 2, 0, 0, 0)),
         TWIN_EDITS(WRITE_MATRIX(nv.instances, 1, 0, 0, 0)),
         .path = "instanceData leads to instance 2"),
    CASE("nv_triangle_put_to_sleep", RULE(active_primitives_stay_active),
         .prepare = scene_nv_use_update, EDITS(WRITE_FLOAT(nv.vertices, VERTEX_5, NAN)),
         TWIN_EDITS(WRITE_FLOAT(nv.vertices, VERTEX_5 + 4, 7)),
         .path =
             "pInfo->pGeometries[1] makes primitive 1 inactive, but the primitive was active when"),
    CASE("nv_triangle_woken", RULE(inactive_primitives_stay_inactive),
         PREPARE_EDITS(WRITE_FLOAT(nv.vertices, VERTEX_5, NAN), CALL(scene_nv_use_update)),
         EDITS(WRITE_FLOAT(nv.vertices, VERTEX_5, 1)),
         TWIN_EDITS(WRITE_FLOAT(nv.vertices, VERTEX_5, NAN)),
         .path = "pInfo->pGeometries[1] makes primitive 1 active"),

    SHARED(RULE(active_primitives_stay_active), .commands = ON_NV, .setup = &with_content,
           .prepare = use_instances_of_a_blas, PREPARE_EDITS(CALL(scene_nv_use_update))),
    CASE("nv_box_put_to_sleep", .prepare = scene_nv_use_boxes,
         EDITS(WRITE_FLOAT(nv.boxes, SECOND_BOXES + 64, NAN)),
         TWIN_EDITS(WRITE_FLOAT(nv.boxes, SECOND_BOXES + 64, -4)),
         .path = "pInfo->pGeometries[1] makes primitive 2 inactive"),
    CASE("nv_instance_put_to_sleep", EDITS(WRITE_REFERENCE(nv.instances, 0, 0)),
         TWIN_EDITS(WRITE_MATRIX(nv.instances, 1, 0, 0, 0)),
         .path = "instanceData makes primitive 0 inactive"),
    CASE("nv_instance_woken", RULE(inactive_primitives_stay_inactive),
         EDITS(CALL_FOR(copy_reference, 1, 0)), TWIN_EDITS(WRITE_MATRIX(nv.instances, 1, 0, 0, 0)),
         .path = "instanceData makes primitive 1 active"),
};

CASE_LIST(cases_nv_contents, cases);
