/* SPDX-License-Identifier: Apache-2.0 */
/* The data of builds of VK_NV_ray_tracing. */
#include <math.h>
#include <string.h>

#include "case.h"

static const struct setup with_content = {.level = "content"};

static float *float_at(const struct test_buffer *buffer, size_t offset)
{
    return (float *)(void *)(buffer->host + offset);
}

/* ---- boxes, transforms and indices ---- */

static void box_upside_down(struct scene *scene)
{
    float_at(&scene->nv.boxes, 1024 + 32)[0] = 2;
}

static void box_behind_the_last(struct scene *scene)
{
    float_at(&scene->nv.boxes, 1024 + 96)[0] = 2;
}

static void zero_transform(struct scene *scene)
{
    memset(scene->nv.transforms.host, 0, 12 * sizeof(float));
}

static void zero_transform_elsewhere(struct scene *scene)
{
    memset(scene->nv.transforms.host + SCENE_TRANSFORM_OFFSET, 0, 12 * sizeof(float));
}

static void index_beyond_the_vertices(struct scene *scene)
{
    ((uint32_t *)(void *)scene->nv.indices.host)[4] = 6;
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

static void instance_of_unknown_handle(struct scene *scene)
{
    instance_at(scene, 2)->accelerationStructureReference = 0x123456;
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

static void instance_of_a_destroyed_structure(struct scene *scene)
{
    instance_at(scene, 2)->accelerationStructureReference =
        instance_at(scene, KEPT)->accelerationStructureReference;
}

static void instance_behind_the_last(struct scene *scene)
{
    instance_at(scene, 3)->accelerationStructureReference = 0x123456;
}

static void instance_of_a_tlas(struct scene *scene)
{
    instance_at(scene, 0)->accelerationStructureReference = reference_of(scene, scene->nv.dst);
}

static void instance_of_nothing(struct scene *scene)
{
    instance_at(scene, 0)->accelerationStructureReference = 0;
}

static void instance_with_undefined_flags(struct scene *scene)
{
    instance_at(scene, 1)->flags = 0x40;
}

static void flat_instance(struct scene *scene)
{
    instance_at(scene, 2)->transform.matrix[0][0] = 0;
}

static void flat_instance_of_nothing(struct scene *scene)
{
    instance_at(scene, 1)->transform.matrix[0][0] = 0;
}

/* ---- updates ---- */

static void update_boxes(struct scene *scene)
{
    scene_nv_use_boxes(scene);
    scene_nv_use_update(scene);
}

static void update_instances(struct scene *scene)
{
    use_instances_of_a_blas(scene);
    scene_nv_use_update(scene);
}

/* Vertex 5 is in the second triangle of the second geometry alone. */
static void sleep_at_first(struct scene *scene)
{
    float_at(&scene->nv.vertices, 60)[0] = NAN;
    scene_nv_use_update(scene);
}

static void wake_triangle(struct scene *scene)
{
    float_at(&scene->nv.vertices, 60)[0] = 1;
}

static void put_triangle_to_sleep(struct scene *scene)
{
    float_at(&scene->nv.vertices, 60)[0] = NAN;
}

static void move_triangle(struct scene *scene)
{
    float_at(&scene->nv.vertices, 60)[1] = 7;
}

static void put_box_to_sleep(struct scene *scene)
{
    float_at(&scene->nv.boxes, 1024 + 64)[0] = NAN;
}

static void move_box(struct scene *scene)
{
    float_at(&scene->nv.boxes, 1024 + 64)[0] = -4;
}

static void wake_instance(struct scene *scene)
{
    instance_at(scene, 1)->accelerationStructureReference =
        instance_at(scene, 0)->accelerationStructureReference;
}

#define DATA_CASE(name_, rule_, prepare_, mutate_, mutate_twin_, path_)                            \
    {                                                                                              \
        .name = (name_), RULES(RULE_##rule_), .setup = &with_content, .prepare = (prepare_),       \
        .mutate = (mutate_), .mutate_twin = (mutate_twin_), .commands = ON_NV, .path = (path_)     \
    }
#define SILENT_CASE(name_, rule_, prepare_, mutate_)                                               \
    {                                                                                              \
        .name = (name_), RULES(RULE_##rule_), .silent = true, .setup = &with_content,              \
        .prepare = (prepare_), .mutate = (mutate_), .commands = ON_NV                              \
    }

static const struct test_case cases[] = {
    DATA_CASE("nv_box_upside_down", aabb_min_x_is_at_most_max_x, scene_nv_use_boxes,
              box_upside_down, box_behind_the_last,
              "pInfo->pGeometries[1].geometry.aabbs.aabbData leads to primitive 1, whose minX 2 "),
    DATA_CASE("nv_transform_of_zeros", transform_matrix_is_invertible, NULL, zero_transform,
              zero_transform_elsewhere,
              "pInfo->pGeometries[0].geometry.triangles.transformData leads to a matrix"),
    /* The rule is about ranges, which this command hasn't. */
    SILENT_CASE("nv_index_beyond_the_vertices", indices_are_within_max_vertex, NULL,
                index_beyond_the_vertices),

    /* A driver may follow such handles. */
    CASE("nv_instance_of_unknown_handle", RULES(RULE_nv_instance_references_are_blas_handles),
         .commands = ON_NV, .setup = &with_content, .prepare = use_instances_of_a_blas,
         .mutate = instance_of_unknown_handle, .mutate_twin = instance_behind_the_last,
         .spares_drivers = true,
         .path =
             "instanceData leads to instance 2, whose accelerationStructureReference 0x123456 was "
             "never returned by vkGetAccelerationStructureHandleNV"),
    CASE("nv_instance_of_a_tlas", RULES(RULE_nv_instance_references_are_blas_handles),
         .commands = ON_NV, .setup = &with_content, .prepare = use_instances_of_a_blas,
         .mutate = instance_of_a_tlas, .mutate_twin = instance_of_nothing, .spares_drivers = true,
         .path = "instanceData leads to instance 0"),
    CASE("nv_instance_of_a_destroyed_structure",
         RULES(RULE_nv_instance_references_are_of_live_structures), .commands = ON_NV,
         .setup = &with_content, .prepare = keep_a_destroyed_structure,
         .mutate = instance_of_a_destroyed_structure, .mutate_twin = instance_behind_the_last,
         .spares_drivers = true,
         .path = "instanceData leads to instance 2, whose accelerationStructureReference 0x"),
    DATA_CASE("nv_instance_with_undefined_flags", instance_flags_are_valid, use_instances_of_a_blas,
              instance_with_undefined_flags, instance_behind_the_last,
              "instanceData leads to instance 1"),
    DATA_CASE("nv_flat_instance", transform_matrix_is_invertible, use_instances_of_a_blas,
              flat_instance, flat_instance_of_nothing, "instanceData leads to instance 2"),

    DATA_CASE("nv_triangle_put_to_sleep", active_primitives_stay_active, scene_nv_use_update,
              put_triangle_to_sleep, move_triangle,
              "pInfo->pGeometries[1] makes primitive 1 inactive, which was active when"),
    DATA_CASE("nv_triangle_woken", inactive_primitives_stay_inactive, sleep_at_first, wake_triangle,
              put_triangle_to_sleep, "pInfo->pGeometries[1] makes primitive 1 active"),
    DATA_CASE("nv_box_put_to_sleep", active_primitives_stay_active, update_boxes, put_box_to_sleep,
              move_box, "pInfo->pGeometries[1] makes primitive 2 inactive"),
    DATA_CASE("nv_instance_put_to_sleep", active_primitives_stay_active, update_instances,
              instance_of_nothing, flat_instance_of_nothing,
              "instanceData makes primitive 0 inactive"),
    DATA_CASE("nv_instance_woken", inactive_primitives_stay_inactive, update_instances,
              wake_instance, flat_instance_of_nothing, "instanceData makes primitive 1 active"),
};

CASE_LIST(cases_nv_contents, cases);
