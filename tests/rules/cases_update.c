/* SPDX-License-Identifier: Apache-2.0 */
/* Updates that differ from what their source was built with earlier in the same command buffer, or
 * by the host. */
#include "case.h"
#include "placing.h"

#define ALLOW_UPDATE VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_UPDATE_BIT_KHR
#define T_UPDATE TRIANGLES(UPDATE, 0)

/* A build like INDEXED that is not part of the call; to be changed, then built before it. */
static uint32_t begin_source(struct scene *scene)
{
    const uint32_t build = scene_reserve_build(scene, INDEXED);
    return build;
}

/* Builds it and makes its dst the source of `update`. */
static void build_source(struct scene *scene, uint32_t build, uint32_t update)
{
    scene_give_objects(scene, build);
    scene_build_before(scene, build, 1);
    scene->infos[update].srcAccelerationStructure = scene->infos[build].dstAccelerationStructure;
}

static void build_source_with(struct scene *scene, VkBuildAccelerationStructureFlagsKHR flags)
{
    const uint32_t build = begin_source(scene);
    scene->infos[build].flags = flags;
    build_source(scene, build, UPDATE);
}

/* What counts is the last build of the source, which has room for either. */
static void build_source_twice(struct scene *scene)
{
    const struct test_buffer buffer = place_buffer(scene);
    const VkAccelerationStructureKHR source = scene_accel_in(
        scene, &buffer, 0, PLACE_SIZE, VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR);

    for (uint32_t i = 0; i < 2; i++) {
        const uint32_t build = begin_source(scene);
        if (i == 0) {
            scene->infos[build].flags = 0;
            scene->geometries[build][0].geometry.triangles.maxVertex = 20;
            scene_give_objects(scene, build);
        }
        scene->infos[build].dstAccelerationStructure = source;
        scene_build_before(scene, build, 1);
    }
    scene->infos[UPDATE].srcAccelerationStructure = source;
}

static void build_source_of_two_geometries(struct scene *scene)
{
    const uint32_t build = begin_source(scene);
    scene->geometries[build][1] = scene->geometries[build][0];
    scene->ranges[build][1] = scene->ranges[build][0];
    scene->infos[build].geometryCount = 2;
    build_source(scene, build, UPDATE);
}

/* Into a structure of its own, of so many of the bytes that the build of its source needed. */
static void update_into(struct scene *scene, VkDeviceSize divisor)
{
    const struct test_buffer buffer = place_buffer(scene);
    const uint32_t build = begin_source(scene);
    build_source(scene, build, UPDATE);
    scene->infos[UPDATE].dstAccelerationStructure =
        scene_accel_in(scene, &buffer, 0, place_size(scene, UPDATE) / divisor,
                       VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR);
}

static void build_source_without_transform(struct scene *scene)
{
    const uint32_t build = begin_source(scene);
    scene->geometries[build][0].geometry.triangles.transformData.deviceAddress = 0;
    build_source(scene, build, UPDATE);
}

/* A source that both a bottom and a top level can be built into. */
static void update_tlas_from_blas(struct scene *scene)
{
    const struct test_buffer buffer = place_buffer(scene);
    const VkAccelerationStructureKHR accel =
        scene_accel_in(scene, &buffer, 0, PLACE_SIZE, VK_ACCELERATION_STRUCTURE_TYPE_GENERIC_KHR);

    scene->infos[INDEXED].dstAccelerationStructure = accel;
    scene_build_before(scene, INDEXED, 1);
    scene->infos[INDEXED].dstAccelerationStructure = scene_accel_for(scene, INDEXED);
    scene->infos[TLAS].mode = VK_BUILD_ACCELERATION_STRUCTURE_MODE_UPDATE_KHR;
    scene->infos[TLAS].srcAccelerationStructure = accel;
    scene->infos[TLAS].dstAccelerationStructure = accel;
    scene->ranges[TLAS][0].primitiveCount = scene->ranges[INDEXED][0].primitiveCount;
}

/* A compacting copy carries what it copied. */
static void update_compacted_copy(struct scene *scene)
{
    const VkAccelerationStructureKHR copy = scene_accel_for(scene, UPDATE);
    expect_success(scene_copy(scene, scene->infos[UPDATE].srcAccelerationStructure, copy,
                              VK_COPY_ACCELERATION_STRUCTURE_MODE_COMPACT_KHR),
                   "vkCopyAccelerationStructureKHR");
    scene->infos[UPDATE].srcAccelerationStructure = copy;
}

/* A rule of level state that takes more to decide here. */

static const struct test_case cases[] = {
    CASE("source_without_allow_update", RULE(update_source_was_built_with_allow_update),
         EITHER_CALL(build_source_with, 0, ALLOW_UPDATE),
         .path = "pInfos[4].srcAccelerationStructure"),
    CASE("source_built_again",
         RULES(RULE_update_source_was_built_with_allow_update, RULE_max_vertex_matches_source),
         .silent = true, .mutate = build_source_twice),
    CASE("source_of_two_geometries", RULE(geometry_count_matches_source),
         .mutate = build_source_of_two_geometries, .path = "pInfos[4].geometryCount"),
    CASE("flags_of_update", RULE(build_flags_match_source),
         EDITS(ADD(infos[UPDATE].flags, VK_BUILD_ACCELERATION_STRUCTURE_PREFER_FAST_TRACE_BIT_KHR),
               CALL_WITH(scene_give_objects, UPDATE)),
         .path = "pInfos[4].flags"),
    CASE("type_of_update", RULES(RULE_build_type_matches_source),
         NAMES(RULE_geometry_type_matches_source), .mutate = update_tlas_from_blas,
         .path = "pInfos[3]"),
    CASE("geometry_type_of_update", RULE(geometry_type_matches_source),
         EDITS(COPY(geometries[UPDATE][0], geometries[AABBS][0]),
               SET(geometries[UPDATE][0].flags, 0), CALL_WITH(scene_give_objects, UPDATE),
               SET(ranges[UPDATE][0].primitiveCount, 2)),
         .keep_arrays = true, .path = "pInfos[4].pGeometries[0].geometryType"),
    CASE("geometry_flags_of_update", RULE(geometry_flags_match_source),
         EDITS(SET(geometries[UPDATE][0].flags, VK_GEOMETRY_OPAQUE_BIT_KHR)),
         .path = "pInfos[4].pGeometries[0].flags"),
    CASE("vertex_format_of_update", RULE(vertex_format_matches_source),
         EDITS(SET(T_UPDATE.vertexFormat, VK_FORMAT_R16G16B16A16_SFLOAT)),
         TWIN_EDITS(ADD(T_UPDATE.vertexData.deviceAddress, 4), SET(T_UPDATE.vertexStride, 16)),
         .path = "pInfos[4].pGeometries[0].geometry.triangles.vertexFormat"),
    CASE("max_vertex_of_update", RULE(max_vertex_matches_source), EDITS(SET(T_UPDATE.maxVertex, 6)),
         TWIN_EDITS(SET(ranges[UPDATE][0].firstVertex, 1)),
         .path = "pInfos[4].pGeometries[0].geometry.triangles.maxVertex"),
    CASE("max_vertex_of_update_of_compacted_copy", RULE(max_vertex_matches_source),
         .prepare = update_compacted_copy, EDITS(SET(T_UPDATE.maxVertex, 6))),
    CASE("dst_too_small_for_an_update_of_an_uncompacted_source", RULE(dst_is_large_enough),
         SETUP(.level = "execution"), EITHER_CALL_SIZE(update_into, 2, 1),
         .path = "pInfos[4].dstAccelerationStructure"),
    CASE("index_type_of_update", RULE(index_type_matches_source),
         EDITS(SET(T_UPDATE.indexType, VK_INDEX_TYPE_UINT16)),
         TWIN_EDITS(ADD(T_UPDATE.indexData.deviceAddress, 4)), .below_content = true,
         .path = "pInfos[4].pGeometries[0].geometry.triangles.indexType"),
    CASE("transform_of_update_of_source_without", RULE(transform_is_absent_where_source_had_none),
         .prepare = build_source_without_transform,
         TWIN_EDITS(SET(T_UPDATE.transformData.deviceAddress, 0)),
         .path = "pInfos[4].pGeometries[0].geometry.triangles.transformData"),
    CASE("transform_of_update_missing", RULE(transform_is_given_where_source_had_one),
         EDITS(SET(T_UPDATE.transformData.deviceAddress, 0)),
         TWIN_EDITS(ADD(T_UPDATE.transformData.deviceAddress, SCENE_TRANSFORM_OFFSET)),
         .path = "pInfos[4].pGeometries[0].geometry.triangles.transformData"),
    CASE("primitive_count_of_update", RULE(primitive_count_matches_source),
         EDITS(SET(ranges[UPDATE][0].primitiveCount, 1)),
         TWIN_EDITS(SET(ranges[UPDATE][0].primitiveOffset, 12)), .keep_arrays = true,
         .below_content = true),
};

CASE_LIST(cases_update, cases);
