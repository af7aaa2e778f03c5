/* SPDX-License-Identifier: Apache-2.0 */
/* Updates by the host whose data doesn't suit that of their source: other indices, and primitives
 * that wake or fall asleep. */
#include <math.h>
#include <string.h>

#include "case.h"

static const struct setup with_content = {.level = "content"};

#define ALLOW_UPDATE VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_UPDATE_BIT_KHR

/* Adds a build like `model` that allows updates, builds it as it is now, and makes it an update of
 * itself. Returns its index. */
static uint32_t update_of_itself(struct scene *scene, uint32_t model)
{
    const VkBuildAccelerationStructureFlagsKHR flags = scene->infos[model].flags;
    scene->infos[model].flags |= ALLOW_UPDATE;
    const uint32_t build = scene_add_build(scene, model);
    scene->infos[model].flags = flags;
    scene_build_before(scene, build, 1);
    scene->infos[build].mode = VK_BUILD_ACCELERATION_STRUCTURE_MODE_UPDATE_KHR;
    scene->infos[build].srcAccelerationStructure = scene->infos[build].dstAccelerationStructure;
    return build;
}

static float *vertex_at(struct scene *scene, uint32_t index)
{
    return (float *)(void *)scene->vertices.host + (size_t)3 * index;
}

static uint16_t *short_indices(struct scene *scene)
{
    return (uint16_t *)(void *)(scene->indices.host + SCENE_BUFFER_SIZE / 2);
}

static void update_with_the_same(struct scene *scene)
{
    update_of_itself(scene, UNINDEXED);
    vertex_at(scene, 0)[0] = vertex_at(scene, 3)[1] = 7;
}

/* Vertex 3 is in the second triangle of the first geometry, and in the first and second of the
 * other, vertex 5 in the first geometry alone. */
static void put_triangle_to_sleep(struct scene *scene)
{
    update_of_itself(scene, UNINDEXED);
    vertex_at(scene, 5)[0] = NAN;
}

static void wake_triangle(struct scene *scene)
{
    vertex_at(scene, 5)[0] = NAN;
    update_of_itself(scene, UNINDEXED);
    vertex_at(scene, 5)[0] = 1;
}

static void let_triangle_sleep(struct scene *scene)
{
    vertex_at(scene, 5)[0] = NAN;
    update_of_itself(scene, UNINDEXED);
    vertex_at(scene, 5)[0] = -NAN;
    vertex_at(scene, 4)[0] = NAN;
}

/* That is undefined, and not what these rules are about. */
static void lose_a_y(struct scene *scene)
{
    update_of_itself(scene, UNINDEXED);
    vertex_at(scene, 5)[1] = NAN;
}

/* No number of this format is NaN. */
static void use_a_format_without_nan(struct scene *scene)
{
    for (uint32_t i = 0; i < 2; i++) {
        scene->TRIANGLES(UNINDEXED, i).vertexFormat = VK_FORMAT_R16G16_SNORM;
        scene->TRIANGLES(UNINDEXED, i).vertexStride = 4;
        scene->TRIANGLES(UNINDEXED, i).vertexData.deviceAddress =
            scene_address(scene, &scene->vertices, SCENE_BUFFER_SIZE / 2);
    }
    update_of_itself(scene, UNINDEXED);
    memset(scene->vertices.host + SCENE_BUFFER_SIZE / 2, 0xff, 24);
}

static void change_an_index(struct scene *scene)
{
    update_of_itself(scene, UNINDEXED);
    short_indices(scene)[4] = 1;
}

static void change_an_index_behind_the_last(struct scene *scene)
{
    update_of_itself(scene, UNINDEXED);
    short_indices(scene)[6] = 1;
}

static float *box_at(struct scene *scene, size_t offset)
{
    return (float *)(void *)(scene->boxes.host + offset);
}

static void put_box_to_sleep(struct scene *scene)
{
    update_of_itself(scene, AABBS);
    box_at(scene, 1024 + 64)[0] = NAN;
}

static void wake_box(struct scene *scene)
{
    box_at(scene, 1024 + 64)[0] = NAN;
    update_of_itself(scene, AABBS);
    box_at(scene, 1024 + 64)[0] = 0;
}

static void let_box_sleep(struct scene *scene)
{
    box_at(scene, 1024 + 64)[0] = NAN;
    update_of_itself(scene, AABBS);
    box_at(scene, 0)[0] = -4;
}

static void set_reference(struct scene *scene, uint32_t index, VkAccelerationStructureKHR accel)
{
    VkAccelerationStructureInstanceKHR *instances = (void *)scene->instances.host;
    instances[index].accelerationStructureReference = scene_reference(scene, accel);
}

static VkAccelerationStructureKHR built_blas(struct scene *scene)
{
    const uint32_t build = scene_add_build(scene, INDEXED);
    scene->info_count--;
    scene_build_before(scene, build, 1);
    const VkAccelerationStructureKHR blas = scene->infos[build].dstAccelerationStructure;
    scene_give_objects(scene, build);
    return blas;
}

static void wake_instance(struct scene *scene)
{
    const VkAccelerationStructureKHR blas = built_blas(scene);
    update_of_itself(scene, TLAS);
    set_reference(scene, 1, blas);
}

static void put_instance_to_sleep(struct scene *scene)
{
    set_reference(scene, 1, built_blas(scene));
    update_of_itself(scene, TLAS);
    set_reference(scene, 1, VK_NULL_HANDLE);
}

static void exchange_instances(struct scene *scene)
{
    set_reference(scene, 1, built_blas(scene));
    update_of_itself(scene, TLAS);
    set_reference(scene, 1, built_blas(scene));
}

static const struct test_case cases[] = {
    SHARED(.commands = ON_HOST),
    CASE("triangle_put_to_sleep", RULES(RULE_active_primitives_stay_active), .setup = &with_content,
         .mutate = put_triangle_to_sleep, .mutate_twin = let_triangle_sleep,
         .path = "pInfos[6].pGeometries[0] makes primitive 1 inactive"),
    CASE("triangle_woken", RULES(RULE_inactive_primitives_stay_inactive), .setup = &with_content,
         .mutate = wake_triangle, .mutate_twin = let_triangle_sleep,
         .path = "pInfos[6].pGeometries[0] makes primitive 1 active"),
    CASE("triangle_without_y", RULES(RULE_active_primitives_stay_active), .silent = true,
         .setup = &with_content, .mutate = lose_a_y, .may_fail_on_cpu = true),
    CASE("triangles_that_cannot_sleep", RULES(RULE_active_primitives_stay_active), .silent = true,
         .setup = &with_content, .mutate = use_a_format_without_nan),
    CASE("index_changed", RULES(RULE_index_values_match_source), .setup = &with_content,
         .mutate = change_an_index, .mutate_twin = change_an_index_behind_the_last,
         .path = "pInfos[6].pGeometries[1] has other indices for primitive 1"),
    CASE("index_changed_below_level_content", RULES(RULE_index_values_match_source), .silent = true,
         .mutate = change_an_index),
    CASE("box_put_to_sleep", RULES(RULE_active_primitives_stay_active), .setup = &with_content,
         .mutate = put_box_to_sleep, .mutate_twin = let_box_sleep,
         .path = "pInfos[6].pGeometries[1] makes primitive 2 inactive"),
    CASE("box_woken", RULES(RULE_inactive_primitives_stay_inactive), .setup = &with_content,
         .mutate = wake_box, .mutate_twin = let_box_sleep,
         .path = "pInfos[6].pGeometries[1] makes primitive 2 active"),
    CASE("instance_put_to_sleep", RULES(RULE_active_primitives_stay_active), .setup = &with_content,
         .mutate = put_instance_to_sleep, .mutate_twin = exchange_instances,
         .path = "pInfos[6].pGeometries[0] makes primitive 1 inactive"),
    CASE("instance_woken", RULES(RULE_inactive_primitives_stay_inactive), .setup = &with_content,
         .mutate = wake_instance, .mutate_twin = exchange_instances,
         .path = "pInfos[6].pGeometries[0] makes primitive 1 active"),
    CASE("triangles_updated_with_the_same", RULES(RULE_index_values_match_source), .silent = true,
         .setup = &with_content, .mutate = update_with_the_same),
};

CASE_LIST(cases_content_update, cases);
