/* SPDX-License-Identifier: Apache-2.0 */
/* The members of a geometry and of the structure of its type, addresses and chains aside. */
#include "case.h"

#define T_INDEXED TRIANGLES(INDEXED, 0)
#define GEOMETRY_PATH "pInfos[0].pGeometries[0].geometry.triangles."

/* ---- setups ---- */

static const struct setup with_future = {.enable = ENABLE_FUTURE};
static const struct setup with_uint8_khr = {.enable = ENABLE_UINT8_KHR};
static const struct setup with_uint8_ext = {.enable = ENABLE_UINT8_EXT};
static const struct setup with_uint8_core = {.enable = ENABLE_UINT8_CORE,
                                             .api_version = VK_API_VERSION_1_4};
static const struct setup with_core_1_4 = {.api_version = VK_API_VERSION_1_4};
static const struct setup with_maintenance5 = {.enable = ENABLE_MAINTENANCE5};

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

static void offer_packed_format(struct null_driver_config *config)
{
    config->formats[config->format_count++] = (struct null_driver_format){
        VK_FORMAT_A2B10G10R10_SNORM_PACK32,
        VK_FORMAT_FEATURE_2_ACCELERATION_STRUCTURE_VERTEX_BUFFER_BIT_KHR};
    config->formats[config->format_count++] = (struct null_driver_format){
        VK_FORMAT_R64G64B64_SFLOAT,
        VK_FORMAT_FEATURE_2_ACCELERATION_STRUCTURE_VERTEX_BUFFER_BIT_KHR};
    config->formats[config->format_count++] = (struct null_driver_format){
        VK_FORMAT_R8G8B8A8_SNORM, VK_FORMAT_FEATURE_2_ACCELERATION_STRUCTURE_VERTEX_BUFFER_BIT_KHR};
}

static const struct setup with_packed_format = {.configure = offer_packed_format};

static const struct test_case cases[] = {
    CASE("geometry_stype_0", RULES(RULE_geometry_has_its_stype),
         .edits = EDITS(SET(geometries[INDEXED][0].sType, 0)),
         .path = "pInfos[0].pGeometries[0].sType"),
    CASE("geometry_stype_of_second", RULES(RULE_geometry_has_its_stype),
         .edits = EDITS(SET(geometries[AABBS][1].sType, 77)),
         .twin_edits = EDITS(SET(geometries[AABBS][2].sType, 77)),
         .path = "pInfos[2].pGeometries[1].sType"),
    CASE("geometry_type_out_of_range", RULES(RULE_geometry_type_is_valid),
         .edits = EDITS(SET(geometries[INDEXED][0].geometryType, 3)),
         .path = "pInfos[0].pGeometries[0].geometryType"),
    CASE("geometry_type_of_extension_not_enabled", RULES(RULE_geometry_type_is_valid),
         .edits = EDITS(SET(geometries[INDEXED][0].geometryType, VK_GEOMETRY_TYPE_SPHERES_NV))),
    CASE("geometry_type_of_unknown_extension", RULES(RULE_geometry_type_is_valid), .silent = true,
         .setup = &with_future,
         .edits = EDITS(SET(geometries[INDEXED][0].geometryType, 1999999000)),
         .may_fail_on_cpu = true),
    CASE("geometry_flags_unknown", RULES(RULE_geometry_flags_are_valid),
         .edits = EDITS(SET(geometries[TLAS][0].flags, 4)),
         .twin_edits = EDITS(SET(geometries[TLAS][0].flags, 3)),
         .path = "pInfos[3].pGeometries[0].flags"),
    CASE("geometry_flags_of_unknown_extension", RULES(RULE_geometry_flags_are_valid),
         .silent = true, .setup = &with_future,
         .edits = EDITS(SET(geometries[TLAS][0].flags, 0x100))),
    CASE("tlas_of_boxes", RULES(RULE_tlas_geometry_is_instances),
         .edits = EDITS(COPY(geometries[TLAS][0], geometries[AABBS][0])),
         .path = "pInfos[3].pGeometries[0].geometryType"),
    CASE("tlas_of_triangles", RULES(RULE_tlas_geometry_is_instances),
         .edits = EDITS(COPY(geometries[TLAS][0], geometries[INDEXED][0]),
                        COPY(ranges[TLAS][0], ranges[INDEXED][0]))),
    CASE("blas_of_instances", RULES(RULE_blas_geometry_is_not_instances),
         .edits = EDITS(COPY(geometries[INDEXED][0], geometries[TLAS][0]),
                        COPY(ranges[INDEXED][0], ranges[TLAS][0])),
         .path = "pInfos[0].pGeometries[0].geometryType"),

    CASE("triangles_member_holds_boxes", RULES(RULE_triangles_member_is_filled),
         .edits = EDITS(COPY(geometries[INDEXED][0].geometry, geometries[AABBS][0].geometry)),
         .path = "pInfos[0].pGeometries[0].geometry"),
    CASE("triangles_member_holds_instances", RULES(RULE_triangles_member_is_filled),
         .edits = EDITS(COPY(geometries[UNINDEXED][1].geometry, geometries[TLAS][0].geometry))),
    CASE("aabbs_member_holds_triangles", RULES(RULE_aabbs_member_is_filled),
         .edits = EDITS(COPY(geometries[AABBS][1].geometry, geometries[INDEXED][0].geometry)),
         .path = "pInfos[2].pGeometries[1].geometry"),
    CASE("instances_member_holds_triangles", RULES(RULE_instances_member_is_filled),
         .edits = EDITS(COPY(geometries[TLAS][0].geometry, geometries[INDEXED][0].geometry)),
         .path = "pInfos[3].pGeometries[0].geometry"),
    CASE("triangles_stype_garbage", RULES(RULE_triangles_have_their_stype),
         .edits = EDITS(SET(T_INDEXED.sType, 12345)), .path = GEOMETRY_PATH "sType"),
    CASE("aabbs_stype_0", RULES(RULE_aabbs_have_their_stype),
         .edits = EDITS(SET(BOXES(AABBS, 0).sType, 0)),
         .path = "pInfos[2].pGeometries[0].geometry.aabbs.sType"),
    CASE("instances_stype_garbage", RULES(RULE_instances_have_their_stype),
         .edits = EDITS(SET(INSTANCES(TLAS, 0).sType, VK_STRUCTURE_TYPE_APPLICATION_INFO)),
         .path = "pInfos[3].pGeometries[0].geometry.instances.sType"),

    CASE("vertex_format_out_of_range", RULES(RULE_vertex_format_is_valid),
         .edits = EDITS(SET(T_INDEXED.vertexFormat, 999)), .path = GEOMETRY_PATH "vertexFormat"),
    CASE("vertex_format_max_enum", RULES(RULE_vertex_format_is_valid),
         .edits = EDITS(SET(TRIANGLES(UNINDEXED, 1).vertexFormat, VK_FORMAT_MAX_ENUM))),
    CASE("vertex_format_of_extension_not_enabled", RULES(RULE_vertex_format_is_supported),
         .edits = EDITS(SET(T_INDEXED.vertexFormat, VK_FORMAT_A8_UNORM_KHR)),
         .twin_edits = EDITS(SET(T_INDEXED.vertexFormat, VK_FORMAT_R32G32_SFLOAT))),
    CASE("vertex_format_of_extension_enabled_but_unsupported",
         RULES(RULE_vertex_format_is_supported), .setup = &with_maintenance5,
         .edits = EDITS(SET(T_INDEXED.vertexFormat, VK_FORMAT_A8_UNORM_KHR))),
    CASE("vertex_format_undefined", RULES(RULE_vertex_format_is_supported),
         .edits = EDITS(SET(T_INDEXED.vertexFormat, VK_FORMAT_UNDEFINED))),
    CASE("vertex_format_unsupported", RULES(RULE_vertex_format_is_supported),
         .edits = EDITS(SET(T_INDEXED.vertexFormat, VK_FORMAT_R32G32B32A32_UINT),
                        SET(T_INDEXED.vertexStride, 16)),
         .mutate_twin = use_every_mandatory_format, .path = GEOMETRY_PATH "vertexFormat"),
    CASE("vertex_format_compressed", RULES(RULE_vertex_format_is_supported),
         .edits = EDITS(SET(TRIANGLES(UNINDEXED, 0).vertexFormat, VK_FORMAT_BC1_RGB_UNORM_BLOCK),
                        SET(TRIANGLES(UNINDEXED, 0).vertexStride, 16)),
         .path = "pInfos[1].pGeometries[0].geometry.triangles.vertexFormat"),
    CASE("vertex_stride_misaligned", RULES(RULE_vertex_stride_is_aligned),
         .edits = EDITS(SET(T_INDEXED.vertexStride, 14)),
         .twin_edits = EDITS(SET(T_INDEXED.vertexStride, 16)),
         .path = GEOMETRY_PATH "vertexStride"),
    CASE("vertex_stride_misaligned_to_16_bits", RULES(RULE_vertex_stride_is_aligned),
         .prepare_edits = EDITS(SET(T_INDEXED.vertexFormat, VK_FORMAT_R16G16B16A16_SFLOAT)),
         .edits = EDITS(SET(T_INDEXED.vertexStride, 9)),
         .twin_edits = EDITS(SET(T_INDEXED.vertexStride, 10))),
    CASE("vertex_stride_misaligned_to_64_bits", RULES(RULE_vertex_stride_is_aligned),
         .setup = &with_packed_format,
         .prepare_edits = EDITS(SET(T_INDEXED.vertexFormat, VK_FORMAT_R64G64B64_SFLOAT)),
         .edits = EDITS(SET(T_INDEXED.vertexStride, 28)),
         .twin_edits = EDITS(SET(T_INDEXED.vertexStride, 32))),
    CASE("vertex_stride_of_bytes", RULES(RULE_vertex_stride_is_aligned), .silent = true,
         .setup = &with_packed_format,
         .edits = EDITS(SET(T_INDEXED.vertexFormat, VK_FORMAT_R8G8B8A8_SNORM),
                        SET(T_INDEXED.vertexStride, 5))),
    CASE("vertex_stride_0", RULES(RULE_vertex_stride_is_aligned), .silent = true,
         .edits = EDITS(SET(T_INDEXED.vertexStride, 0))),
    CASE("vertex_stride_over_32_bits", RULES(RULE_vertex_stride_fits_32_bits),
         .edits = EDITS(SET(T_INDEXED.vertexStride, 0x100000000)),
         .twin_edits = EDITS(SET(T_INDEXED.vertexStride, 0xfffffffc)), .may_fail_on_cpu = true,
         .path = GEOMETRY_PATH "vertexStride"),
    CASE("vertex_stride_of_all_32_bits", RULES(RULE_vertex_stride_fits_32_bits), .silent = true,
         .setup = &with_packed_format,
         .edits = EDITS(SET(T_INDEXED.vertexFormat, VK_FORMAT_R8G8B8A8_SNORM),
                        SET(T_INDEXED.vertexStride, 0xffffffff))),
    CASE("vertex_stride_over_32_bits_and_misaligned",
         RULES(RULE_vertex_stride_fits_32_bits, RULE_vertex_stride_is_aligned),
         .edits = EDITS(SET(TRIANGLES(UNINDEXED, 1).vertexStride, 0x100000001)),
         .path = "pInfos[1].pGeometries[1].geometry.triangles.vertexStride"),

    CASE("index_type_out_of_range", RULES(RULE_index_type_is_valid),
         .edits = EDITS(SET(T_INDEXED.indexType, 2)), .path = GEOMETRY_PATH "indexType"),
    CASE("index_type_uint8_not_enabled", RULES(RULE_index_type_is_16_or_32_bits_or_none),
         .edits = EDITS(SET(T_INDEXED.indexType, VK_INDEX_TYPE_UINT8_KHR)),
         .twin_edits = EDITS(SET(T_INDEXED.indexType, VK_INDEX_TYPE_UINT16))),
    CASE("index_type_uint8_khr", RULES(RULE_index_type_is_16_or_32_bits_or_none),
         .setup = &with_uint8_khr,
         .edits = EDITS(SET(T_INDEXED.indexType, VK_INDEX_TYPE_UINT8_KHR)),
         .path = GEOMETRY_PATH "indexType"),
    CASE("index_type_uint8_ext", RULES(RULE_index_type_is_16_or_32_bits_or_none),
         .setup = &with_uint8_ext,
         .edits = EDITS(SET(T_INDEXED.indexType, VK_INDEX_TYPE_UINT8_EXT))),
    CASE("index_type_uint8_core", RULES(RULE_index_type_is_16_or_32_bits_or_none),
         .setup = &with_uint8_core, .edits = EDITS(SET(T_INDEXED.indexType, VK_INDEX_TYPE_UINT8))),
    CASE("index_type_uint8_core_without_feature", RULES(RULE_index_type_is_16_or_32_bits_or_none),
         .setup = &with_core_1_4, .edits = EDITS(SET(T_INDEXED.indexType, VK_INDEX_TYPE_UINT8))),

    CASE("aabb_stride_misaligned", RULES(RULE_aabb_stride_is_aligned),
         .edits = EDITS(SET(BOXES(AABBS, 1).stride, 28)),
         .twin_edits = EDITS(SET(BOXES(AABBS, 1).stride, 40)),
         .path = "pInfos[2].pGeometries[1].geometry.aabbs.stride", .below_content = true),
    CASE("aabb_stride_0", RULES(RULE_aabb_stride_is_aligned), .silent = true,
         .edits = EDITS(SET(BOXES(AABBS, 1).stride, 0))),
    CASE("aabb_stride_over_32_bits", RULES(RULE_aabb_stride_fits_32_bits),
         .commands = ON_COMMAND_BUFFERS, .edits = EDITS(SET(BOXES(AABBS, 0).stride, 0x100000000)),
         .twin_edits = EDITS(SET(BOXES(AABBS, 0).stride, 0xfffffff8)),
         .path = "pInfos[2].pGeometries[0].geometry.aabbs.stride"),
    /* One box is read whatever the stride. */
    CASE("aabb_stride_too_large_for_the_host", RULES(RULE_aabb_stride_fits_32_bits),
         .commands = ON_HOST,
         .edits = EDITS(SET(BOXES(AABBS, 0).stride, 0x100000000),
                        SET(ranges[AABBS][0].primitiveCount, 1)),
         .twin_edits = EDITS(SET(BOXES(AABBS, 0).stride, 0xfffffff8),
                             SET(ranges[AABBS][0].primitiveCount, 1)),
         .path = "pInfos[2].pGeometries[0].geometry.aabbs.stride"),
};

CASE_LIST(cases_geometry, cases);
