/* SPDX-License-Identifier: Apache-2.0 */
/* Updates by the host whose data doesn't suit that of their source: other indices, and primitives
 * that wake or fall asleep. */
#include <math.h>
#include <string.h>

#include "case.h"
#include "scene_extensions.h"

static const struct setup with_content = {.level = "content"};

#define ALLOW_UPDATE VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_UPDATE_BIT_KHR

/* Adds a build like `model` that allows updates, builds it as it is now, and makes it an update of
 * itself. */
static void update_of_itself(struct scene *scene, uint32_t model)
{
    const VkBuildAccelerationStructureFlagsKHR flags = scene->infos[model].flags;
    scene->infos[model].flags |= ALLOW_UPDATE;
    const uint32_t build = scene_add_build(scene, model);
    scene->infos[model].flags = flags;
    scene_build_before(scene, build, 1);
    scene->infos[build].mode = VK_BUILD_ACCELERATION_STRUCTURE_MODE_UPDATE_KHR;
    scene->infos[build].srcAccelerationStructure = scene->infos[build].dstAccelerationStructure;
}

/* Vertex 3 is in the second triangle of the first geometry, and in the first and second of the
 * other, vertex 5 in the first geometry alone.
 * BOX_2 is the last box of the second geometry. */
enum { BOX_2 = 1024 + 64 };

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

static void wake_instance(struct scene *scene)
{
    const VkAccelerationStructureKHR blas = scene_built(scene, INDEXED);
    update_of_itself(scene, TLAS);
    scene_refer(scene, 1, blas);
}

static void put_instance_to_sleep(struct scene *scene)
{
    scene_refer(scene, 1, scene_built(scene, INDEXED));
    update_of_itself(scene, TLAS);
    scene_refer(scene, 1, VK_NULL_HANDLE);
}

static void exchange_instances(struct scene *scene)
{
    scene_refer(scene, 1, scene_built(scene, INDEXED));
    update_of_itself(scene, TLAS);
    scene_refer(scene, 1, scene_built(scene, INDEXED));
}

static const struct test_case cases[] = {
    SHARED(.commands = ON_HOST, .setup = &with_content,
           TWIN_EDITS(WRITE_FLOAT(vertices, 60, NAN), CALL_WITH(update_of_itself, UNINDEXED),
                      WRITE_FLOAT(vertices, 60, -NAN), WRITE_FLOAT(vertices, 48, NAN))),
    CASE("triangle_put_to_sleep", RULE(active_primitives_stay_active),
         EDITS(CALL_WITH(update_of_itself, UNINDEXED), WRITE_FLOAT(vertices, 60, NAN)),
         .path = "pInfos[6].pGeometries[0] makes primitive 1 inactive"),
    CASE("triangle_woken", RULE(inactive_primitives_stay_inactive),
         EDITS(WRITE_FLOAT(vertices, 60, NAN), CALL_WITH(update_of_itself, UNINDEXED),
               WRITE_FLOAT(vertices, 60, 1)),
         .path = "pInfos[6].pGeometries[0] makes primitive 1 active"),

    SHARED(RULE(active_primitives_stay_active), .silent = true, .commands = ON_HOST,
           .setup = &with_content),
    CASE("triangle_without_y",
         EDITS(CALL_WITH(update_of_itself, UNINDEXED), WRITE_FLOAT(vertices, 64, NAN)),
         .may_fail_on_cpu = true),
    CASE("triangles_that_cannot_sleep", .mutate = use_a_format_without_nan),

    SHARED(RULE(index_values_match_source), .commands = ON_HOST,
           EDITS(CALL_WITH(update_of_itself, UNINDEXED),
                 WRITE(indices, uint16_t, SCENE_BUFFER_SIZE / 2 + 8, 1))),
    CASE("index_changed", .setup = &with_content,
         TWIN_EDITS(CALL_WITH(update_of_itself, UNINDEXED),
                    WRITE(indices, uint16_t, SCENE_BUFFER_SIZE / 2 + 12, 1)),
         .path = "pInfos[6].pGeometries[1] gives primitive 1 other indices"),
    CASE("index_changed_below_level_content", .silent = true),

    SHARED(.commands = ON_HOST, .setup = &with_content),
    CASE("box_put_to_sleep", RULE(active_primitives_stay_active),
         EDITS(CALL_WITH(update_of_itself, AABBS), WRITE_FLOAT(boxes, BOX_2, NAN)),
         TWIN_EDITS(WRITE_FLOAT(boxes, BOX_2, NAN), CALL_WITH(update_of_itself, AABBS),
                    WRITE_FLOAT(boxes, 0, -4)),
         .path = "pInfos[6].pGeometries[1] makes primitive 2 inactive"),
    CASE("box_woken", RULE(inactive_primitives_stay_inactive),
         EDITS(WRITE_FLOAT(boxes, BOX_2, NAN), CALL_WITH(update_of_itself, AABBS),
               WRITE_FLOAT(boxes, BOX_2, 0)),
         TWIN_EDITS(WRITE_FLOAT(boxes, BOX_2, NAN), CALL_WITH(update_of_itself, AABBS),
                    WRITE_FLOAT(boxes, 0, -4)),
         .path = "pInfos[6].pGeometries[1] makes primitive 2 active"),
    CASE("instance_put_to_sleep", RULE(active_primitives_stay_active),
         .mutate = put_instance_to_sleep, .mutate_twin = exchange_instances,
         .path = "pInfos[6].pGeometries[0] makes primitive 1 inactive"),
    CASE("instance_woken", RULE(inactive_primitives_stay_inactive), .mutate = wake_instance,
         .mutate_twin = exchange_instances,
         .path = "pInfos[6].pGeometries[0] makes primitive 1 active"),
    CASE("triangles_updated_with_the_same", RULE(index_values_match_source), .silent = true,
         EDITS(CALL_WITH(update_of_itself, UNINDEXED), WRITE_FLOAT(vertices, 0, 7),
               WRITE_FLOAT(vertices, 40, 7))),
};

CASE_LIST(cases_content_update, cases);
