/* SPDX-License-Identifier: Apache-2.0 */
/* VkGeometryNV and the structures in it. */
#include "case.h"

#define NV_TRIANGLES(index) nv.geometries[index].geometry.triangles
#define NV_BOXES(index) nv.geometries[index].geometry.aabbs

/* ---- buffers ---- */

static VkGeometryTrianglesNV *indexed(struct scene *scene)
{
    return &scene->nv.geometries[0].geometry.triangles;
}

static VkBuffer foreign_buffer(struct scene *scene)
{
    scene_enter_other_device(scene);
    const struct test_buffer buffer =
        scene_buffer(scene, SCENE_BUFFER_SIZE, VK_BUFFER_USAGE_RAY_TRACING_BIT_NV);
    scene_leave_other_device(scene);
    return buffer.handle;
}

static void use_foreign_vertices(struct scene *scene)
{
    indexed(scene)->vertexData = foreign_buffer(scene);
}

static void use_foreign_indices(struct scene *scene)
{
    indexed(scene)->indexData = foreign_buffer(scene);
}

static void use_a_foreign_transform(struct scene *scene)
{
    indexed(scene)->transformData = foreign_buffer(scene);
}

/* ---- formats and indices ---- */

static void use_short_indices(struct scene *scene)
{
    indexed(scene)->indexType = VK_INDEX_TYPE_UINT16;
    indexed(scene)->indexOffset = SCENE_BUFFER_SIZE / 2;
}

static void offset_by_a_byte(struct scene *scene)
{
    indexed(scene)->indexOffset++;
}

static void offset_by_half_a_word(struct scene *scene)
{
    indexed(scene)->indexOffset += 2;
}

/* ---- cases ---- */

static const struct test_case cases[] = {
    CASE("stype", RULE(nv_geometry_has_its_stype), EDITS(SET(nv.geometries[1].sType, 0)),
         .path = "): pInfo->pGeometries[1].sType VK_STRUCTURE_TYPE_APPLICATION_INFO is not"),
    CASE("chain", RULE(nv_geometry_has_no_chain), EDITS(SET(nv.geometries[1].pNext, 16))),
    CASE("type_unknown", RULE(nv_geometry_type_is_valid),
         EDITS(SET(nv.geometries[0].geometryType, 1234), SET(nv.info.geometryCount, 1))),
    CASE("type_instances", RULE(nv_geometry_type_is_triangles_or_aabbs),
         EDITS(SET(nv.geometries[0].geometryType, VK_GEOMETRY_TYPE_INSTANCES_KHR),
               SET(nv.info.geometryCount, 1))),
    CASE(
        "flags_unknown", RULE(nv_geometry_flags_are_valid),
        EITHER_SET(nv.geometries[1].flags, 1u << 30,
                   VK_GEOMETRY_OPAQUE_BIT_NV | VK_GEOMETRY_NO_DUPLICATE_ANY_HIT_INVOCATION_BIT_NV)),
    CASE("nothing_filled", RULE(nv_geometry_data_is_filled),
         EDITS(SET(NV_TRIANGLES(0).sType, 0), SET(NV_BOXES(0).sType, 0))),
    CASE("nothing_filled_of_boxes", RULE(nv_geometry_data_is_filled), .prepare = scene_nv_use_boxes,
         EDITS(SET(NV_TRIANGLES(0).sType, 0), SET(NV_BOXES(0).sType, 0))),
    CASE("triangles_stype", RULE(nv_triangles_have_their_stype),
         EDITS(SET(NV_TRIANGLES(0).sType, VK_STRUCTURE_TYPE_GEOMETRY_AABB_NV))),
    CASE("boxes_stype", RULE(nv_aabbs_have_their_stype), .prepare = scene_nv_use_boxes,
         EDITS(SET(NV_BOXES(0).sType, 0))),
    CASE("unused_triangles_stype", RULE(nv_unused_triangles_have_their_stype),
         .prepare = scene_nv_use_boxes, EDITS(SET(NV_TRIANGLES(0).sType, 0))),
    CASE("unused_boxes_stype", RULE(nv_unused_aabbs_have_their_stype),
         EDITS(SET(NV_BOXES(1).sType, VK_STRUCTURE_TYPE_GEOMETRY_TRIANGLES_NV))),
    CASE("triangles_chain", RULE(nv_triangles_have_no_chain), EDITS(SET(NV_TRIANGLES(0).pNext, 16)),
         .path = "pInfo->pGeometries[0].geometry.triangles.pNext 0x10"),
    CASE("boxes_chain", RULE(nv_aabbs_have_no_chain), .prepare = scene_nv_use_boxes,
         EDITS(SET(NV_BOXES(0).pNext, 16))),
    CASE("vertices_destroyed", RULE(nv_vertex_data_is_a_valid_buffer),
         EDITS(DESTROY(nv.vertices.handle)), .count = 2),
    CASE("vertices_never_created", RULE(nv_vertex_data_is_a_valid_buffer),
         EITHER_SET(NV_TRIANGLES(1).vertexData, 0x1234567, 0)),
    CASE("vertex_offset_at_the_end", RULE(nv_vertex_offset_is_in_the_buffer),
         EITHER_SET(NV_TRIANGLES(0).vertexOffset, SCENE_BUFFER_SIZE, SCENE_BUFFER_SIZE - 4)),
    CASE("vertex_offset_at_the_end_with_vertices", RULE(nv_vertex_offset_is_in_the_buffer),
         PREPARE_EDITS(SET(NV_TRIANGLES(1).vertexOffset, SCENE_BUFFER_SIZE)),
         TWIN_EDITS(SET(NV_TRIANGLES(1).vertexCount, 0))),
    CASE("vertex_offset_far_behind", RULE(nv_vertex_offset_is_in_the_buffer),
         EDITS(SET(NV_TRIANGLES(0).vertexOffset, UINT64_MAX - 3))),
    CASE("vertex_offset_unaligned", RULE(nv_vertex_offset_is_aligned),
         EITHER_SET(NV_TRIANGLES(1).vertexOffset, 2, 4)),
    CASE("vertex_offset_unaligned_half", RULE(nv_vertex_offset_is_aligned),
         PREPARE_EDITS(SET(NV_TRIANGLES(1).vertexFormat, VK_FORMAT_R16G16_SFLOAT)),
         EITHER_SET(NV_TRIANGLES(1).vertexOffset, 3, 2)),
    CASE("vertex_stride_large", RULE(nv_vertex_stride_fits_32_bits),
         EITHER_SET(NV_TRIANGLES(0).vertexStride, 1ull << 32, UINT32_MAX)),
    CASE("vertex_format_unknown", RULE(nv_vertex_format_is_valid),
         EDITS(SET(NV_TRIANGLES(0).vertexFormat, 12345678))),
    CASE("vertex_format_double", RULE(nv_vertex_format_is_allowed),
         EITHER_SET(NV_TRIANGLES(0).vertexFormat, VK_FORMAT_R64G64B64_SFLOAT,
                    VK_FORMAT_R16G16B16_SNORM)),
    CASE("vertex_format_undefined", RULE(nv_vertex_format_is_allowed),
         EITHER_SET(NV_TRIANGLES(0).vertexFormat, VK_FORMAT_UNDEFINED, VK_FORMAT_R16G16_SNORM)),
    CASE("vertex_format_of_the_other_extension", RULE(nv_vertex_format_is_allowed),
         EITHER_SET(NV_TRIANGLES(0).vertexFormat, VK_FORMAT_R16G16B16A16_SFLOAT,
                    VK_FORMAT_R16G16B16_SFLOAT)),
    CASE("index_type_unknown", RULE(nv_index_type_is_valid),
         EDITS(SET(NV_TRIANGLES(0).indexType, 1234))),
    CASE("index_type_uint8", RULE(nv_index_type_is_16_or_32_bits_or_none),
         EDITS(SET(NV_TRIANGLES(0).indexType, VK_INDEX_TYPE_UINT8)),
         .mutate_twin = use_short_indices),
    CASE("indices_destroyed", RULE(nv_index_data_is_null_or_a_valid_buffer),
         EDITS(DESTROY(nv.indices.handle))),
    CASE("indices_null", RULE(nv_indexed_triangles_have_index_data),
         EDITS(SET(NV_TRIANGLES(0).indexData, 0))),
    CASE("indices_null_with_indices", RULE(nv_indexed_triangles_have_index_data),
         PREPARE_EDITS(SET(NV_TRIANGLES(0).indexData, 0)),
         TWIN_EDITS(SET(NV_TRIANGLES(0).indexCount, 0))),
    CASE("offsets_at_the_end_with_indices",
         RULES(RULE_nv_index_offset_is_in_the_buffer, RULE_nv_transform_offset_is_in_the_buffer),
         PREPARE_EDITS(SET(NV_TRIANGLES(0).indexOffset, SCENE_BUFFER_SIZE),
                       SET(NV_TRIANGLES(0).transformOffset, SCENE_BUFFER_SIZE)),
         TWIN_EDITS(SET(NV_TRIANGLES(0).indexCount, 0))),
    CASE("indices_of_unindexed", RULE(nv_unindexed_triangles_have_no_index_data),
         PREPARE_EDITS(SET(NV_TRIANGLES(0).indexType, VK_INDEX_TYPE_NONE_NV),
                       SET(NV_TRIANGLES(0).indexCount, 0)),
         TWIN_EDITS(SET(NV_TRIANGLES(0).indexData, 0))),
    CASE("index_count_of_unindexed", RULE(nv_unindexed_triangles_have_no_index_count),
         EDITS(SET(NV_TRIANGLES(0).indexType, VK_INDEX_TYPE_NONE_NV),
               SET(NV_TRIANGLES(0).indexData, 0))),
    CASE("index_offset_at_the_end", RULE(nv_index_offset_is_in_the_buffer),
         EITHER_SET(NV_TRIANGLES(0).indexOffset, SCENE_BUFFER_SIZE, SCENE_BUFFER_SIZE - 4)),
    CASE("index_offset_unaligned", RULE(nv_index_offset_is_aligned),
         EITHER_SET(NV_TRIANGLES(0).indexOffset, 2, 4)),
    CASE("index_offset_unaligned_short", RULE(nv_index_offset_is_aligned),
         .prepare = use_short_indices, .mutate = offset_by_a_byte,
         .mutate_twin = offset_by_half_a_word),
    CASE("transform_destroyed", RULE(nv_transform_data_is_a_valid_buffer),
         EDITS(DESTROY(nv.transforms.handle)), TWIN_EDITS(SET(NV_TRIANGLES(0).transformData, 0))),
    CASE("transform_offset_at_the_end", RULE(nv_transform_offset_is_in_the_buffer),
         EITHER_SET(NV_TRIANGLES(0).transformOffset, SCENE_BUFFER_SIZE, SCENE_BUFFER_SIZE - 64)),
    CASE("transform_offset_unaligned", RULE(nv_transform_offset_is_aligned),
         EITHER_SET(NV_TRIANGLES(0).transformOffset, 8, 48)),

    SHARED(RULE(nv_triangles_buffers_share_the_device)),
    CASE("transform_offset_without_transform", RULE(nv_transform_offset_is_aligned),
         PREPARE_EDITS(SET(NV_TRIANGLES(0).transformData, 0)),
         EITHER_SET(NV_TRIANGLES(0).transformOffset, 8, 1 << 20)),
    CASE("vertices_of_another_device", .mutate = use_foreign_vertices),
    CASE("indices_of_another_device", .mutate = use_foreign_indices),
    CASE("transform_of_another_device", .mutate = use_a_foreign_transform,
         .path = "pInfo->pGeometries[0].geometry.triangles.transformData VkBuffer 0x"),

    SHARED(RULE(nv_aabb_data_is_a_valid_buffer), .prepare = scene_nv_use_boxes),
    CASE("boxes_destroyed", EDITS(DESTROY(nv.boxes.handle)), .count = 2),
    CASE("boxes_null", .silent = true, EDITS(SET(NV_BOXES(0).aabbData, 0))),
    CASE("box_offset_at_the_end", RULE(nv_aabb_offset_is_in_the_buffer),
         EITHER_SET(NV_BOXES(0).offset, SCENE_BUFFER_SIZE, SCENE_BUFFER_SIZE - 72)),

    SHARED(),
    CASE("box_offset_at_the_end_with_boxes", RULE(nv_aabb_offset_is_in_the_buffer),
         .prepare = scene_nv_use_boxes, PREPARE_EDITS(SET(NV_BOXES(0).offset, SCENE_BUFFER_SIZE)),
         TWIN_EDITS(SET(NV_BOXES(0).numAABBs, 0))),
    CASE("box_offset_unaligned", RULE(nv_aabb_offset_is_aligned), .prepare = scene_nv_use_boxes,
         EITHER_SET(NV_BOXES(1).offset, 4, 8)),
    CASE("box_stride_unaligned", RULE(nv_aabb_stride_is_aligned), .prepare = scene_nv_use_boxes,
         EITHER_SET(NV_BOXES(1).stride, 28, 32)),
    /* What a type doesn't use is not looked at. */
    CASE("triangles_in_boxes",
         RULES(RULE_nv_vertex_format_is_allowed, RULE_nv_vertex_offset_is_aligned), .silent = true,
         .prepare = scene_nv_use_boxes,
         EDITS(SET(NV_TRIANGLES(0).vertexData, 0x1234567), SET(NV_TRIANGLES(0).vertexOffset, 1),
               SET(NV_TRIANGLES(0).vertexFormat, 12345678),
               SET(NV_TRIANGLES(0).transformOffset, 1))),
    CASE("boxes_in_triangles",
         RULES(RULE_nv_aabb_data_is_a_valid_buffer, RULE_nv_aabb_stride_is_aligned), .silent = true,
         EDITS(SET(NV_BOXES(0).aabbData, 0x1234567), SET(NV_BOXES(0).offset, 1),
               SET(NV_BOXES(0).stride, 1), SET(NV_BOXES(0).numAABBs, 1000))),
};

CASE_LIST(cases_nv_geometry, cases);
