/* SPDX-License-Identifier: Apache-2.0 */
/* Addresses of input data: in a bound buffer that may be read by builds. */
#include "addresses.h"

/* Sets one member to the address that a function below makes. */
#define SETS_ADDRESS(name, member, make)                                                           \
    static void name(struct scene *scene)                                                          \
    {                                                                                              \
        scene->member = make(scene);                                                               \
    }

/* ---- places that an address can lead to ---- */

static VkDeviceAddress of_freed_memory(struct scene *scene)
{
    const struct test_buffer buffer = scene_buffer(scene, 4096, INPUT_USAGE);
    scene_destroy(scene, (uint64_t)buffer.memory);
    return buffer.address;
}

static VkDeviceAddress of_destroyed_buffer(struct scene *scene)
{
    const struct test_buffer buffer = scene_buffer(scene, 4096, INPUT_USAGE);
    scene_destroy(scene, (uint64_t)buffer.handle);
    return buffer.address;
}

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

static VkDeviceAddress without_input_usage(struct scene *scene)
{
    return scene_buffer(scene, 4096, SCRATCH_USAGE).address;
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

SETS_ADDRESS(vertex_freed, VERTEX, of_freed_memory)
SETS_ADDRESS(vertex_destroyed, VERTEX, of_destroyed_buffer)
SETS_ADDRESS(vertex_past_the_end, VERTEX, past_the_end)
SETS_ADDRESS(vertex_at_the_end, VERTEX, of_the_last_bytes)
SETS_ADDRESS(vertex_without_usage, VERTEX, without_input_usage)
SETS_ADDRESS(vertex_with_usages, VERTEX, with_all_usages)
SETS_ADDRESS(vertex_aliased, VERTEX, of_aliasing_buffers)
SETS_ADDRESS(vertex_recycled, VERTEX, recycled)
SETS_ADDRESS(vertex_sparse, VERTEX, of_sparse_buffer)
SETS_ADDRESS(vertex_flags2_without, VERTEX, of_flags2_without_input)
SETS_ADDRESS(vertex_flags2_with, VERTEX, of_flags2_with_input)
SETS_ADDRESS(index_freed, INDEX, of_freed_memory)
SETS_ADDRESS(index_past_the_end, INDEX, past_the_end)
SETS_ADDRESS(index_at_the_end, INDEX, of_the_last_bytes)
SETS_ADDRESS(index_without_usage, INDEX, without_input_usage)
SETS_ADDRESS(transform_freed, TRANSFORM, of_freed_memory)
SETS_ADDRESS(transform_destroyed, TRANSFORM, of_destroyed_buffer)
SETS_ADDRESS(transform_past_the_end, TRANSFORM, past_the_end)
SETS_ADDRESS(transform_without_usage, TRANSFORM, without_input_usage)
SETS_ADDRESS(unindexed_transform_without_usage, UNINDEXED_TRANSFORM, without_input_usage)
SETS_ADDRESS(unindexed_transform_with_usages, UNINDEXED_TRANSFORM, with_all_usages)
SETS_ADDRESS(box_freed, BOX, of_freed_memory)
SETS_ADDRESS(box_past_the_end, BOX, past_the_end)
SETS_ADDRESS(box_without_usage, BOX, without_input_usage)
SETS_ADDRESS(instance_freed, INSTANCE, of_freed_memory)
SETS_ADDRESS(instance_destroyed, INSTANCE, of_destroyed_buffer)
SETS_ADDRESS(instance_without_usage, INSTANCE, without_input_usage)

static const struct setup with_sparse = {.enable = ENABLE_SPARSE};
static const struct setup with_maintenance5 = {.enable = ENABLE_MAINTENANCE5};
static const struct setup with_khr_addresses = {.route = ROUTE_KHR};
static const struct setup with_ext_addresses = {.route = ROUTE_EXT};

static const struct test_case cases[] = {
    /* in a buffer of its own, and not aligned there */
    CASE("transform_address_misaligned_without_indices", RULES(RULE_transform_address_is_aligned),
         .prepare = unindexed_transform_with_usages, .edits = EDITS(ADD(UNINDEXED_TRANSFORM, 8)),
         .twin_edits = EDITS(ADD(UNINDEXED_TRANSFORM, 16)),
         .path = "pInfos[1].pGeometries[0].geometry.triangles.transformData.deviceAddress"),

    /* in a buffer */
    CASE("vertex_address_nowhere", RULES(RULE_input_address_is_in_a_buffer),
         .commands = ON_COMMAND_BUFFERS, .edits = EDITS(SET(VERTEX, WILD)), .path = VERTEX_PATH),
    CASE("vertex_address_in_destroyed_buffer", RULES(RULE_input_address_is_in_a_buffer),
         .commands = ON_COMMAND_BUFFERS, .mutate = vertex_destroyed,
         .mutate_twin = vertex_recycled),
    CASE("vertex_address_past_the_end", RULES(RULE_input_address_is_in_a_buffer),
         .commands = ON_COMMAND_BUFFERS, .mutate = vertex_past_the_end,
         .mutate_twin = vertex_at_the_end, .path = VERTEX_PATH),
    CASE("vertex_address_past_the_end_khr", RULES(RULE_input_address_is_in_a_buffer),
         .commands = ON_COMMAND_BUFFERS, .setup = &with_khr_addresses,
         .mutate = vertex_past_the_end, .mutate_twin = vertex_at_the_end),
    CASE("vertex_address_past_the_end_ext", RULES(RULE_input_address_is_in_a_buffer),
         .commands = ON_COMMAND_BUFFERS, .setup = &with_ext_addresses,
         .mutate = vertex_past_the_end, .mutate_twin = vertex_at_the_end),
    CASE("index_address_nowhere", RULES(RULE_input_address_is_in_a_buffer),
         .commands = ON_COMMAND_BUFFERS, .edits = EDITS(SET(INDEX, WILD)), .path = INDEX_PATH),
    CASE("index_address_past_the_end", RULES(RULE_input_address_is_in_a_buffer),
         .commands = ON_COMMAND_BUFFERS, .mutate = index_past_the_end,
         .mutate_twin = index_at_the_end),
    CASE("transform_address_nowhere", RULES(RULE_transform_address_is_valid),
         .edits = EDITS(SET(TRANSFORM, WILD)), .path = TRANSFORM_PATH),
    CASE("transform_address_nowhere_without_indices", RULES(RULE_transform_address_is_valid),
         .edits = EDITS(SET(UNINDEXED_TRANSFORM, WILD))),
    CASE("transform_address_past_the_end", RULES(RULE_transform_address_is_valid),
         .mutate = transform_past_the_end),
    CASE("transform_buffer_destroyed", RULES(RULE_transform_address_is_valid),
         .mutate = transform_destroyed),
    CASE("box_address_nowhere", RULES(RULE_input_address_is_in_a_buffer),
         .commands = ON_COMMAND_BUFFERS, .edits = EDITS(SET(BOX, WILD)), .path = BOX_PATH),
    CASE("box_address_past_the_end", RULES(RULE_input_address_is_in_a_buffer),
         .commands = ON_COMMAND_BUFFERS, .mutate = box_past_the_end),
    CASE("instance_address_nowhere", RULES(RULE_input_address_is_in_a_buffer),
         .commands = ON_COMMAND_BUFFERS, .edits = EDITS(SET(INSTANCE, WILD)),
         .path = INSTANCE_PATH),
    CASE("instance_buffer_destroyed", RULES(RULE_input_address_is_in_a_buffer),
         .commands = ON_COMMAND_BUFFERS, .mutate = instance_destroyed),

    /* bound */
    CASE("vertex_memory_freed", RULES(RULE_input_buffer_is_bound), .commands = ON_COMMAND_BUFFERS,
         .mutate = vertex_freed, .path = VERTEX_PATH),
    CASE("index_memory_freed", RULES(RULE_input_buffer_is_bound), .commands = ON_COMMAND_BUFFERS,
         .mutate = index_freed, .path = INDEX_PATH),
    CASE("transform_memory_freed", RULES(RULE_input_buffer_is_bound),
         .commands = ON_COMMAND_BUFFERS, .mutate = transform_freed, .path = TRANSFORM_PATH),
    CASE("box_memory_freed", RULES(RULE_input_buffer_is_bound), .commands = ON_COMMAND_BUFFERS,
         .mutate = box_freed, .path = BOX_PATH),
    CASE("instance_memory_freed", RULES(RULE_input_buffer_is_bound), .commands = ON_COMMAND_BUFFERS,
         .mutate = instance_freed, .path = INSTANCE_PATH),
    CASE("vertex_buffer_sparse", RULES(RULE_input_buffer_is_bound), .silent = true,
         .commands = ON_COMMAND_BUFFERS, .setup = &with_sparse, .mutate = vertex_sparse),

    /* usage */
    CASE("vertex_buffer_without_usage", RULES(RULE_input_buffer_has_build_input_usage),
         .mutate = vertex_without_usage, .mutate_twin = vertex_with_usages, .path = VERTEX_PATH),
    CASE("vertex_buffer_with_usage_by_an_alias", RULES(RULE_input_buffer_has_build_input_usage),
         .silent = true, .mutate = vertex_aliased),
    CASE("vertex_buffer_without_usage_in_flags2", RULES(RULE_input_buffer_has_build_input_usage),
         .setup = &with_maintenance5, .mutate = vertex_flags2_without,
         .mutate_twin = vertex_flags2_with),
    CASE("index_buffer_without_usage", RULES(RULE_input_buffer_has_build_input_usage),
         .mutate = index_without_usage, .path = INDEX_PATH),
    CASE("transform_buffer_without_usage", RULES(RULE_input_buffer_has_build_input_usage),
         .mutate = transform_without_usage, .path = TRANSFORM_PATH),
    CASE("transform_buffer_without_usage_nor_indices",
         RULES(RULE_input_buffer_has_build_input_usage),
         .mutate = unindexed_transform_without_usage,
         .mutate_twin = unindexed_transform_with_usages),
    CASE("box_buffer_without_usage", RULES(RULE_input_buffer_has_build_input_usage),
         .mutate = box_without_usage, .path = BOX_PATH),
    CASE("instance_buffer_without_usage", RULES(RULE_input_buffer_has_build_input_usage),
         .mutate = instance_without_usage, .path = INSTANCE_PATH),
};

CASE_LIST(cases_address, cases);
