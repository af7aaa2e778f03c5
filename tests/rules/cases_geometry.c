/* SPDX-License-Identifier: Apache-2.0 */
/* The members of a geometry and of the structure of its type, addresses and chains aside. */
#include "case.h"

#define T_INDEXED TRIANGLES(INDEXED, 0)
#define GEOMETRY_PATH "pInfos[0].pGeometries[0].geometry.triangles."

/* ---- vertex formats ---- */

static const VkFormat formats_that_all_have[] = {
    VK_FORMAT_R32G32_SFLOAT,       VK_FORMAT_R32G32B32_SFLOAT, VK_FORMAT_R16G16_SFLOAT,
    VK_FORMAT_R16G16B16A16_SFLOAT, VK_FORMAT_R16G16_SNORM,     VK_FORMAT_R16G16B16A16_SNORM,
};

static void use_every_mandatory_format(struct scene *scene)
{
    for (size_t i = 0; i < sizeof(formats_that_all_have) / sizeof(formats_that_all_have[0]); i++) {
        const uint32_t build = i == 0 ? (uint32_t)INDEXED : scene_add_build(scene, INDEXED);
        scene->geometries[build][0].geometry.triangles.vertexFormat = formats_that_all_have[i];
    }
}

static const struct setup with_packed_format = {.configure = offer_packed_format};

static const struct test_case cases[] = {
    CASE("geometry_stype_0", RULE(geometry_has_its_stype),
         EDITS(SET(geometries[INDEXED][0].sType, 0)), .path = "pInfos[0].pGeometries[0].sType"),
    CASE("geometry_stype_of_second", RULE(geometry_has_its_stype),
         EDITS(SET(geometries[AABBS][1].sType, 77)),
         TWIN_EDITS(SET(geometries[AABBS][2].sType, 77)), .path = "pInfos[2].pGeometries[1].sType"),
    CASE("geometry_type_out_of_range", RULE(geometry_type_is_valid),
         EDITS(SET(geometries[INDEXED][0].geometryType, 3)),
         .path = "pInfos[0].pGeometries[0].geometryType"),
    CASE("geometry_type_of_extension_not_enabled", RULE(geometry_type_is_valid),
         EDITS(SET(geometries[INDEXED][0].geometryType, VK_GEOMETRY_TYPE_SPHERES_NV))),
    CASE("geometry_type_of_unknown_extension", RULE(geometry_type_is_valid), .silent = true,
         SETUP(.enable = ENABLE_FUTURE),
         EDITS(SET(geometries[INDEXED][0].geometryType, 1999999000)), .may_fail_on_cpu = true),
    CASE("geometry_flags_unknown", RULE(geometry_flags_are_valid),
         EITHER_SET(geometries[TLAS][0].flags, 4, 3), .path = "pInfos[3].pGeometries[0].flags"),
    CASE("geometry_flags_of_unknown_extension", RULE(geometry_flags_are_valid), .silent = true,
         SETUP(.enable = ENABLE_FUTURE), EDITS(SET(geometries[TLAS][0].flags, 0x100))),
    CASE("tlas_of_boxes", RULE(tlas_geometry_is_instances),
         EDITS(COPY(geometries[TLAS][0], geometries[AABBS][0])),
         .path = "pInfos[3].pGeometries[0].geometryType"),
    CASE("tlas_of_triangles", RULE(tlas_geometry_is_instances),
         EDITS(COPY(geometries[TLAS][0], geometries[INDEXED][0]),
               COPY(ranges[TLAS][0], ranges[INDEXED][0]))),
    CASE("blas_of_instances", RULE(blas_geometry_is_not_instances),
         EDITS(COPY(geometries[INDEXED][0], geometries[TLAS][0]),
               COPY(ranges[INDEXED][0], ranges[TLAS][0])),
         .path = "pInfos[0].pGeometries[0].geometryType"),
    CASE("triangles_member_holds_boxes", RULE(triangles_member_is_filled),
         EDITS(COPY(geometries[INDEXED][0].geometry, geometries[AABBS][0].geometry)),
         .path = "pInfos[0].pGeometries[0].geometry"),
    CASE("triangles_member_holds_instances", RULE(triangles_member_is_filled),
         EDITS(COPY(geometries[UNINDEXED][1].geometry, geometries[TLAS][0].geometry))),
    CASE("aabbs_member_holds_triangles", RULE(aabbs_member_is_filled),
         EDITS(COPY(geometries[AABBS][1].geometry, geometries[INDEXED][0].geometry)),
         .path = "pInfos[2].pGeometries[1].geometry"),
    CASE("instances_member_holds_triangles", RULE(instances_member_is_filled),
         EDITS(COPY(geometries[TLAS][0].geometry, geometries[INDEXED][0].geometry)),
         .path = "pInfos[3].pGeometries[0].geometry"),
    CASE("triangles_stype_garbage", RULE(triangles_have_their_stype),
         EDITS(SET(T_INDEXED.sType, 12345)), .path = GEOMETRY_PATH "sType"),
    CASE("aabbs_stype_0", RULE(aabbs_have_their_stype), EDITS(SET(BOXES(AABBS, 0).sType, 0)),
         .path = "pInfos[2].pGeometries[0].geometry.aabbs.sType"),
    CASE("instances_stype_garbage", RULE(instances_have_their_stype),
         EDITS(SET(INSTANCES(TLAS, 0).sType, VK_STRUCTURE_TYPE_APPLICATION_INFO)),
         .path = "pInfos[3].pGeometries[0].geometry.instances.sType"),
    CASE("vertex_format_out_of_range", RULE(vertex_format_is_valid),
         EDITS(SET(T_INDEXED.vertexFormat, 999)), .path = GEOMETRY_PATH "vertexFormat"),
    CASE("vertex_format_max_enum", RULE(vertex_format_is_valid),
         EDITS(SET(TRIANGLES(UNINDEXED, 1).vertexFormat, VK_FORMAT_MAX_ENUM))),
    CASE("vertex_format_of_extension_not_enabled", RULE(vertex_format_is_supported),
         EITHER_SET(T_INDEXED.vertexFormat, VK_FORMAT_A8_UNORM_KHR, VK_FORMAT_R32G32_SFLOAT)),
    CASE("vertex_format_of_extension_enabled_but_unsupported", RULE(vertex_format_is_supported),
         SETUP(.enable = ENABLE_MAINTENANCE5),
         EDITS(SET(T_INDEXED.vertexFormat, VK_FORMAT_A8_UNORM_KHR))),
    CASE("vertex_format_undefined", RULE(vertex_format_is_supported),
         EDITS(SET(T_INDEXED.vertexFormat, VK_FORMAT_UNDEFINED))),

    SHARED(RULE(vertex_stride_is_aligned)),
    CASE("vertex_format_unsupported", RULE(vertex_format_is_supported),
         EDITS(SET(T_INDEXED.vertexFormat, VK_FORMAT_R32G32B32A32_UINT),
               SET(T_INDEXED.vertexStride, 16)),
         .mutate_twin = use_every_mandatory_format, .path = GEOMETRY_PATH "vertexFormat"),
    CASE("vertex_format_compressed", RULE(vertex_format_is_supported),
         EDITS(SET(TRIANGLES(UNINDEXED, 0).vertexFormat, VK_FORMAT_BC1_RGB_UNORM_BLOCK),
               SET(TRIANGLES(UNINDEXED, 0).vertexStride, 16)),
         .path = "pInfos[1].pGeometries[0].geometry.triangles.vertexFormat"),
    CASE("vertex_stride_misaligned", EITHER_SET(T_INDEXED.vertexStride, 14, 16),
         .path = GEOMETRY_PATH "vertexStride"),
    CASE("vertex_stride_misaligned_to_16_bits",
         PREPARE_EDITS(SET(T_INDEXED.vertexFormat, VK_FORMAT_R16G16B16A16_SFLOAT)),
         EITHER_SET(T_INDEXED.vertexStride, 9, 10)),
    CASE("vertex_stride_misaligned_to_64_bits", .setup = &with_packed_format,
         PREPARE_EDITS(SET(T_INDEXED.vertexFormat, VK_FORMAT_R64G64B64_SFLOAT)),
         EITHER_SET(T_INDEXED.vertexStride, 28, 32)),
    CASE("vertex_stride_of_bytes", .silent = true, .setup = &with_packed_format,
         EDITS(SET(T_INDEXED.vertexFormat, VK_FORMAT_R8G8B8A8_SNORM),
               SET(T_INDEXED.vertexStride, 5))),
    CASE("vertex_stride_0", .silent = true, EDITS(SET(T_INDEXED.vertexStride, 0))),
    CASE("vertex_stride_over_32_bits", RULE(vertex_stride_fits_32_bits),
         EITHER_SET(T_INDEXED.vertexStride, 0x100000000, 0xfffffffc), .may_fail_on_cpu = true,
         .path = GEOMETRY_PATH "vertexStride"),

    SHARED(RULE(index_type_is_16_or_32_bits_or_none)),
    CASE("vertex_stride_of_all_32_bits", RULE(vertex_stride_fits_32_bits), .silent = true,
         .setup = &with_packed_format,
         EDITS(SET(T_INDEXED.vertexFormat, VK_FORMAT_R8G8B8A8_SNORM),
               SET(T_INDEXED.vertexStride, 0xffffffff))),
    CASE("vertex_stride_over_32_bits_and_misaligned",
         RULES(RULE_vertex_stride_fits_32_bits, RULE_vertex_stride_is_aligned),
         EDITS(SET(TRIANGLES(UNINDEXED, 1).vertexStride, 0x100000001)),
         .path = "pInfos[1].pGeometries[1].geometry.triangles.vertexStride"),
    CASE("index_type_out_of_range", RULE(index_type_is_valid), EDITS(SET(T_INDEXED.indexType, 2)),
         .path = GEOMETRY_PATH "indexType"),
    CASE("index_type_uint8_not_enabled",
         EITHER_SET(T_INDEXED.indexType, VK_INDEX_TYPE_UINT8_KHR, VK_INDEX_TYPE_UINT16)),
    CASE("index_type_uint8_khr", SETUP(.enable = ENABLE_UINT8_KHR),
         EDITS(SET(T_INDEXED.indexType, VK_INDEX_TYPE_UINT8_KHR)),
         .path = GEOMETRY_PATH "indexType"),
    CASE("index_type_uint8_ext", SETUP(.enable = ENABLE_UINT8_EXT),
         EDITS(SET(T_INDEXED.indexType, VK_INDEX_TYPE_UINT8_EXT))),
    CASE("index_type_uint8_core",
         SETUP(.enable = ENABLE_UINT8_CORE, .api_version = VK_API_VERSION_1_4),
         EDITS(SET(T_INDEXED.indexType, VK_INDEX_TYPE_UINT8))),
    CASE("index_type_uint8_core_without_feature", SETUP(.api_version = VK_API_VERSION_1_4),
         EDITS(SET(T_INDEXED.indexType, VK_INDEX_TYPE_UINT8))),

    SHARED(RULE(aabb_stride_is_aligned)),
    CASE("aabb_stride_misaligned", EITHER_SET(BOXES(AABBS, 1).stride, 28, 40),
         .below_content = true, .path = "pInfos[2].pGeometries[1].geometry.aabbs.stride"),
    CASE("aabb_stride_0", .silent = true, EDITS(SET(BOXES(AABBS, 1).stride, 0))),

    SHARED(RULE(aabb_stride_fits_32_bits),
           .path = "pInfos[2].pGeometries[0].geometry.aabbs.stride"),
    CASE("aabb_stride_over_32_bits", .commands = ON_COMMAND_BUFFERS,
         EITHER_SET(BOXES(AABBS, 0).stride, 0x100000000, 0xfffffff8)),
    /* One box is read whatever the stride. */
    CASE("aabb_stride_too_large_for_the_host", .commands = ON_HOST,
         EDITS(SET(BOXES(AABBS, 0).stride, 0x100000000), SET(ranges[AABBS][0].primitiveCount, 1)),
         TWIN_EDITS(SET(BOXES(AABBS, 0).stride, 0xfffffff8),
                    SET(ranges[AABBS][0].primitiveCount, 1))),
};

CASE_LIST(cases_geometry, cases);
