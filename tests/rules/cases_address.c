/* SPDX-License-Identifier: Apache-2.0 */
/* Addresses of input data: in a bound buffer that may be read by builds. */
#include "addresses.h"

/* ---- places that an address can lead to ---- */

/* In the middle of an allocation of which only the first bytes are a buffer's. */
static struct test_buffer buffer_with_nothing_behind(struct scene *scene)
{
    struct test_buffer buffer = scene_create_buffer(scene, 4096, INPUT_USAGE);
    const struct test_memory memory = scene_allocate(scene, 65536);
    scene_bind(scene, &buffer, &memory, 0);
    return buffer;
}

static VkDeviceAddress past_the_end(struct scene *scene)
{
    return buffer_with_nothing_behind(scene).address + 4096;
}

static VkDeviceAddress of_the_last_bytes(struct scene *scene)
{
    return buffer_with_nothing_behind(scene).address + 4096 - 16;
}

static VkDeviceAddress with_all_usages(struct scene *scene)
{
    return scene_buffer(scene, 4096,
                        INPUT_USAGE | VK_BUFFER_USAGE_STORAGE_BUFFER_BIT |
                            VK_BUFFER_USAGE_VERTEX_BUFFER_BIT)
        .address;
}

/* Two buffers at one address, of which one may be read by builds. */
static VkDeviceAddress of_aliasing_buffers(struct scene *scene)
{
    struct test_buffer input = scene_create_buffer(scene, 4096, INPUT_USAGE);
    struct test_buffer storage = scene_create_buffer(scene, 8192, SCRATCH_USAGE);
    const struct test_memory memory = scene_allocate(scene, 65536);
    scene_bind(scene, &input, &memory, 0);
    scene_bind(scene, &storage, &memory, 0);
    return input.address;
}

/* The buffer that was there is gone, another one is bound to the same memory. */
static VkDeviceAddress recycled(struct scene *scene)
{
    struct test_buffer first = scene_create_buffer(scene, 4096, SCRATCH_USAGE);
    struct test_buffer second = scene_create_buffer(scene, 4096, INPUT_USAGE);
    const struct test_memory memory = scene_allocate(scene, 65536);
    scene_bind(scene, &first, &memory, 0);
    scene_destroy(scene, (uint64_t)first.handle);
    scene_bind(scene, &second, &memory, 0);
    return second.address;
}

static VkDeviceAddress of_sparse_buffer(struct scene *scene)
{
    return scene_sparse_buffer(scene, 65536, INPUT_USAGE, VK_BUFFER_CREATE_SPARSE_RESIDENCY_BIT)
        .address;
}

/* Usage from VkBufferUsageFlags2CreateInfo, which replaces VkBufferCreateInfo::usage. */
static VkDeviceAddress of_flags2(struct scene *scene, VkBufferUsageFlags2 usage2)
{
    const VkBufferUsageFlags2CreateInfo flags2 = {
        .sType = VK_STRUCTURE_TYPE_BUFFER_USAGE_FLAGS_2_CREATE_INFO,
        .usage = usage2 | VK_BUFFER_USAGE_2_SHADER_DEVICE_ADDRESS_BIT};
    const VkBufferCreateInfo create_info = {.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO,
                                            .pNext = &flags2,
                                            .size = 4096,
                                            .usage = INPUT_USAGE};
    struct test_buffer buffer = scene_create_buffer_with(scene, &create_info);
    const struct test_memory memory =
        scene_allocate(scene, scene_buffer_memory_size(scene, &buffer));
    scene_bind(scene, &buffer, &memory, 0);
    return buffer.address;
}

static VkDeviceAddress of_flags2_without_input(struct scene *scene)
{
    return of_flags2(scene, VK_BUFFER_USAGE_2_STORAGE_BUFFER_BIT);
}

static VkDeviceAddress of_flags2_with_input(struct scene *scene)
{
    return of_flags2(scene, VK_BUFFER_USAGE_2_ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_BIT_KHR);
}

static const struct test_case cases[] = {
    /* in a buffer of its own, and not aligned there */
    CASE("transform_address_misaligned_without_indices", RULE(transform_address_is_aligned),
         PREPARE_EDITS(MAKE_ADDRESS(UNINDEXED_TRANSFORM, with_all_usages)),
         EITHER_ADD(UNINDEXED_TRANSFORM, 8, 16),
         .path = "pInfos[1].pGeometries[0].geometry.triangles.transformData.deviceAddress"),

    SHARED(RULE(input_address_is_in_a_buffer), .commands = ON_COMMAND_BUFFERS),
    /* in a buffer */
    CASE("vertex_address_nowhere", EDITS(SET(VERTEX, WILD)), .path = VERTEX_PATH),
    CASE("vertex_address_in_destroyed_buffer",
         EITHER_ADDRESS(VERTEX, scene_destroyed_address, recycled)),
    CASE("vertex_address_past_the_end", EITHER_ADDRESS(VERTEX, past_the_end, of_the_last_bytes),
         .path = VERTEX_PATH),
    CASE("vertex_address_past_the_end_khr", SETUP(.route = ROUTE_KHR),
         EITHER_ADDRESS(VERTEX, past_the_end, of_the_last_bytes)),
    CASE("vertex_address_past_the_end_ext", SETUP(.route = ROUTE_EXT),
         EITHER_ADDRESS(VERTEX, past_the_end, of_the_last_bytes)),
    CASE("index_address_nowhere", EDITS(SET(INDEX, WILD)), .path = INDEX_PATH),
    CASE("index_address_past_the_end", EITHER_ADDRESS(INDEX, past_the_end, of_the_last_bytes)),

    SHARED(RULE(transform_address_is_valid)),
    CASE("transform_address_nowhere", EDITS(SET(TRANSFORM, WILD)), .path = TRANSFORM_PATH),
    CASE("transform_address_nowhere_without_indices", EDITS(SET(UNINDEXED_TRANSFORM, WILD))),
    CASE("transform_address_past_the_end", EDITS(MAKE_ADDRESS(TRANSFORM, past_the_end))),
    CASE("transform_buffer_destroyed", EDITS(MAKE_ADDRESS(TRANSFORM, scene_destroyed_address))),

    SHARED(RULE(input_address_is_in_a_buffer), .commands = ON_COMMAND_BUFFERS),
    CASE("box_address_nowhere", EDITS(SET(BOX, WILD)), .path = BOX_PATH),
    CASE("box_address_past_the_end", EDITS(MAKE_ADDRESS(BOX, past_the_end))),
    CASE("instance_address_nowhere", EDITS(SET(INSTANCE, WILD)), .path = INSTANCE_PATH),
    CASE("instance_buffer_destroyed", EDITS(MAKE_ADDRESS(INSTANCE, scene_destroyed_address))),

    SHARED(RULE(input_buffer_is_bound), .commands = ON_COMMAND_BUFFERS),
    /* bound */
    CASE("vertex_memory_freed", EDITS(MAKE_ADDRESS(VERTEX, scene_freed_address)),
         .path = VERTEX_PATH),
    CASE("index_memory_freed", EDITS(MAKE_ADDRESS(INDEX, scene_freed_address)), .path = INDEX_PATH),
    CASE("transform_memory_freed", EDITS(MAKE_ADDRESS(TRANSFORM, scene_freed_address)),
         .path = TRANSFORM_PATH),
    CASE("box_memory_freed", EDITS(MAKE_ADDRESS(BOX, scene_freed_address)), .path = BOX_PATH),
    CASE("instance_memory_freed", EDITS(MAKE_ADDRESS(INSTANCE, scene_freed_address)),
         .path = INSTANCE_PATH),
    CASE("vertex_buffer_sparse", .silent = true, SETUP(.enable = ENABLE_SPARSE),
         EDITS(MAKE_ADDRESS(VERTEX, of_sparse_buffer))),

    SHARED(RULE(input_buffer_has_build_input_usage)),
    /* usage */
    CASE("vertex_buffer_without_usage",
         EITHER_ADDRESS(VERTEX, scene_address_without_usage, with_all_usages), .path = VERTEX_PATH),
    CASE("vertex_buffer_with_usage_by_an_alias", .silent = true,
         EDITS(MAKE_ADDRESS(VERTEX, of_aliasing_buffers))),
    CASE("vertex_buffer_without_usage_in_flags2", SETUP(.enable = ENABLE_MAINTENANCE5),
         EITHER_ADDRESS(VERTEX, of_flags2_without_input, of_flags2_with_input)),
    CASE("index_buffer_without_usage", EDITS(MAKE_ADDRESS(INDEX, scene_address_without_usage)),
         .path = INDEX_PATH),
    CASE("transform_buffer_without_usage",
         EDITS(MAKE_ADDRESS(TRANSFORM, scene_address_without_usage)), .path = TRANSFORM_PATH),
    CASE("transform_buffer_without_usage_nor_indices",
         EITHER_ADDRESS(UNINDEXED_TRANSFORM, scene_address_without_usage, with_all_usages)),
    CASE("box_buffer_without_usage", EDITS(MAKE_ADDRESS(BOX, scene_address_without_usage)),
         .path = BOX_PATH),
    CASE("instance_buffer_without_usage",
         EDITS(MAKE_ADDRESS(INSTANCE, scene_address_without_usage)), .path = INSTANCE_PATH),
};

CASE_LIST(cases_address, cases);
