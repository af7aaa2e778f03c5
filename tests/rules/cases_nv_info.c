/* SPDX-License-Identifier: Apache-2.0 */
/* VkAccelerationStructureInfoNV, by itself and against what dst was created for. What would have to
 * be created with a wrong info, too, is for the null driver alone. */
#include "case.h"

#define NV_TRIANGLES(index) nv.geometries[index].geometry.triangles
#define NV_BOXES(index) nv.geometries[index].geometry.aabbs

#define FAST_TRACE VK_BUILD_ACCELERATION_STRUCTURE_PREFER_FAST_TRACE_BIT_NV

/* ---- limits ---- */

enum { LIMIT = 4 };

static void limit_geometries(struct null_driver_config *config)
{
    config->nv_properties.maxGeometryCount = 1;
}

static void limit_instances(struct null_driver_config *config)
{
    config->nv_properties.maxInstanceCount = LIMIT;
}

static void limit_triangles(struct null_driver_config *config)
{
    config->nv_properties.maxTriangleCount = LIMIT;
}

static const struct setup nothing_special = {0};

/* ---- infos of which dst knows ---- */

static void create_tlas_with_geometries(struct scene *scene)
{
    const VkGeometryNV *geometries = scene->nv.info.pGeometries;
    scene_nv_use_instances(scene);
    scene->nv.info.geometryCount = 1;
    scene->nv.info.pGeometries = geometries;
    scene_nv_give_objects(scene);
}

/* ---- what dst was created for ---- */

static void build_a_tlas_into_a_blas(struct scene *scene)
{
    const VkAccelerationStructureNV blas = scene->nv.dst;
    scene_nv_use_instances(scene);
    scene->nv.dst = blas;
    scene_nv_give_large_scratch(scene);
}

static void build_boxes_into_triangles(struct scene *scene)
{
    const VkAccelerationStructureNV dst = scene->nv.dst;
    scene_nv_use_boxes(scene);
    scene->nv.dst = dst;
    scene_nv_give_large_scratch(scene);
}

/* The next geometry of dst would have enough. */
static void build_in_another_order(struct scene *scene)
{
    const VkGeometryNV first = scene->nv.geometries[0];
    scene->nv.geometries[0] = scene->nv.geometries[1];
    scene->nv.geometries[1] = first;
}

static const struct test_case cases[] = {
    CASE("stype", RULE(nv_info_has_its_stype),
         EDITS(SET(nv.info.sType, VK_STRUCTURE_TYPE_GEOMETRY_NV)),
         .path = "): pInfo->sType VK_STRUCTURE_TYPE_GEOMETRY_NV is not"),
    CASE("chain", RULE(nv_info_has_no_chain), EDITS(SET(nv.info.pNext, 16)),
         .path = "pInfo->pNext 0x10"),

    SHARED(.spares_drivers = true),
    CASE(
        "type_unknown", RULE(nv_info_type_is_valid),
        EDITS(SET(nv.info.type, (VkAccelerationStructureTypeNV)1234), CALL(scene_nv_give_objects))),
    CASE("type_generic", RULE(nv_info_type_is_not_generic),
         EDITS(SET(nv.info.type, VK_ACCELERATION_STRUCTURE_TYPE_GENERIC_KHR),
               CALL(scene_nv_give_objects))),
    CASE(
        "flags_unknown", RULE(nv_info_flags_are_valid),
        EDITS(ADD(nv.info.flags, 1u << 30), CALL(scene_nv_give_objects)),
        TWIN_EDITS(SET(nv.info.flags, VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_UPDATE_BIT_NV |
                                          VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_COMPACTION_BIT_NV |
                                          VK_BUILD_ACCELERATION_STRUCTURE_PREFER_FAST_BUILD_BIT_NV |
                                          VK_BUILD_ACCELERATION_STRUCTURE_LOW_MEMORY_BIT_NV),
                   CALL(scene_nv_give_objects))),
    CASE("fast_trace_and_fast_build", RULE(nv_fast_trace_excludes_fast_build),
         EDITS(ADD(nv.info.flags,
                   FAST_TRACE | VK_BUILD_ACCELERATION_STRUCTURE_PREFER_FAST_BUILD_BIT_NV),
               CALL(scene_nv_give_objects)),
         TWIN_EDITS(ADD(nv.info.flags, FAST_TRACE), CALL(scene_nv_give_objects))),
    CASE("tlas_with_geometries", RULE(nv_tlas_has_no_geometries),
         .mutate = create_tlas_with_geometries, .mutate_twin = scene_nv_use_instances),
    CASE("blas_with_instances", RULE(nv_blas_has_no_instances),
         EDITS(SET(nv.info.instanceCount, 1), CALL(scene_nv_give_objects))),

    SHARED(RULE(nv_geometries_are_readable)),
    /* A build of 0 boxes, for which dst is large enough. */
    CASE("blas_of_two_types", RULE(nv_blas_geometries_have_one_type),
         EDITS(SET(nv.geometries[1].geometryType, VK_GEOMETRY_TYPE_AABBS_NV),
               COPY(nv.geometries[1].geometry.aabbs.aabbData, nv.boxes.handle),
               SET(nv.geometries[1].geometry.aabbs.stride, 24)),
         .mutate_twin = scene_nv_use_boxes),
    CASE("geometries_null", PREPARE_EDITS(SET(nv.info.pGeometries, 0)),
         TWIN_EDITS(SET(nv.info.geometryCount, 0))),
    CASE("geometries_unreadable", EDITS(UNREADABLE(nv.info.pGeometries))),
    CASE("geometries_cut_short",
         PREPARE_EDITS(PUT_AT_EDGE(nv.info.pGeometries, sizeof(VkGeometryNV))),
         TWIN_EDITS(SET(nv.info.geometryCount, 1))),

    SHARED(SETUP(.configure = limit_geometries), .twin_setup = &nothing_special),
    CASE("geometry_limit", RULE(nv_build_geometry_count_is_within_limit),
         NAMES(RULE_nv_geometry_count_is_within_limit), .path = "pInfo->geometryCount 2 exceeds"),
    CASE(
        "geometry_limit_met",
        RULES(RULE_nv_build_geometry_count_is_within_limit, RULE_nv_geometry_count_is_within_limit),
        .silent = true, EDITS(SET(nv.info.geometryCount, 1))),

    SHARED(RULE(nv_dst_was_created_compatible)),
    CASE("instance_limit", RULE(nv_instance_count_is_within_limit),
         SETUP(.configure = limit_instances), .prepare = scene_nv_use_instances,
         EDITS(SET(nv.info.instanceCount, LIMIT + 1), CALL(scene_nv_give_objects)),
         TWIN_EDITS(SET(nv.info.instanceCount, LIMIT), CALL(scene_nv_give_objects))),
    CASE("triangle_limit", RULE(nv_triangle_count_is_within_limit),
         SETUP(.configure = limit_triangles),
         EDITS(SET(nv.geometries[1].geometry.triangles.vertexCount, 9),
               CALL(scene_nv_give_objects))),
    /* No device takes as many, backend cpu included. */
    CASE("more_geometries_than_any_limit",
         RULES(RULE_nv_build_geometry_count_is_within_limit, RULE_nv_geometries_are_readable,
               RULE_nv_dst_was_created_compatible),
         NAMES(RULE_nv_geometry_count_is_within_limit),
         EDITS(SET(nv.info.geometryCount, UINT32_MAX))),
    CASE("more_instances_than_any_limit",
         RULES(RULE_nv_instance_count_is_within_limit, RULE_nv_dst_was_created_compatible),
         .prepare = scene_nv_use_instances, EDITS(SET(nv.info.instanceCount, UINT32_MAX))),
    CASE("more_triangles_than_any_limit",
         RULES(RULE_nv_triangle_count_is_within_limit, RULE_nv_dst_was_created_compatible),
         EDITS(SET(NV_TRIANGLES(0).indexCount, 3u << 29))),
    CASE("another_type", .mutate = build_a_tlas_into_a_blas, .mutate_twin = scene_nv_use_instances),
    CASE("other_flags", PREPARE_EDITS(SET(nv.info.flags, 0)),
         TWIN_EDITS(CALL(scene_nv_give_objects))),
    CASE("more_instances", .prepare = scene_nv_use_instances,
         EITHER_ADD(nv.info.instanceCount, 1, -1)),
    CASE("more_geometries",
         EDITS(COPY(nv.geometries[2], nv.geometries[1]), SET(nv.info.geometryCount, 3)),
         TWIN_EDITS(SET(nv.info.geometryCount, 1))),
    CASE("more_vertices", EITHER_ADD(NV_TRIANGLES(1).vertexCount, 1, -3),
         .path = "was created for 6 vertices in geometry 1"),
    CASE("more_vertices_of_indexed", EDITS(ADD(NV_TRIANGLES(0).vertexCount, 1))),
    CASE("more_indices", EITHER_ADD(NV_TRIANGLES(0).indexCount, 3, -3)),
    CASE("indices_where_there_were_none", EDITS(COPY(nv.geometries[1], nv.geometries[0])),
         TWIN_EDITS(SET(NV_TRIANGLES(0).indexType, VK_INDEX_TYPE_NONE_NV),
                    SET(NV_TRIANGLES(0).indexData, 0), SET(NV_TRIANGLES(0).indexCount, 0))),
    CASE("another_order", .mutate = build_in_another_order),
    CASE("more_boxes", .prepare = scene_nv_use_boxes,
         EDITS(ADD(nv.geometries[1].geometry.aabbs.numAABBs, 1)),
         .path = "was created for 3 AABBs in geometry 1"),
    CASE("fewer_boxes", .silent = true, .mutate = scene_nv_use_boxes,
         EDITS(ADD(NV_BOXES(1).numAABBs, -1))),
    CASE("boxes_where_there_were_triangles", .mutate = build_boxes_into_triangles,
         .mutate_twin = scene_nv_use_boxes),
};

CASE_LIST(cases_nv_info, cases);
