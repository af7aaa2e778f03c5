/* SPDX-License-Identifier: Apache-2.0 */
/* VK_NV_ray_tracing_linear_swept_spheres: both of its geometries. */
#include "case.h"
#include "placing.h"
#include "scene_extensions.h"

#define WILD 0x7000000000ull

static const struct setup with_spheres = {.enable = ENABLE_SPHERES};
static const struct setup with_spheres_and_future = {.enable = ENABLE_SPHERES | ENABLE_FUTURE};
static const struct setup with_packed_format = {.enable = ENABLE_SPHERES,
                                                .configure = offer_packed_format};
static const struct setup without_spheres = {.enable = ENABLE_SPHERES, .disable = DISABLE_SPHERES};
static const struct setup without_swept_spheres = {.enable = ENABLE_SPHERES,
                                                   .disable = DISABLE_LINEAR_SWEPT_SPHERES};

static void shrink_dst(struct scene *scene)
{
    scene->infos[SPHERES].dstAccelerationStructure =
        scene_accel_in(scene, &scene->dst_buffers[SPHERES], 0, place_size(scene, SPHERES) - 1,
                       VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR);
}

/* The structure begins where it can be read and ends where it can't. */
static void spheres_off_the_page(struct scene *scene)
{
    VkBaseOutStructure *cut = bytes_before_unreadable_page(sizeof(*cut));
    cut->sType = scene->spheres.sType;
    scene->geometries[SPHERES][0].pNext = cut;
}

static void spheres_without_usage(struct scene *scene)
{
    const struct test_buffer buffer = scene_buffer(scene, 4096, SCRATCH_USAGE);
    scene_add_spheres(scene);
    scene->spheres.vertexData.deviceAddress = scene_address(scene, &buffer, 0);
}

static const struct test_case cases[] = {
#define NAME(text) "spheres_" text
#define RULE_OF(statement) RULE_spheres_##statement
#define DATA spheres
#define ADD_ONE scene_add_spheres
#define PATH SPHERES_PATH
#define WITHOUT without_spheres
#include "cases_of_spheres.def"
#define NAME(text) "swept_spheres_" text
#define RULE_OF(statement) RULE_swept_spheres_##statement
#define DATA swept_spheres
#define ADD_ONE scene_add_swept_spheres
#define PATH SWEPT_PATH
#define WITHOUT without_swept_spheres
#include "cases_of_spheres.def"
    SHARED(.setup = &with_spheres),
    CASE("spheres_with_data_of_swept_spheres", RULE(spheres_have_their_stype),
         .mutate = scene_add_swept_spheres,
         EDITS(SET(geometries[SPHERES][0].geometryType, VK_GEOMETRY_TYPE_SPHERES_NV)),
         .mutate_twin = scene_add_spheres, .path = SPHERES_PATH "sType"),
    CASE("swept_spheres_with_data_of_spheres", RULE(swept_spheres_have_their_stype),
         .mutate = scene_add_spheres,
         EDITS(SET(geometries[SPHERES][0].geometryType, VK_GEOMETRY_TYPE_LINEAR_SWEPT_SPHERES_NV)),
         .mutate_twin = scene_add_swept_spheres, .path = SWEPT_PATH "sType"),
    CASE("spheres_data_off_the_page", RULE(geometry_chain_is_known), .prepare = scene_add_spheres,
         .mutate = spheres_off_the_page),
    CASE("spheres_in_freed_memory", RULE(input_buffer_is_bound), .commands = ON_COMMAND_BUFFERS,
         .mutate = scene_add_spheres,
         EDITS(MAKE_ADDRESS(spheres.radiusData.deviceAddress, scene_freed_address)),
         .mutate_twin = scene_add_spheres, .path = SPHERES_PATH "radiusData.deviceAddress"),
    /* 03673 lists members, and this is none of them. */
    CASE("spheres_buffer_without_usage", RULE(input_buffer_has_build_input_usage), .silent = true,
         .mutate = spheres_without_usage),
    /* What builds need is asked of the driver for these, too. */
    CASE("spheres_dst_too_small", RULE(dst_is_large_enough), .prepare = scene_add_spheres,
         EDITS(CALL(shrink_dst)), .path = "pInfos[6].dstAccelerationStructure"),
    CASE("swept_spheres_dst_too_small", RULE(dst_is_large_enough),
         .prepare = scene_add_swept_spheres, EDITS(CALL(shrink_dst)),
         .path = "pInfos[6].dstAccelerationStructure"),
    CASE("swept_spheres_indexing_mode_undefined", RULE(swept_spheres_indexing_mode_is_valid),
         .prepare = scene_add_swept_spheres,
         EITHER_SET(swept_spheres.indexingMode, 2, VK_RAY_TRACING_LSS_INDEXING_MODE_SUCCESSIVE_NV),
         .path = SWEPT_PATH "indexingMode"),
    CASE("swept_spheres_end_caps_mode_undefined", RULE(swept_spheres_end_caps_mode_is_valid),
         .prepare = scene_add_swept_spheres,
         EITHER_SET(swept_spheres.endCapsMode, 2,
                    VK_RAY_TRACING_LSS_PRIMITIVE_END_CAPS_MODE_NONE_NV),
         .path = SWEPT_PATH "endCapsMode"),
    CASE(
        "swept_spheres_modes_of_the_future",
        RULES(RULE_swept_spheres_indexing_mode_is_valid, RULE_swept_spheres_end_caps_mode_is_valid),
        .silent = true, .setup = &with_spheres_and_future, .mutate = scene_add_swept_spheres,
        EDITS(SET(swept_spheres.indexingMode, 2), SET(swept_spheres.endCapsMode, 2))),
    CASE("successive_swept_spheres_without_indices", RULE(successive_swept_spheres_have_index_data),
         .prepare = scene_add_swept_spheres,
         EDITS(SET(swept_spheres.indexingMode, VK_RAY_TRACING_LSS_INDEXING_MODE_SUCCESSIVE_NV),
               SET(swept_spheres.indexType, VK_INDEX_TYPE_NONE_KHR),
               SET(swept_spheres.indexData.deviceAddress, 0)),
         TWIN_EDITS(SET(swept_spheres.indexType, VK_INDEX_TYPE_NONE_KHR),
                    SET(swept_spheres.indexData.deviceAddress, 0)),
         .path = SWEPT_PATH "indexData"),
    CASE("successive_swept_spheres_with_null_indices", RULE(swept_spheres_index_address_is_given),
         NAMES(RULE_successive_swept_spheres_have_index_data), .prepare = scene_add_swept_spheres,
         PREPARE_EDITS(
             SET(swept_spheres.indexingMode, VK_RAY_TRACING_LSS_INDEXING_MODE_SUCCESSIVE_NV),
             SET(swept_spheres.indexData.deviceAddress, 0)),
         TWIN_EDITS(SET(ranges[SPHERES][0].primitiveCount, 0)), .path = SWEPT_PATH "indexData"),
};

CASE_LIST(cases_spheres, cases);
