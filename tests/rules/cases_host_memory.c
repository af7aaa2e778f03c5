/* SPDX-License-Identifier: Apache-2.0 */
/* The host memory that host builds read, and use as scratch. */
#include <string.h>

#include "case.h"
#include "placing.h"

#define I_TRIANGLES TRIANGLES(INDEXED, 0)
#define U_TRIANGLES TRIANGLES(UNINDEXED, 0)

/* ---- input data ---- */

#define EDGE(member, size, missing) PUT_AT_EDGE(member.hostAddress, (size) - (missing))
#define NO_PRIMITIVES(build, index) SET(ranges[build][index].primitiveCount, 0)

static void point_to_instances(struct scene *scene, size_t missing)
{
    const void *pointers[3];
    for (size_t i = 0; i < 3; i++)
        pointers[i] = scene->instances.host + i * 64;
    scene->INSTANCES(TLAS, 0).arrayOfPointers = VK_TRUE;
    char *copy = bytes_before_unreadable_page(sizeof(pointers) - missing);
    scene->INSTANCES(TLAS, 0).data.hostAddress = memcpy(copy, pointers, sizeof(pointers) - missing);
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
    CASE("vertices_over_edge", EDITS(EDGE(U_TRIANGLES.vertexData, 6 * 12, 1)),
         TWIN_EDITS(EDGE(U_TRIANGLES.vertexData, 6 * 12, 0))),
    /* Which is inside: one triangle behind the first. */
    CASE("vertices_over_edge_by_offset",
         PREPARE_EDITS(EDGE(U_TRIANGLES.vertexData, 6 * 12, 0),
                       SET(ranges[UNINDEXED][0].firstVertex, 3), SET(U_TRIANGLES.maxVertex, 8)),
         TWIN_EDITS(SET(ranges[UNINDEXED][0].primitiveCount, 1))),
    /* The fourth component of the last vertex is not read. */
    CASE("vertices_with_a_fourth_component", .silent = true,
         EDITS(SET(U_TRIANGLES.vertexFormat, VK_FORMAT_R16G16B16A16_SFLOAT),
               SET(U_TRIANGLES.vertexStride, 8), EDGE(U_TRIANGLES.vertexData, 6 * 8, 2))),

    SHARED(RULE(index_host_address_is_readable)),
    CASE("indices_null", EDITS(SET(I_TRIANGLES.indexData, 0)),
         TWIN_EDITS(SET(U_TRIANGLES.indexData, 0)),
         .path = "pInfos[0].pGeometries[0].geometry.triangles.indexData.hostAddress is NULL"),
    CASE("indices_over_edge", EDITS(EDGE(I_TRIANGLES.indexData, 6 * 4, 1)),
         TWIN_EDITS(EDGE(I_TRIANGLES.indexData, 6 * 4, 0)),
         .path = "pInfos[0].pGeometries[0].geometry.triangles.indexData.hostAddress"),
    CASE("short_indices_over_edge", EDITS(EDGE(TRIANGLES(UNINDEXED, 1).indexData, 6 * 2, 1)),
         TWIN_EDITS(EDGE(TRIANGLES(UNINDEXED, 1).indexData, 6 * 2, 0))),
    CASE("indices_that_are_not_used", .silent = true, EDITS(SET(U_TRIANGLES.indexData, 0x10))),

    SHARED(RULE(transform_host_address_is_null_or_readable)),
    CASE("transform_over_edge", EDITS(EDGE(I_TRIANGLES.transformData, 48, 1)),
         TWIN_EDITS(EDGE(I_TRIANGLES.transformData, 48, 0)),
         .path = "pInfos[0].pGeometries[0].geometry.triangles.transformData.hostAddress"),
    CASE("transform_nowhere", EITHER_SET(TRIANGLES(UNINDEXED, 1).transformData, 0x10, 0)),

    SHARED(RULE(aabb_host_address_is_readable)),
    CASE("boxes_null", EDITS(SET(BOXES(AABBS, 0).data, 0)),
         .path = "pInfos[2].pGeometries[0].geometry.aabbs.data.hostAddress is NULL"),
    CASE("boxes_over_edge", EDITS(EDGE(BOXES(AABBS, 0).data, 3 * 24, 1)),
         TWIN_EDITS(EDGE(BOXES(AABBS, 0).data, 3 * 24, 0)),
         .path = "pInfos[2].pGeometries[0].geometry.aabbs.data.hostAddress"),
    /* The offsets lead over the edge. */
    CASE("boxes_over_edge_by_offset",
         PREPARE_EDITS(EDGE(BOXES(AABBS, 0).data, 3 * 24, 0),
                       SET(ranges[AABBS][0].primitiveOffset, 24)),
         TWIN_EDITS(SET(ranges[AABBS][0].primitiveCount, 2))),

    SHARED(RULE(instance_host_address_is_readable)),
    CASE("instances_null", EDITS(SET(INSTANCES(TLAS, 0).data, 0)),
         .path = "pInfos[3].pGeometries[0].geometry.instances.data.hostAddress is NULL"),
    CASE("instances_over_edge", EDITS(EDGE(INSTANCES(TLAS, 0).data, 3 * 64, 1)),
         TWIN_EDITS(EDGE(INSTANCES(TLAS, 0).data, 3 * 64, 0)),
         .path = "pInfos[3].pGeometries[0].geometry.instances.data.hostAddress"),
    CASE("pointers_over_edge", EITHER_CALL_SIZE(point_to_instances, 1, 0)),

    SHARED(),
    CASE("nowhere_without_primitives",
         RULES(RULE_vertex_host_address_is_readable, RULE_index_host_address_is_readable,
               RULE_transform_host_address_is_null_or_readable, RULE_aabb_host_address_is_readable,
               RULE_instance_host_address_is_readable),
         .silent = true,
         EDITS(UNREADABLE(U_TRIANGLES.vertexData), UNREADABLE(BOXES(AABBS, 0).data),
               UNREADABLE(INSTANCES(TLAS, 0).data), UNREADABLE(TRIANGLES(UNINDEXED, 1).indexData),
               UNREADABLE(TRIANGLES(UNINDEXED, 1).transformData), NO_PRIMITIVES(UNINDEXED, 0),
               NO_PRIMITIVES(UNINDEXED, 1), NO_PRIMITIVES(AABBS, 0), NO_PRIMITIVES(TLAS, 0))),
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
