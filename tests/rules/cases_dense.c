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
static const struct setup without_dense = {.enable = ENABLE_DENSE, .disable = DISABLE_DENSE};
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

/* On the command buffer's commands; and on the host, which takes no such geometry at all. */
#define UPDATE_CASES(name_, rule, member, value)                                                   \
    {.name = name_,                                                                                \
     RULES(rule),                                                                                  \
     .setup = &with_dense,                                                                         \
     .mutate = update_dense,                                                                       \
     .edits = EDITS(SET(dense.member, value)),                                                     \
     .mutate_twin = update_dense,                                                                  \
     .commands = ON_COMMAND_BUFFERS,                                                               \
     .path = DENSE_PATH #member},                                                                  \
    {                                                                                              \
        .name = name_, RULES(rule, RULE_host_build_has_no_dense_geometry), .setup = &with_dense,   \
        .mutate = update_dense, .edits = EDITS(SET(dense.member, value)), .commands = ON_HOST      \
    }

static const struct test_case cases[] = {
    SHARED(.commands = ON_COMMAND_BUFFERS, .refusal = &host_takes_no_dense_geometry,
           .setup = &with_dense, .prepare = add_dense),
    CASE("dense_feature_off", RULES(RULE_dense_geometry_feature_is_enabled),
         .setup = &without_dense, .twin_setup = &with_dense,
         .path = "pInfos[6].pGeometries[0].geometryType"),
    CASE("dense_without_data", RULES(RULE_dense_triangles_have_their_stype),
         .edits = EDITS(SET(geometries[DENSE][0].pNext, 0)), .path = DENSE_PATH "sType"),
    CASE("dense_data_of_other_stype", RULES(RULE_geometry_chain_is_known),
         .edits = EDITS(SET(dense.sType, 0))),
    CASE("dense_data_off_the_page", RULES(RULE_geometry_chain_is_known),
         .mutate = put_data_off_the_page),
    CASE("dense_format_undefined", RULES(RULE_dense_format_is_valid),
         .edits = EDITS(SET(dense.format, 1)), .path = DENSE_PATH "format"),

    SHARED(.commands = ON_COMMAND_BUFFERS, .setup = &with_dense),
    CASE("dense_format_of_the_future",
         RULES(RULE_dense_format_is_valid, RULE_dense_data_is_aligned,
               RULE_dense_data_size_is_aligned),
         .silent = true, .setup = &with_dense_and_future, .mutate = add_dense,
         .edits = EDITS(SET(dense.format, 1), SET(dense.dataSize, 100), ADD(ADDRESS, 4))),
    CASE("dense_address_null", RULES(RULE_dense_data_is_valid),
         .refusal = &host_takes_no_dense_geometry, .prepare = add_dense,
         .edits = EDITS(SET(ADDRESS, 0)), .path = DENSE_PATH "compressedData.hostAddress"),
    CASE("dense_address_null_with_triangles", RULES(RULE_dense_data_is_valid),
         .refusal = &host_takes_no_dense_geometry, .prepare = add_dense,
         .edits = EDITS(SET(ADDRESS, 0)),
         .twin_edits = EDITS(SET(ADDRESS, 0), SET(dense.numTriangles, 0))),
    CASE("dense_address_nowhere_with_triangles", RULES(RULE_input_address_is_in_a_buffer),
         .prepare = add_dense, .edits = EDITS(SET(ADDRESS, WILD)),
         .twin_edits = EDITS(SET(ADDRESS, WILD), SET(dense.dataSize, 0))),
    CASE("dense_buffer_without_usage_with_triangles",
         RULES(RULE_dense_buffer_has_compressed_data_usage), .prepare = add_dense_without_usage,
         .twin_edits = EDITS(SET(dense.numTriangles, 0))),
    CASE("dense_address_nowhere", RULES(RULE_input_address_is_in_a_buffer), .prepare = add_dense,
         .edits = EDITS(SET(ADDRESS, WILD)), .path = DENSE_PATH "compressedData.deviceAddress"),
    CASE("dense_address_past_the_end", RULES(RULE_input_address_is_in_a_buffer),
         .prepare = add_dense, .edits = EDITS(ADD(ADDRESS, SCENE_BUFFER_SIZE))),
    CASE("dense_address_in_freed_memory", RULES(RULE_input_buffer_is_bound),
         .mutate = add_dense_in_freed_memory, .mutate_twin = add_dense),
    CASE("dense_address_misaligned", RULES(RULE_dense_data_is_aligned),
         .refusal = &host_takes_no_dense_geometry, .prepare = add_dense,
         .edits = EDITS(ADD(ADDRESS, 64)), .twin_edits = EDITS(ADD(ADDRESS, 128)),
         .path = DENSE_PATH "compressedData.hostAddress"),
    CASE("dense_data_size_misaligned", RULES(RULE_dense_data_size_is_aligned),
         .refusal = &host_takes_no_dense_geometry, .prepare = add_dense,
         .edits = EDITS(SET(dense.dataSize, 192)), .twin_edits = EDITS(SET(dense.dataSize, 0)),
         .path = DENSE_PATH "dataSize"),
    CASE("dense_buffer_without_usage", RULES(RULE_dense_buffer_has_compressed_data_usage),
         .mutate = add_dense_without_usage, .mutate_twin = add_dense,
         .path = DENSE_PATH "compressedData.deviceAddress"),
    CASE("dense_geometry_twice", RULES(RULE_dense_geometry_is_alone),
         .refusal = &host_takes_no_dense_geometry, .prepare = add_dense,
         .mutate = double_the_geometry, .path = "pInfos[6].geometryCount"),

    SHARED(),
    CASE("dense_geometry_with_build_ranges", RULES(RULE_dense_geometry_has_no_build_ranges),
         .setup = &with_dense, .prepare = add_dense,
         .edits = EDITS(POINT(range_pointers[DENSE], ranges[DENSE])), .path = "pInfos[6]"),
    CASE("dense_geometry_built_by_the_host", RULES(RULE_host_build_has_no_dense_geometry),
         .setup = &with_dense, .mutate = add_dense,
         .path = "pInfos[6].pGeometries[0].geometryType"),
    /* What builds need is asked of the driver for these, too. */
    CASE("dense_dst_too_small", RULES(RULE_dst_is_large_enough), .commands = ON_DEVICE,
         .setup = &with_dense, .prepare = add_dense, .mutate = build_into_too_little,
         .path = "pInfos[6].dstAccelerationStructure"),

    UPDATE_CASES("dense_triangle_count_of_update", RULE_dense_triangle_count_matches_source,
                 numTriangles, 63),
    UPDATE_CASES("dense_vertex_count_of_update", RULE_dense_vertex_count_matches_source,
                 numVertices, 95),
    UPDATE_CASES("dense_max_primitive_index_of_update",
                 RULE_dense_max_primitive_index_matches_source, maxPrimitiveIndex, 62),
    UPDATE_CASES("dense_max_geometry_index_of_update", RULE_dense_max_geometry_index_matches_source,
                 maxGeometryIndex, 0),
    UPDATE_CASES("dense_data_size_of_update", RULE_dense_data_size_matches_source, dataSize, 896),
    CASE("dense_format_of_update", RULES(RULE_dense_format_matches_source),
         .commands = ON_COMMAND_BUFFERS, .setup = &with_dense_and_future, .prepare = update_dense,
         .edits = EDITS(SET(dense.format, 1)), .path = DENSE_PATH "format"),
    CASE("dense_format_of_update",
         RULES(RULE_dense_format_matches_source, RULE_host_build_has_no_dense_geometry),
         .commands = ON_HOST, .setup = &with_dense_and_future, .mutate = update_dense,
         .edits = EDITS(SET(dense.format, 1))),
    CASE("dense_format_undefined_in_update",
         RULES(RULE_dense_format_matches_source, RULE_dense_format_is_valid),
         .commands = ON_COMMAND_BUFFERS, .refusal = &host_takes_no_dense_geometry,
         .setup = &with_dense, .prepare = update_dense, .edits = EDITS(SET(dense.format, 1)),
         .path = DENSE_PATH "format"),
    /* The layer knows nothing of a source whose data it could not read. */
    CASE("dense_update_of_source_without_data",
         RULES(RULE_dense_triangle_count_matches_source, RULE_dense_data_size_matches_source),
         .silent = true, .commands = ON_COMMAND_BUFFERS, .setup = &with_dense, .mutate = add_dense,
         .edits = EDITS(SET(geometries[DENSE][0].pNext, 0), CALL(build_then_update),
                        POINT(geometries[DENSE][0].pNext, dense))),
};

CASE_LIST(cases_dense, cases);
