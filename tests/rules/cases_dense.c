/* SPDX-License-Identifier: Apache-2.0 */
/* VK_AMDX_dense_geometry_format: builds of compressed triangles, and their updates. */
#include "case.h"
#include "placing.h"

#define DENSE_PATH                                                                                 \
    "pInfos[6].pGeometries[0]."                                                                    \
    "pNext<VkAccelerationStructureDenseGeometryFormatTrianglesDataAMDX>."
#define ADDRESS dense.compressedData.deviceAddress
#define WILD 0x7000000000ull

/* The build that the functions below add. */
enum { DENSE = SCENE_BASE_BUILDS };

static const struct setup with_dense = {.enable = ENABLE_DENSE};
static const struct setup with_dense_and_future = {.enable = ENABLE_DENSE | ENABLE_FUTURE};

/* ---- builds */

static void add_build(struct scene *scene, const struct test_buffer *buffer)
{
    scene_add_build(scene, UNINDEXED);
    scene->infos[DENSE].geometryCount = 1;
    scene->dense = (VkAccelerationStructureDenseGeometryFormatTrianglesDataAMDX){
        .sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_DENSE_GEOMETRY_FORMAT_TRIANGLES_DATA_AMDX,
        .compressedData.deviceAddress = scene_address(scene, buffer, 0),
        .dataSize = 1024,
        .numTriangles = 64,
        .numVertices = 96,
        .maxPrimitiveIndex = 63,
        .maxGeometryIndex = 1,
        .format = VK_COMPRESSED_TRIANGLE_FORMAT_DGF1_AMDX,
    };
    scene->geometries[DENSE][0] = (VkAccelerationStructureGeometryKHR){
        .sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_KHR,
        .pNext = &scene->dense,
        .geometryType = VK_GEOMETRY_TYPE_DENSE_GEOMETRY_FORMAT_TRIANGLES_AMDX,
    };
    /* So that the sizes are those of so many triangles; no range is given. */
    scene->ranges[DENSE][0].primitiveCount = scene->dense.numTriangles;
    scene_give_objects(scene, DENSE);
    if (scene->command != COMMAND_HOST) /* which requires a pointer */
        scene->range_pointers[DENSE] = NULL;
}

static void add_dense(struct scene *scene)
{
    const struct test_buffer buffer = scene_dense_buffer(scene, DENSE_USAGE);
    add_build(scene, &buffer);
}

static void add_dense_without_usage(struct scene *scene)
{
    const struct test_buffer buffer = scene_dense_buffer(
        scene, VK_BUFFER_USAGE_2_ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_BIT_KHR);
    add_build(scene, &buffer);
}

static void add_dense_in_freed_memory(struct scene *scene)
{
    const struct test_buffer buffer = scene_dense_buffer(scene, DENSE_USAGE);
    add_build(scene, &buffer);
    scene_destroy(scene, (uint64_t)buffer.memory);
}

static void double_the_geometry(struct scene *scene)
{
    scene->geometries[DENSE][1] = scene->geometries[DENSE][0];
    scene->ranges[DENSE][1] = scene->ranges[DENSE][0];
    scene->infos[DENSE].geometryCount = 2;
    scene_give_objects(scene, DENSE);
}

static void build_into_too_little(struct scene *scene)
{
    scene->infos[DENSE].dstAccelerationStructure =
        scene_accel_in(scene, &scene->dst_buffers[DENSE], 0, place_size(scene, DENSE) - 1,
                       VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR);
}

/* The structure begins where it can be read and ends where it can't. */
static void put_data_off_the_page(struct scene *scene)
{
    VkBaseOutStructure *cut = bytes_before_unreadable_page(sizeof(*cut));
    cut->sType = scene->dense.sType;
    scene->geometries[DENSE][0].pNext = cut;
}

/* ---- updates of what an earlier command built */

/* A host build of the source is reported, too, but that is not what the case is about. */
static void build_then_update(struct scene *scene)
{
    if (scene->fixture->fails && scene->command == COMMAND_HOST) {
        scene->skip = "debug_action = fail lets no such call pass";
        return;
    }
    scene_build_before(scene, DENSE, 1);
    messages_clear(&scene->fixture->messages);
    scene->infos[DENSE].mode = VK_BUILD_ACCELERATION_STRUCTURE_MODE_UPDATE_KHR;
    scene->infos[DENSE].srcAccelerationStructure = scene->infos[DENSE].dstAccelerationStructure;
}

static void update_dense(struct scene *scene)
{
    add_dense(scene);
    build_then_update(scene);
}

static const struct test_case cases[] = {
    SHARED(.commands = ON_COMMAND_BUFFERS, .refusal = &host_takes_no_dense_geometry,
           .setup = &with_dense, .prepare = add_dense),
    CASE("dense_feature_off", RULE(dense_geometry_feature_is_enabled),
         SETUP(.enable = ENABLE_DENSE, .disable = DISABLE_DENSE), .twin_setup = &with_dense,
         .path = "pInfos[6].pGeometries[0].geometryType"),
    CASE("dense_without_data", RULE(dense_triangles_have_their_stype),
         EDITS(SET(geometries[DENSE][0].pNext, 0)), .path = DENSE_PATH "sType"),
    CASE("dense_data_of_other_stype", RULE(geometry_chain_is_known), EDITS(SET(dense.sType, 0))),
    CASE("dense_data_off_the_page", RULE(geometry_chain_is_known), .mutate = put_data_off_the_page),
    CASE("dense_format_undefined", RULE(dense_format_is_valid), EDITS(SET(dense.format, 1)),
         .path = DENSE_PATH "format"),

    SHARED(.commands = ON_COMMAND_BUFFERS, .setup = &with_dense),
    CASE("dense_format_of_the_future",
         RULES(RULE_dense_format_is_valid, RULE_dense_data_is_aligned,
               RULE_dense_data_size_is_aligned),
         .silent = true, .setup = &with_dense_and_future, .mutate = add_dense,
         EDITS(SET(dense.format, 1), SET(dense.dataSize, 100), ADD(ADDRESS, 4))),
    CASE("dense_address_null", RULE(dense_data_is_valid), .refusal = &host_takes_no_dense_geometry,
         .prepare = add_dense, EDITS(SET(ADDRESS, 0)),
         .path = DENSE_PATH "compressedData.hostAddress"),
    CASE("dense_address_null_with_triangles", RULE(dense_data_is_valid),
         .refusal = &host_takes_no_dense_geometry, .prepare = add_dense,
         PREPARE_EDITS(SET(ADDRESS, 0)), TWIN_EDITS(SET(dense.numTriangles, 0))),
    CASE("dense_address_nowhere_with_triangles", RULE(input_address_is_in_a_buffer),
         .prepare = add_dense, PREPARE_EDITS(SET(ADDRESS, WILD)),
         TWIN_EDITS(SET(dense.dataSize, 0))),
    CASE("dense_buffer_without_usage_with_triangles", RULE(dense_buffer_has_compressed_data_usage),
         .prepare = add_dense_without_usage, TWIN_EDITS(SET(dense.numTriangles, 0))),
    CASE("dense_address_nowhere", RULE(input_address_is_in_a_buffer), .prepare = add_dense,
         EDITS(SET(ADDRESS, WILD)), .path = DENSE_PATH "compressedData.deviceAddress"),
    CASE("dense_address_past_the_end", RULE(input_address_is_in_a_buffer), .prepare = add_dense,
         EDITS(ADD(ADDRESS, SCENE_BUFFER_SIZE))),
    CASE("dense_address_in_freed_memory", RULE(input_buffer_is_bound),
         .mutate = add_dense_in_freed_memory, .mutate_twin = add_dense),
    CASE("dense_address_misaligned", RULE(dense_data_is_aligned),
         .refusal = &host_takes_no_dense_geometry, .prepare = add_dense,
         EITHER_ADD(ADDRESS, 64, 128), .path = DENSE_PATH "compressedData.hostAddress"),
    CASE("dense_data_size_misaligned", RULE(dense_data_size_is_aligned),
         .refusal = &host_takes_no_dense_geometry, .prepare = add_dense,
         EITHER_SET(dense.dataSize, 192, 0), .path = DENSE_PATH "dataSize"),
    CASE("dense_buffer_without_usage", RULE(dense_buffer_has_compressed_data_usage),
         .mutate = add_dense_without_usage, .mutate_twin = add_dense,
         .path = DENSE_PATH "compressedData.deviceAddress"),
    CASE("dense_geometry_twice", RULE(dense_geometry_is_alone),
         .refusal = &host_takes_no_dense_geometry, .prepare = add_dense,
         .mutate = double_the_geometry, .path = "pInfos[6].geometryCount"),

    SHARED(.setup = &with_dense),
    CASE("dense_geometry_with_build_ranges", RULE(dense_geometry_has_no_build_ranges),
         .prepare = add_dense, EDITS(POINT(range_pointers[DENSE], ranges[DENSE])),
         .path = "pInfos[6]"),
    CASE("dense_geometry_built_by_the_host", RULE(host_build_has_no_dense_geometry),
         .mutate = add_dense, .path = "pInfos[6].pGeometries[0].geometryType"),
    /* What builds need is asked of the driver for these, too. */
    CASE("dense_dst_too_small", RULE(dst_is_large_enough), .commands = ON_DEVICE,
         .prepare = add_dense, .mutate = build_into_too_little,
         .path = "pInfos[6].dstAccelerationStructure"),
    CASE("dense_triangle_count_of_update", RULE(dense_triangle_count_matches_source),
         .commands = ON_COMMAND_BUFFERS, .prepare = update_dense,
         EDITS(SET(dense.numTriangles, 63)), .path = DENSE_PATH "numTriangles"),
    CASE("dense_triangle_count_of_update",
         RULES(RULE_dense_triangle_count_matches_source, RULE_host_build_has_no_dense_geometry),
         .commands = ON_HOST, .mutate = update_dense, EDITS(SET(dense.numTriangles, 63))),
    CASE("dense_vertex_count_of_update", RULE(dense_vertex_count_matches_source),
         .commands = ON_COMMAND_BUFFERS, .prepare = update_dense, EDITS(SET(dense.numVertices, 95)),
         .path = DENSE_PATH "numVertices"),
    CASE("dense_vertex_count_of_update",
         RULES(RULE_dense_vertex_count_matches_source, RULE_host_build_has_no_dense_geometry),
         .commands = ON_HOST, .mutate = update_dense, EDITS(SET(dense.numVertices, 95))),

    SHARED(.commands = ON_COMMAND_BUFFERS, .setup = &with_dense),
    CASE("dense_max_primitive_index_of_update", RULE(dense_max_primitive_index_matches_source),
         .prepare = update_dense, EDITS(SET(dense.maxPrimitiveIndex, 62)),
         .path = DENSE_PATH "maxPrimitiveIndex"),
    CASE(
        "dense_max_primitive_index_of_update",
        RULES(RULE_dense_max_primitive_index_matches_source, RULE_host_build_has_no_dense_geometry),
        .commands = ON_HOST, .mutate = update_dense, EDITS(SET(dense.maxPrimitiveIndex, 62))),
    CASE("dense_max_geometry_index_of_update", RULE(dense_max_geometry_index_matches_source),
         .prepare = update_dense, EDITS(SET(dense.maxGeometryIndex, 0)),
         .path = DENSE_PATH "maxGeometryIndex"),
    CASE("dense_max_geometry_index_of_update",
         RULES(RULE_dense_max_geometry_index_matches_source, RULE_host_build_has_no_dense_geometry),
         .commands = ON_HOST, .mutate = update_dense, EDITS(SET(dense.maxGeometryIndex, 0))),
    CASE("dense_data_size_of_update", RULE(dense_data_size_matches_source), .prepare = update_dense,
         EDITS(SET(dense.dataSize, 896)), .path = DENSE_PATH "dataSize"),
    CASE("dense_data_size_of_update",
         RULES(RULE_dense_data_size_matches_source, RULE_host_build_has_no_dense_geometry),
         .commands = ON_HOST, .mutate = update_dense, EDITS(SET(dense.dataSize, 896))),
    CASE("dense_format_of_update", RULE(dense_format_matches_source),
         .setup = &with_dense_and_future, .prepare = update_dense, EDITS(SET(dense.format, 1)),
         .path = DENSE_PATH "format"),
    CASE("dense_format_of_update",
         RULES(RULE_dense_format_matches_source, RULE_host_build_has_no_dense_geometry),
         .commands = ON_HOST, .setup = &with_dense_and_future, .mutate = update_dense,
         EDITS(SET(dense.format, 1))),
    CASE("dense_format_undefined_in_update",
         RULES(RULE_dense_format_matches_source, RULE_dense_format_is_valid),
         .refusal = &host_takes_no_dense_geometry, .prepare = update_dense,
         EDITS(SET(dense.format, 1)), .path = DENSE_PATH "format"),
    /* The layer knows nothing of a source whose data it could not read. */
    CASE("dense_update_of_source_without_data",
         RULES(RULE_dense_triangle_count_matches_source, RULE_dense_data_size_matches_source),
         .silent = true, .mutate = add_dense,
         EDITS(SET(geometries[DENSE][0].pNext, 0), CALL(build_then_update),
               POINT(geometries[DENSE][0].pNext, dense))),
};

CASE_LIST(cases_dense, cases);
