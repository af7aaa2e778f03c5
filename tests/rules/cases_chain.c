/* SPDX-License-Identifier: Apache-2.0 */
/* pNext chains of geometries: what may stand in them, and how often. */
#include "case.h"

/* ---- structures that may stand in a chain ---- */

static const VkBaseInStructure stray = {.sType = VK_STRUCTURE_TYPE_APPLICATION_INFO};
static const VkBaseInStructure unknown = {.sType = (VkStructureType)2000000123};

static const VkAccelerationStructureGeometryMotionTrianglesDataNV motion = {
    .sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_MOTION_TRIANGLES_DATA_NV};
static const VkAccelerationStructureGeometryMotionTrianglesDataNV motion_twice = {
    .sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_MOTION_TRIANGLES_DATA_NV,
    .pNext = &motion};
static const VkAccelerationStructureTrianglesOpacityMicromapEXT micromap = {
    .sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_TRIANGLES_OPACITY_MICROMAP_EXT,
    .indexType = VK_INDEX_TYPE_NONE_KHR};
static const VkAccelerationStructureTrianglesOpacityMicromapEXT micromap_and_stray = {
    .sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_TRIANGLES_OPACITY_MICROMAP_EXT,
    .pNext = (void *)&stray,
    .indexType = VK_INDEX_TYPE_NONE_KHR};
static const VkAccelerationStructureTrianglesDisplacementMicromapNV displacement = {
    .sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_TRIANGLES_DISPLACEMENT_MICROMAP_NV,
    .displacementBiasAndScaleFormat = VK_FORMAT_R32G32_SFLOAT,
    .displacementVectorFormat = VK_FORMAT_R32G32B32_SFLOAT,
    .indexType = VK_INDEX_TYPE_NONE_KHR};
static const VkAccelerationStructureGeometrySpheresDataNV spheres = {
    .sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_SPHERES_DATA_NV};
static const VkAccelerationStructureGeometrySpheresDataNV spheres_twice = {
    .sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_SPHERES_DATA_NV, .pNext = &spheres};
/* Each of these points to itself. */
static const VkAccelerationStructureGeometryMotionTrianglesDataNV motion_loop = {
    .sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_MOTION_TRIANGLES_DATA_NV,
    .pNext = &motion_loop};

/* The motion data points to real vertices, where the address has to be good. */
static void triangles_motion_filled(struct scene *scene)
{
    static VkAccelerationStructureGeometryMotionTrianglesDataNV filled;
    filled = motion;
    filled.vertexData.deviceAddress = scene_address(scene, &scene->vertices, 0);
    scene->geometries[INDEXED][0].geometry.triangles.pNext = &filled;
}

static const struct setup with_motion = {.enable = ENABLE_MOTION};
static const struct setup with_all = {.enable = ENABLE_MOTION | ENABLE_SPHERES |
                                                ENABLE_OPACITY_MICROMAP_EXT |
                                                ENABLE_DISPLACEMENT_MICROMAP};

static const struct test_case cases[] = {
    SHARED(RULE(geometry_chain_is_known)),
    CASE("geometry_chain_stray", EDITS(SET(geometries[INDEXED][0].pNext, &stray)),
         .path = "pInfos[0].pGeometries[0].pNext"),
    CASE("geometry_chain_unknown", EDITS(SET(geometries[AABBS][1].pNext, &unknown)),
         .path = "pInfos[2].pGeometries[1].pNext"),
    CASE("geometry_chain_unreadable", EDITS(UNREADABLE(geometries[INDEXED][0].pNext))),
    CASE("geometry_chain_of_unknown_extension", .silent = true, SETUP(.enable = ENABLE_FUTURE),
         EDITS(SET(geometries[AABBS][1].pNext, &unknown))),
    CASE("geometry_chain_of_the_triangles", .setup = &with_all,
         EITHER_SET(geometries[INDEXED][0].pNext, &motion, &spheres)),
    CASE("geometry_chain_spheres_not_enabled", EDITS(SET(geometries[INDEXED][0].pNext, &spheres))),

    SHARED(RULE(triangles_chain_is_known)),
    CASE("geometry_chain_spheres_twice", RULE(geometry_chain_has_no_duplicates),
         SETUP(.enable = ENABLE_SPHERES),
         EITHER_SET(geometries[INDEXED][0].pNext, &spheres_twice, &spheres),
         .path = "pInfos[0].pGeometries[0].pNext"),
    CASE("triangles_chain_stray", EDITS(SET(TRIANGLES(INDEXED, 0).pNext, &stray)),
         .path = "pInfos[0].pGeometries[0].geometry.triangles.pNext"),
    CASE("triangles_chain_unknown", EDITS(SET(TRIANGLES(UNINDEXED, 1).pNext, &unknown)),
         .path = "pInfos[1].pGeometries[1].geometry.triangles.pNext"),
    CASE("triangles_chain_unreadable",
         EDITS(UNREADABLE(geometries[INDEXED][0].geometry.triangles.pNext))),
    CASE("triangles_chain_of_unknown_extension", .silent = true, SETUP(.enable = ENABLE_FUTURE),
         EDITS(SET(TRIANGLES(UNINDEXED, 1).pNext, &unknown))),
    CASE("triangles_chain_of_the_geometry", .setup = &with_all,
         EDITS(SET(TRIANGLES(INDEXED, 0).pNext, &spheres)), .mutate_twin = triangles_motion_filled),
    CASE("triangles_chain_motion_not_enabled", EDITS(SET(TRIANGLES(INDEXED, 0).pNext, &motion))),

    SHARED(RULE(triangles_chain_is_known), .silent = true),
    CASE("triangles_chain_motion", .setup = &with_motion, .mutate = triangles_motion_filled),
    /* With it, the build may take more. */
    CASE("triangles_chain_micromap", SETUP(.enable = ENABLE_OPACITY_MICROMAP_EXT),
         EDITS(SET(TRIANGLES(INDEXED, 0).pNext, &micromap), CALL_WITH(scene_fit, INDEXED)),
         .may_fail_on_cpu = true),
    CASE("triangles_chain_micromap_khr", SETUP(.enable = ENABLE_OPACITY_MICROMAP_KHR),
         .mutate = scene_use_micromap, .may_fail_on_cpu = true),
    CASE("triangles_chain_displacement", SETUP(.enable = ENABLE_DISPLACEMENT_MICROMAP),
         EDITS(SET(TRIANGLES(INDEXED, 0).pNext, &displacement), CALL_WITH(scene_fit, INDEXED))),

    SHARED(RULE(triangles_chain_has_no_duplicates), .setup = &with_motion),
    CASE("triangles_chain_stray_behind_micromap", RULE(triangles_chain_is_known),
         SETUP(.enable = ENABLE_OPACITY_MICROMAP_EXT),
         EDITS(SET(TRIANGLES(INDEXED, 0).pNext, &micromap_and_stray)),
         TWIN_EDITS(SET(TRIANGLES(INDEXED, 0).pNext, &micromap), CALL_WITH(scene_fit, INDEXED)),
         .may_fail_on_cpu = true),
    CASE("triangles_chain_motion_twice", EDITS(SET(TRIANGLES(INDEXED, 0).pNext, &motion_twice)),
         .mutate_twin = triangles_motion_filled,
         .path = "pInfos[0].pGeometries[0].geometry.triangles.pNext"),
    CASE("triangles_chain_loop", EDITS(SET(TRIANGLES(INDEXED, 0).pNext, &motion_loop))),

    SHARED(RULE(aabbs_have_no_chain)),
    CASE("aabbs_chain", EDITS(SET(BOXES(AABBS, 0).pNext, &stray)),
         .path = "pInfos[2].pGeometries[0].geometry.aabbs.pNext"),
    CASE("aabbs_chain_of_triangles", .setup = &with_motion,
         EDITS(SET(BOXES(AABBS, 1).pNext, &motion))),
    CASE("aabbs_chain_unreadable", EDITS(SET(BOXES(AABBS, 0).pNext, 0x10))),

    SHARED(RULE(instances_have_no_chain)),
    CASE("instances_chain", EDITS(SET(INSTANCES(TLAS, 0).pNext, &stray)),
         .path = "pInfos[3].pGeometries[0].geometry.instances.pNext"),
    CASE("instances_chain_unreadable", EDITS(SET(INSTANCES(TLAS, 0).pNext, 0x10))),
};

CASE_LIST(cases_chain, cases);
