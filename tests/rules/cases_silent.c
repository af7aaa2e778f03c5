/* SPDX-License-Identifier: Apache-2.0 */
/* Valid programs that other validation has called wrong, or that are easily called so. */
#include <string.h>

#include "case.h"
#include "placing.h"

/* ---- handles and addresses that come again ---- */

static void recycle_all(struct null_driver_config *config)
{
    config->recycle_handles = true;
    config->recycle_addresses = true;
}

static const struct setup with_recycling = {.configure = recycle_all};

/* A new structure, with other properties, gets the handle of a destroyed one. */
static void recycle_handle(struct scene *scene)
{
    const struct test_buffer buffer = place_buffer(scene);
    const VkAccelerationStructureKHR first =
        scene_accel_in(scene, &buffer, 0, 256, VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR);
    scene_destroy(scene, (uint64_t)first);
    place_dst(scene, AABBS, &buffer, PLACE_FAR);
}

static void read_vertices_of_a_new_buffer(struct scene *scene)
{
    const struct test_buffer buffer = scene_buffer(scene, SCENE_BUFFER_SIZE, INPUT_USAGE);
    scene->TRIANGLES(INDEXED, 0).vertexData.deviceAddress = scene_address(scene, &buffer, 0);
}

/* New memory, of a new buffer with other usage, gets the address of a freed one. */
static void recycle_address(struct scene *scene)
{
    const struct test_buffer first = scene_buffer(scene, SCENE_BUFFER_SIZE, SCRATCH_USAGE);
    scene_destroy(scene, (uint64_t)first.handle);
    scene_destroy(scene, (uint64_t)first.memory);
    read_vertices_of_a_new_buffer(scene);
}

/* The old buffer lives on without memory while a new one has its address. */
static void recycle_address_of_orphan(struct scene *scene)
{
    const struct test_buffer first = scene_buffer(scene, SCENE_BUFFER_SIZE, SCRATCH_USAGE);
    scene_destroy(scene, (uint64_t)first.memory);
    read_vertices_of_a_new_buffer(scene);
}

static void destroy_one_of_two(struct scene *scene)
{
    const struct test_buffer buffer = place_buffer(scene);
    place_dst(scene, AABBS, &buffer, 0);
    scene_destroy(scene, (uint64_t)scene->infos[AABBS].dstAccelerationStructure);
    place_dst(scene, AABBS, &buffer, PLACE_FAR);
    place_dst(scene, INDEXED, &buffer, 0);
}

static void destroy_others_before_update(struct scene *scene)
{
    for (uint32_t build = 0; build < 8; build++)
        scene_destroy(scene, (uint64_t)scene_accel_for(scene, build % 3));
}

/* ---- structures that were not built here ---- */

static void update_deserialized(struct scene *scene)
{
    const VkAccelerationStructureKHR accel = scene_accel_for(scene, REFIT);
    const bool is_host = scene->command == COMMAND_HOST;
    static const uint8_t bytes[4096];
    VkCopyMemoryToAccelerationStructureInfoKHR info = {
        .sType = VK_STRUCTURE_TYPE_COPY_MEMORY_TO_ACCELERATION_STRUCTURE_INFO_KHR,
        .src.hostAddress = bytes,
        .dst = accel,
        .mode = VK_COPY_ACCELERATION_STRUCTURE_MODE_DESERIALIZE_KHR,
    };
    if (!is_host)
        info.src.deviceAddress = scene_buffer(scene, sizeof(bytes), INPUT_USAGE).address;
    if (is_host)
        scene->vk->CopyMemoryToAccelerationStructureKHR(scene->fixture->device, VK_NULL_HANDLE,
                                                        &info);
    else
        scene->vk->CmdCopyMemoryToAccelerationStructureKHR(scene->command_buffer, &info);
    scene->infos[REFIT].srcAccelerationStructure = accel;
    scene->infos[REFIT].dstAccelerationStructure = accel;
}

/* A compacted structure is smaller than a build of its shape needs, and may be updated. */
static void update_compacted(struct scene *scene)
{
    const VkDeviceSize size = place_size(scene, REFIT);
    const struct test_buffer buffer = place_buffer(scene);
    const VkAccelerationStructureKHR copy = scene_accel_in(
        scene, &buffer, 0, size / 2, VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR);
    scene_copy(scene, scene->infos[REFIT].dstAccelerationStructure, copy,
               VK_COPY_ACCELERATION_STRUCTURE_MODE_COMPACT_KHR);
    scene->infos[REFIT].srcAccelerationStructure = copy;
    scene->infos[REFIT].dstAccelerationStructure = copy;
}

static void use_generic_types(struct scene *scene)
{
    const struct test_buffer buffer = place_buffer(scene);
    VkDeviceSize offset = 0;
    for (uint32_t build = INDEXED; build <= TLAS; build++, offset += PLACE_FAR)
        scene->infos[build].dstAccelerationStructure =
            scene_accel_in(scene, &buffer, offset, place_size(scene, build),
                           VK_ACCELERATION_STRUCTURE_TYPE_GENERIC_KHR);
}

/* ---- the same commands again ---- */

/* Records an update in a command buffer of its own and submits it twice. */
static void submit_update_twice(struct scene *scene)
{
    const uint32_t family = fixture_find_family(scene->fixture, VK_QUEUE_COMPUTE_BIT, 0);
    const VkCommandBuffer update = scene_command_buffer(scene, family);

    scene_end(scene, scene->command_buffer);
    scene_submit(scene, family, scene->command_buffer);
    scene_begin(scene, update, 0);
    scene->vk->CmdBuildAccelerationStructuresKHR(update, 1, &scene->infos[REFIT],
                                                 &scene->ranges_argument[REFIT]);
    scene_end(scene, update);
    scene_submit(scene, family, update);
    scene_submit(scene, family, update);
    scene_begin(scene, scene->command_buffer, 0);
}

static void call_twice(struct scene *scene)
{
    scene->vk->CmdBuildAccelerationStructuresKHR(scene->command_buffer, scene->info_count,
                                                 scene->infos_argument, scene->ranges_argument);
}

/* ---- input data ---- */

#define SCALE(factor)                                                                              \
    WRITE_FLOAT(transforms, 0, factor), WRITE_FLOAT(transforms, 20, factor),                       \
        WRITE_FLOAT(transforms, 40, factor)

/* The first instance is not read: the range starts behind it. */
static void skip_bad_instance(struct scene *scene)
{
    VkAccelerationStructureInstanceKHR *instances = (void *)scene->instances.host;
    memset(&instances[0], 0xa5, sizeof(instances[0]));
    scene->ranges[TLAS][0].primitiveOffset = sizeof(instances[0]);
}

/* ---- shared and unusual objects ---- */

/* All input in one buffer, and all scratch in another. */
static void share_one_buffer(struct scene *scene)
{
    const struct test_buffer input = scene_buffer(scene, 65536, INPUT_USAGE);
    const struct test_buffer scratch = scene_buffer(scene, PLACE_SIZE, SCRATCH_USAGE);
    VkAccelerationStructureGeometryTrianglesDataKHR *triangles =
        &scene->geometries[INDEXED][0].geometry.triangles;
    VkDeviceSize offset = 0;

    triangles->vertexData.deviceAddress = scene_address(scene, &input, 0);
    triangles->indexData.deviceAddress = scene_address(scene, &input, 256);
    triangles->transformData.deviceAddress = scene_address(scene, &input, 512);
    for (uint32_t build = 0; build < SCENE_BASE_BUILDS; build++) {
        place_scratch(scene, build, &scratch, offset);
        offset += place_scratch_behind(scene, scene_scratch_size(scene, build));
    }
}

/* The same input serves many builds. */
static void build_many(struct scene *scene)
{
    for (uint32_t i = 0; i < 24; i++)
        scene_add_build(scene, i % SCENE_BASE_BUILDS);
}

static void use_dedicated_memory(struct scene *scene)
{
    struct test_buffer buffer = scene_create_buffer(scene, PLACE_SIZE, PLACE_USAGE);
    const VkMemoryDedicatedAllocateInfo dedicated = {
        .sType = VK_STRUCTURE_TYPE_MEMORY_DEDICATED_ALLOCATE_INFO, .buffer = buffer.handle};
    const struct test_memory memory =
        scene_allocate_with(scene, scene_buffer_memory_size(scene, &buffer),
                            VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT, &dedicated);
    scene_bind(scene, &buffer, &memory, 0);
    place_dst(scene, AABBS, &buffer, 0);
    place_scratch(scene, AABBS, &buffer, PLACE_FAR);
}

/* No primitive, and no geometry, but everything else in place. */
static void build_nothing(struct scene *scene)
{
    for (uint32_t build = 0; build < UPDATE; build++)
        for (uint32_t i = 0; i < SCENE_GEOMETRIES; i++)
            scene->ranges[build][i].primitiveCount = 0;
    scene->infos[AABBS].geometryCount = 0;
}

/* An address that a buffer was created to have again need not be retrieved again. The buffer goes
 * with the device. */
static void read_from_replayed_address(struct scene *scene)
{
    const VkBufferOpaqueCaptureAddressCreateInfo replayed = {
        .sType = VK_STRUCTURE_TYPE_BUFFER_OPAQUE_CAPTURE_ADDRESS_CREATE_INFO,
        .opaqueCaptureAddress = 0x123450000,
    };
    const VkBufferCreateInfo info = {
        .sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO,
        .pNext = &replayed,
        .flags = VK_BUFFER_CREATE_DEVICE_ADDRESS_CAPTURE_REPLAY_BIT,
        .size = 65536,
        .usage = INPUT_USAGE,
    };
    VkBuffer buffer;
    if (scene->vk->CreateBuffer(scene->fixture->device, &info, NULL, &buffer) == VK_SUCCESS)
        scene->TRIANGLES(INDEXED, 0).vertexData.deviceAddress = replayed.opaqueCaptureAddress;
}

static const struct setup with_everything = {
    .enable = ENABLE_UINT8_KHR | ENABLE_OPACITY_MICROMAP_EXT | ENABLE_DISPLACEMENT_MICROMAP |
              ENABLE_MOTION | ENABLE_SPHERES | ENABLE_VIDEO | ENABLE_PROTECTED | ENABLE_SPARSE |
              ENABLE_MAINTENANCE5 | ENABLE_FUTURE};

static const struct test_case cases[] = {
    SHARED(.silent = true),
    CASE("plain"),
    CASE("plain_at_level_parameters", SETUP(.level = "parameters")),
    CASE("plain_at_level_state", SETUP(.level = "state")),
    CASE("plain_at_level_content", SETUP(.level = "content")),
    CASE("plain_with_features2", SETUP(.route = ROUTE_FEATURES2)),
    CASE("plain_with_khr_extensions", SETUP(.route = ROUTE_KHR)),
    CASE("plain_with_ext_addresses", SETUP(.route = ROUTE_EXT)),
    CASE("plain_on_1_4", SETUP(.api_version = VK_API_VERSION_1_4)),
    CASE("plain_with_everything_enabled", .setup = &with_everything),
    CASE("replayed_address", RULE(input_address_is_in_a_buffer), .commands = ON_COMMAND_BUFFERS,
         .mutate = read_from_replayed_address, .needs_null_driver = true),
    CASE("recycled_handle",
         RULES(RULE_dst_is_a_valid_handle, RULE_blas_dst_is_bottom_level_or_generic,
               RULE_dst_is_large_enough),
         .commands = ON_WITH_RANGES, .setup = &with_recycling, .mutate = recycle_handle),
    CASE("recycled_address", RULE(input_buffer_has_build_input_usage), .setup = &with_recycling,
         .mutate = recycle_address),
    CASE("recycled_address_on_any_driver", RULE(input_buffer_has_build_input_usage),
         .mutate = recycle_address),
    CASE("recycled_address_of_orphan",
         RULES(RULE_input_buffer_has_build_input_usage, RULE_input_buffer_is_bound),
         .commands = ON_COMMAND_BUFFERS, .setup = &with_recycling,
         .mutate = recycle_address_of_orphan),
    CASE("destroyed_neighbour", RULES(RULE_dst_and_dst_are_apart, RULE_dst_is_a_valid_handle),
         .mutate = destroy_one_of_two),
    CASE("destroyed_others", RULES(RULE_dst_is_a_valid_handle, RULE_src_is_a_valid_handle),
         .mutate = destroy_others_before_update),
    CASE("update_of_deserialized", RULE(src_is_a_valid_handle), .mutate = update_deserialized,
         .may_fail_on_cpu = true),
    CASE("update_of_compacted", RULE(dst_is_large_enough), .mutate = update_compacted,
         .may_fail_on_cpu = true),
    CASE("generic_types",
         RULES(RULE_tlas_dst_is_top_level_or_generic, RULE_blas_dst_is_bottom_level_or_generic),
         .mutate = use_generic_types),
    CASE("update_submitted_twice", RULE(command_buffer_is_recording), .commands = ON_DEVICE,
         .mutate = submit_update_twice),
    CASE("call_recorded_twice",
         RULES(RULE_no_dst_is_built_twice, RULE_scratch_and_scratch_are_apart),
         .commands = ON_COMMAND_BUFFERS, .mutate = call_twice),
    CASE("transform_of_scale_1e_3", EDITS(SCALE(1e-3f))),
    CASE("transform_of_scale_1e_12", EDITS(SCALE(1e-12f))),
    CASE("instances_behind_an_offset", .mutate = skip_bad_instance),
    CASE("one_buffer_for_all",
         RULES(RULE_build_scratch_is_in_one_buffer, RULE_scratch_and_scratch_are_apart),
         .commands = ON_COMMAND_BUFFERS, .mutate = share_one_buffer),
    CASE("many_builds_of_the_same_input", .mutate = build_many),
    CASE("dedicated_memory", RULE(dst_is_backed_by_memory), .mutate = use_dedicated_memory),
    CASE("nothing_to_build", .mutate = build_nothing),
    CASE("garbage_in_ignored_members",
         EDITS(SET(ranges[AABBS][0].firstVertex, UINT32_MAX),
               SET(ranges[TLAS][0].firstVertex, UINT32_MAX),
               SET(ranges[TLAS][0].transformOffset, 7),
               SET(geometries[UNINDEXED][2].sType, VK_STRUCTURE_TYPE_MAX_ENUM),
               SET(infos[INDEXED].srcAccelerationStructure, 0))),
};

CASE_LIST(cases_silent, cases);
