/* SPDX-License-Identifier: Apache-2.0 */
/* Geometries without primitives: a build reads no data of them, so their addresses are not
 * validated. Each case breaks a rule about an address; its twin does the same with a primitive
 * count (of the indirect command: a maximum) of 0. */
#include "addresses.h"

#define NO_PRIMITIVES(build, index) SET(ranges[build][index].primitiveCount, 0)

#define FORGET_ALL_PRIMITIVES                                                                      \
    NO_PRIMITIVES(INDEXED, 0), NO_PRIMITIVES(AABBS, 0), NO_PRIMITIVES(TLAS, 0)
#define LIKE_VERTICES                                                                              \
    COPY(INDEX, VERTEX), COPY(TRANSFORM, VERTEX), COPY(BOX, VERTEX), COPY(INSTANCE, VERTEX)
#define ALL_ADDRESSES(function) MAKE_ADDRESS(VERTEX, function), LIKE_VERTICES

/* A maximum says how many are read at most, so that a count of 0 in device memory excuses nothing.
 */
static void lose_vertices_below_a_maximum(struct scene *scene)
{
    static const uint32_t maxima[SCENE_GEOMETRIES] = {1, 1};
    scene->UNINDEXED_VERTEX = 0;
    scene->ranges[UNINDEXED][0].primitiveCount = 0;
    scene->count_pointers[UNINDEXED] = maxima;
}

/* ---- extensions ---- */

static void use_nv_instances_of_another_usage(struct scene *scene)
{
    scene_nv_use_instances(scene);
    scene->nv.instance_data =
        scene_buffer(scene, SCENE_BUFFER_SIZE, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT).handle;
}

static const struct test_case cases[] = {
    SHARED(.commands = ON_COMMAND_BUFFERS, TWIN_EDITS(NO_PRIMITIVES(INDEXED, 0))),
    CASE("no_vertex_address", RULE(vertex_address_is_given), PREPARE_EDITS(SET(VERTEX, 0))),
    CASE("no_index_address", RULE(index_address_is_given), PREPARE_EDITS(SET(INDEX, 0))),

    SHARED(.commands = ON_COMMAND_BUFFERS),
    CASE("no_box_address", RULE(aabb_address_is_given), PREPARE_EDITS(SET(BOX, 0)),
         TWIN_EDITS(NO_PRIMITIVES(AABBS, 0))),
    CASE("no_instance_address", RULE(instance_address_is_given), PREPARE_EDITS(SET(INSTANCE, 0)),
         TWIN_EDITS(NO_PRIMITIVES(TLAS, 0))),
    CASE("no_instance_pointers", RULE(instance_address_is_given),
         PREPARE_EDITS(SET(INSTANCE, 0), SET(INSTANCES(TLAS, 0).arrayOfPointers, VK_TRUE)),
         TWIN_EDITS(NO_PRIMITIVES(TLAS, 0))),
    CASE("vertices_nowhere", RULE(input_address_is_in_a_buffer), PREPARE_EDITS(SET(VERTEX, WILD)),
         TWIN_EDITS(NO_PRIMITIVES(INDEXED, 0))),
    CASE("indices_nowhere", RULE(input_address_is_in_a_buffer), PREPARE_EDITS(SET(INDEX, WILD)),
         TWIN_EDITS(NO_PRIMITIVES(INDEXED, 0))),
    CASE("transform_nowhere", RULE(transform_address_is_valid), PREPARE_EDITS(SET(TRANSFORM, WILD)),
         TWIN_EDITS(NO_PRIMITIVES(INDEXED, 0))),
    CASE("boxes_nowhere", RULE(input_address_is_in_a_buffer), PREPARE_EDITS(SET(BOX, WILD)),
         TWIN_EDITS(NO_PRIMITIVES(AABBS, 0))),
    CASE("instances_nowhere", RULE(input_address_is_in_a_buffer),
         PREPARE_EDITS(SET(INSTANCE, WILD)), TWIN_EDITS(NO_PRIMITIVES(TLAS, 0))),

    SHARED(.commands = ON_COMMAND_BUFFERS, TWIN_EDITS(FORGET_ALL_PRIMITIVES)),
    CASE("all_in_freed_memory", RULE(input_buffer_is_bound),
         PREPARE_EDITS(ALL_ADDRESSES(scene_freed_address)), .count = 5),
    CASE("all_in_a_destroyed_buffer",
         RULES(RULE_input_address_is_in_a_buffer, RULE_transform_address_is_valid),
         PREPARE_EDITS(ALL_ADDRESSES(scene_destroyed_address)), .count = 4),
    CASE("all_without_usage", RULE(input_buffer_has_build_input_usage),
         PREPARE_EDITS(ALL_ADDRESSES(scene_address_without_usage)), .count = 5),

    SHARED(.commands = ON_INDIRECT),
    /* The second geometry of the build has triangles. */
    CASE("second_geometry_is_read", RULE(input_address_is_in_a_buffer),
         .commands = ON_COMMAND_BUFFERS, PREPARE_EDITS(SET(UNINDEXED_VERTEX, WILD)),
         EDITS(SET(SHORT_INDEX, WILD), NO_PRIMITIVES(UNINDEXED, 0)),
         TWIN_EDITS(NO_PRIMITIVES(UNINDEXED, 0)), .count = 1,
         .path = "pInfos[1].pGeometries[1].geometry.triangles.indexData.deviceAddress"),
    CASE("maximum_of_1", RULE(vertex_address_is_given), .mutate = lose_vertices_below_a_maximum,
         EDITS(NO_PRIMITIVES(UNINDEXED, 0))),
    CASE("ranges_without_usage", RULE(indirect_buffer_has_indirect_usage),
         PREPARE_EDITS(MAKE_ADDRESS(indirect_addresses[AABBS], scene_address_without_usage)),
         TWIN_EDITS(SET(infos[AABBS].geometryCount, 0))),

    SHARED(.commands = ON_COMMAND_BUFFERS, SETUP(.enable = ENABLE_OPACITY_MICROMAP_KHR),
           .prepare = scene_use_micromap, TWIN_EDITS(NO_PRIMITIVES(INDEXED, 0))),
    CASE("micromap_indices_at_0", RULE(opacity_index_buffer_is_given),
         PREPARE_EDITS(SET(micromaps.opacity.indexBuffer, 0))),
    CASE("micromap_indices_unbound", RULE(input_buffer_is_bound),
         PREPARE_EDITS(MAKE_ADDRESS(micromaps.opacity.indexBuffer, scene_freed_address))),

    SHARED(),
    CASE("ext_indices_at_0", RULE(ext_opacity_index_address_is_given),
         SETUP(.enable = ENABLE_OPACITY_MICROMAP_EXT), .prepare = scene_use_micromap_ext,
         PREPARE_EDITS(SET(micromaps.opacity_ext.indexBuffer, 0)),
         TWIN_EDITS(NO_PRIMITIVES(INDEXED, 0))),
    CASE("nv_instances_of_another_usage", RULE(nv_instance_data_has_ray_tracing_usage),
         NAMES(RULE_nv_info_instance_data_has_ray_tracing_usage),
         .prepare = use_nv_instances_of_another_usage, TWIN_EDITS(SET(nv.info.instanceCount, 0))),
    /* Alignment is a property of the address itself. */
    CASE("misaligned_without_primitives", RULE(instance_array_is_aligned),
         EDITS(ADD(INSTANCE, 8), NO_PRIMITIVES(TLAS, 0)),
         TWIN_EDITS(ADD(INSTANCE, 16), NO_PRIMITIVES(TLAS, 0)), .path = INSTANCE_PATH),
    CASE("null_on_host_without_primitives",
         RULES(RULE_vertex_host_address_is_readable, RULE_index_host_address_is_readable,
               RULE_aabb_host_address_is_readable, RULE_instance_host_address_is_readable),
         .silent = true, EDITS(SET(VERTEX, 0), LIKE_VERTICES, FORGET_ALL_PRIMITIVES)),
};

CASE_LIST(cases_empty, cases);
