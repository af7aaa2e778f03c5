/* SPDX-License-Identifier: Apache-2.0 */
/* The host memory that host builds read, and use as scratch. */
#include <string.h>

#include "case.h"
#include "placing.h"

#define I_TRIANGLES TRIANGLES(INDEXED, 0)
#define U_TRIANGLES TRIANGLES(UNINDEXED, 0)

/* ---- input data ---- */

/* A copy of `size` bytes at the edge of what can be read, less the last `missing` of them. */
static void *at_edge(const void *data, size_t size, size_t missing)
{
    char *copy = bytes_before_unreadable_page(size - missing);
    return memcpy(copy, data, size - missing);
}

#define PUT_AT_EDGE(name, place, buffer, size)                                                     \
    static void put_##name##_at_edge(struct scene *scene)                                          \
    {                                                                                              \
        scene->place.hostAddress = at_edge(scene->buffer.host, size, 0);                           \
    }                                                                                              \
    static void put_##name##_over_edge(struct scene *scene)                                        \
    {                                                                                              \
        scene->place.hostAddress = at_edge(scene->buffer.host, size, 1);                           \
    }

PUT_AT_EDGE(vertices, U_TRIANGLES.vertexData, vertices, 6 * 12)
PUT_AT_EDGE(indices, I_TRIANGLES.indexData, indices, 6 * 4)
PUT_AT_EDGE(short_indices, TRIANGLES(UNINDEXED, 1).indexData, indices, 6 * 2)
PUT_AT_EDGE(transform, I_TRIANGLES.transformData, transforms, 48)
PUT_AT_EDGE(boxes, BOXES(AABBS, 0).data, boxes, 3 * 24)
PUT_AT_EDGE(instances, INSTANCES(TLAS, 0).data, instances, 3 * 64)

static void point_to_instances(struct scene *scene, size_t missing)
{
    const void *pointers[3];
    for (size_t i = 0; i < 3; i++)
        pointers[i] = scene->instances.host + i * 64;
    scene->INSTANCES(TLAS, 0).arrayOfPointers = VK_TRUE;
    scene->INSTANCES(TLAS, 0).data.hostAddress = at_edge(pointers, sizeof(pointers), missing);
}

static void put_all_nowhere_without_primitives(struct scene *scene)
{
    scene->U_TRIANGLES.vertexData.hostAddress = unreadable_page();
    scene->BOXES(AABBS, 0).data.hostAddress = unreadable_page();
    scene->INSTANCES(TLAS, 0).data.hostAddress = unreadable_page();
    scene->TRIANGLES(UNINDEXED, 1).indexData.hostAddress = unreadable_page();
    scene->TRIANGLES(UNINDEXED, 1).transformData.hostAddress = unreadable_page();
    scene->ranges[UNINDEXED][0].primitiveCount = scene->ranges[UNINDEXED][1].primitiveCount = 0;
    scene->ranges[AABBS][0].primitiveCount = scene->ranges[TLAS][0].primitiveCount = 0;
}

/* The fourth component of the last vertex is not read. */
static void put_wide_vertices_at_edge(struct scene *scene)
{
    scene->U_TRIANGLES.vertexFormat = VK_FORMAT_R16G16B16A16_SFLOAT;
    scene->U_TRIANGLES.vertexStride = 8;
    scene->U_TRIANGLES.vertexData.hostAddress = at_edge(scene->vertices.host, 6 * 8, 2);
}

/* ---- scratch ---- */

static void put_scratch_at_edge_of(struct scene *scene, uint32_t build, size_t missing)
{
    scene->infos[build].scratchData.hostAddress =
        bytes_before_unreadable_page((size_t)scene_scratch_size(scene, build) - missing);
}

/* Scratch that is no VkDeviceMemory at all. */
static void put_scratch_in_own_memory(struct scene *scene, uint32_t shared_bytes)
{
    const size_t first = (size_t)scene_scratch_size(scene, INDEXED);
    const size_t second = (size_t)scene_scratch_size(scene, AABBS);
    char *bytes = bytes_before_unreadable_page(first + second);
    scene->infos[INDEXED].scratchData.hostAddress = bytes;
    scene->infos[AABBS].scratchData.hostAddress = bytes + first - shared_bytes;
}

/* The same bytes, but no host memory any more that anything is known of. */
static void unmap_shared_scratch(struct scene *scene)
{
    const struct test_buffer buffer = place_buffer(scene);
    place_dst(scene, INDEXED, &buffer, 0);
    place_scratch(scene, INDEXED, &buffer, 0);
    scene->vk->UnmapMemory(scene->fixture->device, buffer.memory);
}

static const struct test_case cases[] = {
    SHARED(RULE(vertex_host_address_is_readable)),
    CASE("vertices_null", EDITS(SET(U_TRIANGLES.vertexData, 0)),
         .path = "pInfos[1].pGeometries[0].geometry.triangles.vertexData.hostAddress is NULL"),
    CASE("vertices_nowhere", EDITS(SET(U_TRIANGLES.vertexData, 0x10)),
         .path = "pInfos[1].pGeometries[0].geometry.triangles.vertexData.hostAddress 0x10"),
    CASE("indexed_vertices_nowhere", EDITS(SET(I_TRIANGLES.vertexData, 0x10)),
         .path = "pInfos[0].pGeometries[0].geometry.triangles.vertexData.hostAddress"),
    CASE("vertices_over_edge", .mutate = put_vertices_over_edge,
         .mutate_twin = put_vertices_at_edge),
    /* Which is inside: one triangle behind the first. */
    CASE("vertices_over_edge_by_offset", .prepare = put_vertices_at_edge,
         PREPARE_EDITS(SET(ranges[UNINDEXED][0].firstVertex, 3), SET(U_TRIANGLES.maxVertex, 8)),
         TWIN_EDITS(SET(ranges[UNINDEXED][0].primitiveCount, 1))),
    CASE("vertices_with_a_fourth_component", .silent = true, .mutate = put_wide_vertices_at_edge),
    CASE("indices_null", RULE(index_host_address_is_readable), EDITS(SET(I_TRIANGLES.indexData, 0)),
         TWIN_EDITS(SET(U_TRIANGLES.indexData, 0)),
         .path = "pInfos[0].pGeometries[0].geometry.triangles.indexData.hostAddress is NULL"),
    CASE("indices_over_edge", RULE(index_host_address_is_readable), .mutate = put_indices_over_edge,
         .mutate_twin = put_indices_at_edge,
         .path = "pInfos[0].pGeometries[0].geometry.triangles.indexData.hostAddress"),
    CASE("short_indices_over_edge", RULE(index_host_address_is_readable),
         .mutate = put_short_indices_over_edge, .mutate_twin = put_short_indices_at_edge),
    CASE("indices_that_are_not_used", RULE(index_host_address_is_readable), .silent = true,
         EDITS(SET(U_TRIANGLES.indexData, 0x10))),

    SHARED(RULE(aabb_host_address_is_readable)),
    CASE("transform_over_edge", RULE(transform_host_address_is_null_or_readable),
         .mutate = put_transform_over_edge, .mutate_twin = put_transform_at_edge,
         .path = "pInfos[0].pGeometries[0].geometry.triangles.transformData.hostAddress"),
    CASE("transform_nowhere", RULE(transform_host_address_is_null_or_readable),
         EITHER_SET(TRIANGLES(UNINDEXED, 1).transformData, 0x10, 0)),
    CASE("boxes_null", EDITS(SET(BOXES(AABBS, 0).data, 0)),
         .path = "pInfos[2].pGeometries[0].geometry.aabbs.data.hostAddress is NULL"),
    CASE("boxes_over_edge", .mutate = put_boxes_over_edge, .mutate_twin = put_boxes_at_edge,
         .path = "pInfos[2].pGeometries[0].geometry.aabbs.data.hostAddress"),
    /* The offsets lead over the edge. */
    CASE("boxes_over_edge_by_offset", .prepare = put_boxes_at_edge,
         PREPARE_EDITS(SET(ranges[AABBS][0].primitiveOffset, 24)),
         TWIN_EDITS(SET(ranges[AABBS][0].primitiveCount, 2))),

    SHARED(RULE(instance_host_address_is_readable)),
    CASE("instances_null", EDITS(SET(INSTANCES(TLAS, 0).data, 0)),
         .path = "pInfos[3].pGeometries[0].geometry.instances.data.hostAddress is NULL"),
    CASE("instances_over_edge", .mutate = put_instances_over_edge,
         .mutate_twin = put_instances_at_edge,
         .path = "pInfos[3].pGeometries[0].geometry.instances.data.hostAddress"),
    CASE("pointers_over_edge", EITHER_CALL_SIZE(point_to_instances, 1, 0)),

    SHARED(),
    CASE("nowhere_without_primitives",
         RULES(RULE_vertex_host_address_is_readable, RULE_index_host_address_is_readable,
               RULE_transform_host_address_is_null_or_readable, RULE_aabb_host_address_is_readable,
               RULE_instance_host_address_is_readable),
         .silent = true, .mutate = put_all_nowhere_without_primitives),
    CASE("scratch_null", RULE(build_scratch_is_host_memory),
         EDITS(SET(infos[AABBS].scratchData, 0)), .path = "pInfos[2].scratchData.hostAddress 0x0"),
    CASE("scratch_over_edge", RULE(build_scratch_is_host_memory),
         EITHER_CALL_FOR(put_scratch_at_edge_of, AABBS, 1, 0),
         .path = "pInfos[2].scratchData.hostAddress"),
    CASE("scratch_of_update_null", RULE(update_scratch_is_host_memory),
         EDITS(SET(infos[REFIT].scratchData, 0)), .path = "pInfos[5].scratchData.hostAddress 0x0"),
    CASE("scratch_of_update_over_edge", RULE(update_scratch_is_host_memory),
         EITHER_CALL_FOR(put_scratch_at_edge_of, REFIT, 1, 0),
         .path = "pInfos[5].scratchData.hostAddress"),
    CASE("scratch_shared_in_own_memory", RULE(scratch_and_scratch_are_apart), .commands = ON_HOST,
         EITHER_CALL(put_scratch_in_own_memory, 1, 0),
         .path = "pInfos[0].scratchData shares host memory [0x"),
    CASE("scratch_in_memory_unmapped", RULE(dst_and_scratch_are_apart), .silent = true,
         .commands = ON_HOST, .mutate = unmap_shared_scratch, .needs_null_driver = true),
};

CASE_LIST(cases_host_memory, cases);
