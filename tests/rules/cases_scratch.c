/* SPDX-License-Identifier: Apache-2.0 */
/* Scratch memory: alignment, extent, the buffer it lies in. */
#include "case.h"

static uint64_t alignment_of(const struct scene *scene)
{
    return scene->fixture->limits.minAccelerationStructureScratchOffsetAlignment;
}

/* Scratch of a build in a buffer with room behind it, whose address may be moved. */
static void give_room(struct scene *scene, uint32_t build, VkDeviceSize usage)
{
    const VkDeviceSize size = scene_scratch_size(scene, build);
    const struct test_buffer buffer = scene_buffer(scene, size + 1024, (VkBufferUsageFlags)usage);
    scene->infos[build].scratchData.deviceAddress = scene_address(scene, &buffer, 0);
}

static void move_by_half_alignments(struct scene *scene, uint32_t build, VkDeviceSize count)
{
    scene->infos[build].scratchData.deviceAddress += count * (alignment_of(scene) / 2);
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

#define MORE_USAGES                                                                                \
    (ACCEL_USAGE | VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT)

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

/* VkBufferUsageFlags2CreateInfo replaces VkBufferCreateInfo::usage, and has the same bits. */
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

/* ---- builds that need no scratch ---- */

static void want_no_update_scratch(struct null_driver_config *config)
{
    config->sizes.update_scratch = (struct null_driver_size){0, 0};
}

static const struct setup without_update_scratch = {.configure = want_no_update_scratch};

#define WILD 0x7000000000ull

static const struct test_case cases[] = {
    SHARED(RULE(scratch_address_is_aligned)),
    CASE("scratch_misaligned",
         EDITS(CALL_FOR(give_room, AABBS, SCRATCH_USAGE),
               CALL_FOR(move_by_half_alignments, AABBS, 1)),
         TWIN_EDITS(CALL_FOR(give_room, AABBS, SCRATCH_USAGE),
                    CALL_FOR(move_by_half_alignments, AABBS, 2)),
         .path = "pInfos[2].scratchData.deviceAddress"),
    CASE("scratch_of_update_misaligned",
         EDITS(CALL_FOR(give_room, REFIT, SCRATCH_USAGE),
               CALL_FOR(move_by_half_alignments, REFIT, 2),
               ADD(infos[REFIT].scratchData.deviceAddress, 1)),
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
         EDITS(CALL_FOR(give_room, REFIT, INPUT_USAGE))),
    CASE("scratch_null", EDITS(SET(infos[INDEXED].scratchData.deviceAddress, 0)),
         .path = "pInfos[0].scratchData.deviceAddress"),
    CASE("scratch_nowhere", EDITS(SET(infos[AABBS].scratchData.deviceAddress, WILD))),
    CASE("scratch_a_byte_short", EITHER_CALL_FOR(give_exact_size, TLAS, 1, 0),
         .path = "pInfos[3].scratchData.deviceAddress"),
    /* The buffer is long enough, but not from the address on. */
    CASE("scratch_begins_too_late",
         EDITS(CALL_FOR(give_exact_size, AABBS, 0), CALL_FOR(move_by_half_alignments, AABBS, 2))),
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
    CASE(
        "scratch_without_storage_usage", EDITS(CALL_FOR(give_room, TLAS, INPUT_USAGE)),
        TWIN_EDITS(CALL_FOR(give_room, TLAS, MORE_USAGES), CALL_FOR(give_room, REFIT, MORE_USAGES)),
        .path = "pInfos[3].scratchData.deviceAddress"),
    CASE("scratch_with_storage_usage_by_an_alias", .silent = true,
         .mutate = alias_with_storage_usage),
    CASE("scratch_without_storage_usage_in_flags2", SETUP(.enable = ENABLE_MAINTENANCE5),
         EDITS(CALL_FOR(give_flags2, SCRATCH_USAGE, VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT)),
         TWIN_EDITS(CALL_FOR(give_flags2, 0, SCRATCH_USAGE))),
    CASE(
        "update_scratch_without_storage_usage", RULE(update_scratch_has_storage_usage),
        .mutate = skip_without_update_scratch, EDITS(CALL_FOR(give_room, REFIT, INPUT_USAGE)),
        TWIN_EDITS(CALL_FOR(give_room, TLAS, MORE_USAGES), CALL_FOR(give_room, REFIT, MORE_USAGES)),
        .path = "pInfos[5].scratchData.deviceAddress"),
};

CASE_LIST(cases_scratch, cases);
