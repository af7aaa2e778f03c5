/* SPDX-License-Identifier: Apache-2.0 */
/* Scratch memory: alignment, extent, the buffer it lies in. */
#include "case.h"

static uint64_t alignment_of(const struct scene *scene)
{
    return scene->fixture->limits.minAccelerationStructureScratchOffsetAlignment;
}

/* Scratch of a build in a buffer with room before and behind it. */
static struct test_buffer give_room(struct scene *scene, uint32_t build, VkDeviceSize room,
                                    VkBufferUsageFlags usage)
{
    const VkDeviceSize size = scene_scratch_size(scene, build);
    const struct test_buffer buffer = scene_buffer(scene, size + room, usage);
    scene->infos[build].scratchData.deviceAddress = scene_address(scene, &buffer, 0);
    return buffer;
}

/* ---- alignment ---- */

static void misalign(struct scene *scene)
{
    give_room(scene, AABBS, 1024, SCRATCH_USAGE);
    scene->infos[AABBS].scratchData.deviceAddress += alignment_of(scene) / 2;
}

static void misalign_by_one(struct scene *scene)
{
    give_room(scene, REFIT, 1024, SCRATCH_USAGE);
    scene->infos[REFIT].scratchData.deviceAddress += alignment_of(scene) + 1;
}

static void move_by_alignment(struct scene *scene)
{
    give_room(scene, AABBS, 1024, SCRATCH_USAGE);
    scene->infos[AABBS].scratchData.deviceAddress += alignment_of(scene);
}

/* ---- extent ---- */

static void give_exact_size(struct scene *scene, uint32_t build, VkDeviceSize less)
{
    const VkDeviceSize size = scene_scratch_size(scene, build);
    if (size <= less) {
        scene_skip(scene, "the driver wants no scratch");
        return;
    }
    const struct test_buffer buffer = scene_buffer(scene, size - less, SCRATCH_USAGE);
    scene->infos[build].scratchData.deviceAddress = scene_address(scene, &buffer, 0);
}

/* The buffer is long enough, but not from the address on. */
static void begin_too_late(struct scene *scene)
{
    give_exact_size(scene, AABBS, 0);
    scene->infos[AABBS].scratchData.deviceAddress += alignment_of(scene);
}

/* Two buffers side by side in one memory: together they would do. */
static void cross_into_next_buffer(struct scene *scene)
{
    const VkDeviceSize half = 65536;
    struct test_buffer first = scene_create_buffer(scene, half, SCRATCH_USAGE);
    struct test_buffer second = scene_create_buffer(scene, half, SCRATCH_USAGE);
    const struct test_memory memory = scene_allocate(scene, 2 * half);

    scene_bind(scene, &first, &memory, 0);
    scene_bind(scene, &second, &memory, half);
    scene->infos[AABBS].scratchData.deviceAddress = first.address + half - alignment_of(scene);
}

/* The same addresses, and a buffer over all of them. */
static void cross_within_aliasing_buffer(struct scene *scene)
{
    const VkDeviceSize half = 65536;
    struct test_buffer whole = scene_create_buffer(scene, 2 * half, SCRATCH_USAGE);
    struct test_buffer first = scene_create_buffer(scene, half, SCRATCH_USAGE);
    const struct test_memory memory = scene_allocate(scene, 2 * half);

    scene_bind(scene, &whole, &memory, 0);
    scene_bind(scene, &first, &memory, 0);
    if (whole.address != first.address) {
        scene_skip(scene, "aliasing buffers have different addresses");
        return;
    }
    scene->infos[AABBS].scratchData.deviceAddress = first.address + half - alignment_of(scene);
}

static void skip_without_update_scratch(struct scene *scene)
{
    if (scene_scratch_size(scene, UPDATE) == 0)
        scene_skip(scene, "the driver wants no scratch for updates");
}

/* ---- usage ---- */

static void use_input_buffer_as_build_scratch(struct scene *scene)
{
    give_room(scene, TLAS, 0, INPUT_USAGE);
}

static void use_input_buffer_as_update_scratch(struct scene *scene)
{
    skip_without_update_scratch(scene);
    give_room(scene, REFIT, 0, INPUT_USAGE);
}

static void use_input_buffer_as_ignored_scratch(struct scene *scene)
{
    give_room(scene, REFIT, 1024, INPUT_USAGE);
}

static void use_more_usages(struct scene *scene)
{
    const VkBufferUsageFlags usage =
        ACCEL_USAGE | VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT;
    give_room(scene, TLAS, 0, usage);
    give_room(scene, REFIT, 0, usage);
}

/* One of two buffers with the same address has the usage. */
static void alias_with_storage_usage(struct scene *scene)
{
    const VkDeviceSize size = 65536;
    struct test_buffer input = scene_create_buffer(scene, size, INPUT_USAGE);
    struct test_buffer storage = scene_create_buffer(scene, size, SCRATCH_USAGE);
    const struct test_memory memory = scene_allocate(scene, size);

    scene_bind(scene, &storage, &memory, 0);
    scene_bind(scene, &input, &memory, 0);
    scene->infos[TLAS].scratchData.deviceAddress = storage.address;
}

/* VkBufferUsageFlags2CreateInfo replaces VkBufferCreateInfo::usage. */
static void give_flags2(struct scene *scene, VkBufferUsageFlags usage, VkBufferUsageFlags2 usage2)
{
    const VkBufferUsageFlags2CreateInfo flags2 = {
        .sType = VK_STRUCTURE_TYPE_BUFFER_USAGE_FLAGS_2_CREATE_INFO, .usage = usage2};
    const VkBufferCreateInfo create_info = {.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO,
                                            .pNext = &flags2,
                                            .size = 65536,
                                            .usage = usage};
    struct test_buffer buffer = scene_create_buffer_with(scene, &create_info);
    const struct test_memory memory =
        scene_allocate(scene, scene_buffer_memory_size(scene, &buffer));
    buffer.usage = VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT;
    scene_bind(scene, &buffer, &memory, 0);
    scene->infos[TLAS].scratchData.deviceAddress = scene_address(scene, &buffer, 0);
}

static void lose_storage_in_flags2(struct scene *scene)
{
    give_flags2(scene, SCRATCH_USAGE, VK_BUFFER_USAGE_2_SHADER_DEVICE_ADDRESS_BIT);
}

static void get_storage_from_flags2(struct scene *scene)
{
    give_flags2(scene, 0,
                VK_BUFFER_USAGE_2_SHADER_DEVICE_ADDRESS_BIT | VK_BUFFER_USAGE_2_STORAGE_BUFFER_BIT);
}

static const struct setup with_maintenance5 = {.enable = ENABLE_MAINTENANCE5};

/* ---- builds that need no scratch ---- */

static void want_no_update_scratch(struct null_driver_config *config)
{
    config->sizes.update_scratch = (struct null_driver_size){0, 0};
}

static const struct setup without_update_scratch = {.configure = want_no_update_scratch};

#define WILD 0x7000000000ull

static const struct test_case cases[] = {
    SHARED(RULE(scratch_address_is_aligned)),
    CASE("scratch_misaligned", .mutate = misalign, .mutate_twin = move_by_alignment,
         .path = "pInfos[2].scratchData.deviceAddress"),
    CASE("scratch_of_update_misaligned", .mutate = misalign_by_one,
         .path = "pInfos[5].scratchData.deviceAddress"),
    CASE("scratch_misaligned_though_not_needed", .setup = &without_update_scratch,
         EDITS(SET(infos[UPDATE].scratchData.deviceAddress, WILD + 1))),

    SHARED(RULE(build_scratch_is_in_one_buffer)),
    CASE("scratch_nowhere_but_not_needed",
         RULES(RULE_update_scratch_is_in_one_buffer, RULE_update_scratch_has_storage_usage),
         .silent = true, .setup = &without_update_scratch,
         EDITS(SET(infos[UPDATE].scratchData.deviceAddress, WILD),
               SET(infos[REFIT].scratchData.deviceAddress, 0))),
    CASE("scratch_without_storage_usage_but_not_needed", RULE(update_scratch_has_storage_usage),
         .silent = true, .commands = ON_COMMAND_BUFFERS, .setup = &without_update_scratch,
         .mutate = use_input_buffer_as_ignored_scratch),
    CASE("scratch_null", EDITS(SET(infos[INDEXED].scratchData.deviceAddress, 0)),
         .path = "pInfos[0].scratchData.deviceAddress"),
    CASE("scratch_nowhere", EDITS(SET(infos[AABBS].scratchData.deviceAddress, WILD))),
    CASE("scratch_a_byte_short", EITHER_CALL_FOR(give_exact_size, TLAS, 1, 0),
         .path = "pInfos[3].scratchData.deviceAddress"),
    CASE("scratch_begins_too_late", .mutate = begin_too_late),
    CASE("scratch_in_two_buffers", .mutate = cross_into_next_buffer,
         .mutate_twin = cross_within_aliasing_buffer),
    CASE("scratch_memory_freed", RULE(input_buffer_is_bound), .commands = ON_COMMAND_BUFFERS,
         EDITS(DESTROY(scratch_buffers[AABBS].memory)), .count = 1,
         .path = "].scratchData.deviceAddress"),
    CASE("scratch_buffer_destroyed", EDITS(DESTROY(scratch_buffers[TLAS].handle))),

    SHARED(RULE(update_scratch_is_in_one_buffer)),
    CASE("update_scratch_null", .mutate = skip_without_update_scratch,
         EDITS(SET(infos[UPDATE].scratchData.deviceAddress, 0)),
         .path = "pInfos[4].scratchData.deviceAddress"),
    CASE("update_scratch_nowhere", .mutate = skip_without_update_scratch,
         EDITS(SET(infos[REFIT].scratchData.deviceAddress, WILD))),
    CASE("update_scratch_a_byte_short", EITHER_CALL_FOR(give_exact_size, UPDATE, 1, 0)),

    SHARED(RULE(input_buffer_is_bound), .commands = ON_COMMAND_BUFFERS,
           EDITS(DESTROY(scratch_buffers[REFIT].memory))),
    CASE("update_scratch_memory_freed", .count = 1, .path = "].scratchData.deviceAddress"),
    CASE("scratch_memory_freed_but_not_needed", .silent = true, .setup = &without_update_scratch),

    SHARED(RULE(build_scratch_has_storage_usage)),
    CASE("scratch_without_storage_usage", .mutate = use_input_buffer_as_build_scratch,
         .mutate_twin = use_more_usages, .path = "pInfos[3].scratchData.deviceAddress"),
    CASE("scratch_with_storage_usage_by_an_alias", .silent = true,
         .mutate = alias_with_storage_usage),
    CASE("scratch_without_storage_usage_in_flags2", .setup = &with_maintenance5,
         .mutate = lose_storage_in_flags2, .mutate_twin = get_storage_from_flags2),
    CASE("update_scratch_without_storage_usage", RULE(update_scratch_has_storage_usage),
         .mutate = use_input_buffer_as_update_scratch, .mutate_twin = use_more_usages,
         .path = "pInfos[5].scratchData.deviceAddress"),
};

CASE_LIST(cases_scratch, cases);
