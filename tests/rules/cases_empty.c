/* SPDX-License-Identifier: Apache-2.0 */
/* Geometries without primitives: a build reads no data of them, so their addresses are not
 * validated. Each case breaks a rule about an address; its twin does the same with a primitive
 * count (of the indirect command: a maximum) of 0. */
#include "addresses.h"

#define NO_PRIMITIVES(build, index) SET(ranges[build][index].primitiveCount, 0)

/* ---- addresses in buffers that no build can read ---- */

static void set_all_addresses(struct scene *scene, VkDeviceAddress address)
{
    scene->VERTEX = address;
    scene->INDEX = address;
    scene->TRANSFORM = address;
    scene->BOX = address;
    scene->INSTANCE = address;
}

static void forget_all_primitives(struct scene *scene)
{
    scene->ranges[INDEXED][0].primitiveCount = 0;
    scene->ranges[AABBS][0].primitiveCount = 0;
    scene->ranges[TLAS][0].primitiveCount = 0;
}

static void use_freed_memory(struct scene *scene)
{
    const struct test_buffer buffer = scene_buffer(scene, 4096, INPUT_USAGE);
    scene_destroy(scene, (uint64_t)buffer.memory);
    set_all_addresses(scene, buffer.address);
}

static void use_a_destroyed_buffer(struct scene *scene)
{
    const struct test_buffer buffer = scene_buffer(scene, 4096, INPUT_USAGE);
    scene_destroy(scene, (uint64_t)buffer.handle);
    set_all_addresses(scene, buffer.address);
}

static void use_no_input_buffer(struct scene *scene)
{
    set_all_addresses(scene, scene_buffer(scene, 4096, SCRATCH_USAGE).address);
}

/* ---- indirect builds: all counts are in the buffer, and there is none ---- */

static void read_ranges_from_scratch(struct scene *scene)
{
    scene->indirect_addresses[AABBS] =
        scene_buffer(scene, SCENE_BUFFER_SIZE, SCRATCH_USAGE).address;
}

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

static const struct setup with_khr = {.enable = ENABLE_OPACITY_MICROMAP_KHR};
static const struct setup with_ext = {.enable = ENABLE_OPACITY_MICROMAP_EXT};

static void leave_micromap_indices_unbound(struct scene *scene)
{
    const struct test_buffer buffer = scene_buffer(scene, SCENE_BUFFER_SIZE, INPUT_USAGE);
    scene_use_micromap(scene);
    scene->micromaps.opacity.indexBuffer = buffer.address;
    scene_destroy(scene, (uint64_t)buffer.memory);
}

static void use_nv_instances_of_another_usage(struct scene *scene)
{
    scene_nv_use_instances(scene);
    scene->nv.instance_data =
        scene_buffer(scene, SCENE_BUFFER_SIZE, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT).handle;
}

/* ---- host builds ---- */

static void null_on_host_without_primitives(struct scene *scene)
{
    set_all_addresses(scene, 0);
    forget_all_primitives(scene);
}

#define IS_READ(name_, rule_, build, ...)                                                          \
    {                                                                                              \
        .name = name_, RULES(rule_), EDITS(__VA_ARGS__),                                           \
        TWIN_EDITS(__VA_ARGS__, NO_PRIMITIVES(build, 0)), .commands = ON_COMMAND_BUFFERS,          \
    }

static const struct test_case cases[] = {
    IS_READ("no_vertex_address", RULE_vertex_address_is_given, INDEXED, SET(VERTEX, 0)),
    IS_READ("no_index_address", RULE_index_address_is_given, INDEXED, SET(INDEX, 0)),
    IS_READ("no_box_address", RULE_aabb_address_is_given, AABBS, SET(BOX, 0)),
    IS_READ("no_instance_address", RULE_instance_address_is_given, TLAS, SET(INSTANCE, 0)),
    IS_READ("no_instance_pointers", RULE_instance_address_is_given, TLAS, SET(INSTANCE, 0),
            SET(INSTANCES(TLAS, 0).arrayOfPointers, VK_TRUE)),
    IS_READ("vertices_nowhere", RULE_input_address_is_in_a_buffer, INDEXED, SET(VERTEX, WILD)),
    IS_READ("indices_nowhere", RULE_input_address_is_in_a_buffer, INDEXED, SET(INDEX, WILD)),
    IS_READ("transform_nowhere", RULE_transform_address_is_valid, INDEXED, SET(TRANSFORM, WILD)),
    IS_READ("boxes_nowhere", RULE_input_address_is_in_a_buffer, AABBS, SET(BOX, WILD)),
    IS_READ("instances_nowhere", RULE_input_address_is_in_a_buffer, TLAS, SET(INSTANCE, WILD)),
    CASE("all_in_freed_memory", RULE(input_buffer_is_bound), .commands = ON_COMMAND_BUFFERS,
         .prepare = use_freed_memory, TWIN_EDITS(CALL(forget_all_primitives)), .count = 5),
    CASE("all_in_a_destroyed_buffer",
         RULES(RULE_input_address_is_in_a_buffer, RULE_transform_address_is_valid),
         .commands = ON_COMMAND_BUFFERS, .prepare = use_a_destroyed_buffer,
         TWIN_EDITS(CALL(forget_all_primitives)), .count = 4),
    CASE("all_without_usage", RULE(input_buffer_has_build_input_usage),
         .commands = ON_COMMAND_BUFFERS, .prepare = use_no_input_buffer,
         TWIN_EDITS(CALL(forget_all_primitives)), .count = 5),
    /* The second geometry of the build has triangles. */
    CASE("second_geometry_is_read", RULE(input_address_is_in_a_buffer),
         .commands = ON_COMMAND_BUFFERS, PREPARE_EDITS(SET(UNINDEXED_VERTEX, WILD)),
         EDITS(SET(SHORT_INDEX, WILD), SET(ranges[UNINDEXED][0].primitiveCount, 0)),
         TWIN_EDITS(SET(ranges[UNINDEXED][0].primitiveCount, 0)), .count = 1,
         .path = "pInfos[1].pGeometries[1].geometry.triangles.indexData.deviceAddress"),
    CASE("maximum_of_1", RULE(vertex_address_is_given), .commands = ON_INDIRECT,
         .mutate = lose_vertices_below_a_maximum,
         EDITS(SET(ranges[UNINDEXED][0].primitiveCount, 0))),
    CASE("ranges_without_usage", RULE(indirect_buffer_has_indirect_usage), .commands = ON_INDIRECT,
         .prepare = read_ranges_from_scratch, TWIN_EDITS(SET(infos[AABBS].geometryCount, 0))),

    CASE("micromap_indices_at_0", RULE(opacity_index_buffer_is_given),
         .commands = ON_COMMAND_BUFFERS, .setup = &with_khr, .prepare = scene_use_micromap,
         EDITS(SET(micromaps.opacity.indexBuffer, 0)),
         TWIN_EDITS(SET(micromaps.opacity.indexBuffer, 0),
                    SET(ranges[INDEXED][0].primitiveCount, 0))),
    CASE("micromap_indices_unbound", RULE(input_buffer_is_bound), .commands = ON_COMMAND_BUFFERS,
         .setup = &with_khr, .prepare = leave_micromap_indices_unbound,
         TWIN_EDITS(SET(ranges[INDEXED][0].primitiveCount, 0))),
    CASE("ext_indices_at_0", RULE(ext_opacity_index_address_is_given), .setup = &with_ext,
         .prepare = scene_use_micromap_ext, EDITS(SET(micromaps.opacity_ext.indexBuffer, 0)),
         TWIN_EDITS(SET(micromaps.opacity_ext.indexBuffer, 0),
                    SET(ranges[INDEXED][0].primitiveCount, 0))),
    CASE("nv_instances_of_another_usage", RULES(RULE_nv_instance_data_has_ray_tracing_usage),
         NAMES(RULE_nv_info_instance_data_has_ray_tracing_usage),
         .prepare = use_nv_instances_of_another_usage, TWIN_EDITS(SET(nv.info.instanceCount, 0))),

    /* Alignment is a property of the address itself. */
    CASE("misaligned_without_primitives", RULE(instance_array_is_aligned),
         EDITS(ADD(INSTANCE, 8), NO_PRIMITIVES(TLAS, 0)),
         TWIN_EDITS(ADD(INSTANCE, 16), NO_PRIMITIVES(TLAS, 0)), .path = INSTANCE_PATH),

    CASE("null_on_host_without_primitives",
         RULES(RULE_vertex_host_address_is_readable, RULE_index_host_address_is_readable,
               RULE_aabb_host_address_is_readable, RULE_instance_host_address_is_readable),
         .silent = true, .mutate = null_on_host_without_primitives),
};

CASE_LIST(cases_empty, cases);
