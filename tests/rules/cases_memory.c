/* SPDX-License-Identifier: Apache-2.0 */
/* Where bytes live: overlap through aliasing buffers, late bindings, instances of memory. */
#include "case.h"
#include "placing.h"

/* ---- buffers that alias ---- */

/* Two buffers in one memory, at two offsets of it. */
static void make_two_buffers(struct scene *scene, struct test_buffer buffers[2],
                             VkDeviceSize offset)
{
    const struct test_memory memory = scene_allocate(scene, 2 * PLACE_SIZE);
    for (int i = 0; i < 2; i++) {
        buffers[i] = scene_create_buffer(scene, PLACE_SIZE, PLACE_USAGE);
        scene_bind(scene, &buffers[i], &memory, i == 0 ? 0 : offset);
    }
}

static void alias_buffers(struct scene *scene)
{
    struct test_buffer buffers[2];
    make_two_buffers(scene, buffers, 0);
    place_dst(scene, INDEXED, &buffers[0], PLACE_FAR);
    place_dst(scene, AABBS, &buffers[1], PLACE_FAR);
}

/* The same offsets in the buffers, other places in the memory. */
static void use_buffers_apart(struct scene *scene)
{
    struct test_buffer buffers[2];
    make_two_buffers(scene, buffers, PLACE_SIZE);
    place_dst(scene, INDEXED, &buffers[0], PLACE_FAR);
    place_dst(scene, AABBS, &buffers[1], PLACE_FAR);
}

/* Other offsets in the buffers, the same place in the memory. */
static void alias_buffers_with_shift(struct scene *scene)
{
    struct test_buffer buffers[2];
    make_two_buffers(scene, buffers, PLACE_FAR);
    place_dst(scene, INDEXED, &buffers[0], 2 * PLACE_FAR);
    place_dst(scene, AABBS, &buffers[1], PLACE_FAR);
}

static void shift_buffers_apart(struct scene *scene)
{
    struct test_buffer buffers[2];
    make_two_buffers(scene, buffers, PLACE_FAR);
    place_dst(scene, INDEXED, &buffers[0], PLACE_FAR);
    place_dst(scene, AABBS, &buffers[1], PLACE_FAR);
}

static void alias_update_by_buffers(struct scene *scene)
{
    struct test_buffer buffers[2];
    make_two_buffers(scene, buffers, PLACE_FAR);
    place_src(scene, UPDATE, &buffers[0], PLACE_FAR);
    place_dst(scene, UPDATE, &buffers[1], 0);
}

static void keep_update_apart_by_buffers(struct scene *scene)
{
    struct test_buffer buffers[2];
    make_two_buffers(scene, buffers, PLACE_FAR);
    place_src(scene, UPDATE, &buffers[0], 0);
    place_dst(scene, UPDATE, &buffers[1], 0);
}

static void alias_scratch_by_buffers(struct scene *scene)
{
    struct test_buffer buffers[2];
    make_two_buffers(scene, buffers, 0);
    place_dst(scene, INDEXED, &buffers[0], PLACE_FAR);
    place_scratch(scene, AABBS, &buffers[1], PLACE_FAR);
}

static void alias_scratch_apart_by_buffers(struct scene *scene)
{
    struct test_buffer buffers[2];
    make_two_buffers(scene, buffers, 0);
    place_dst(scene, INDEXED, &buffers[0], PLACE_FAR);
    place_scratch(scene, AABBS, &buffers[1], 2 * PLACE_FAR);
}

/* ---- bindings made late ---- */

/* The structures are created while their buffers have no memory. */
static void bind_late(struct scene *scene, VkDeviceSize second_offset)
{
    struct test_buffer buffers[2];
    for (int i = 0; i < 2; i++)
        buffers[i] = scene_create_buffer(scene, PLACE_SIZE, PLACE_USAGE);
    place_dst(scene, INDEXED, &buffers[0], 0);
    place_dst(scene, AABBS, &buffers[1], 0);
    const struct test_memory memory = scene_allocate(scene, 2 * PLACE_SIZE);
    scene_bind(scene, &buffers[0], &memory, 0);
    scene_bind(scene, &buffers[1], &memory, second_offset);
}

/* vkBindBufferMemory2 of two buffers at once. */
static void bind_both(struct scene *scene, VkDeviceSize second_offset)
{
    struct test_buffer buffers[2];
    VkBindBufferMemoryInfo infos[2];
    const struct test_memory memory = scene_allocate(scene, 2 * PLACE_SIZE);

    for (int i = 0; i < 2; i++) {
        buffers[i] = scene_create_buffer(scene, PLACE_SIZE, PLACE_USAGE);
        infos[i] = (VkBindBufferMemoryInfo){.sType = VK_STRUCTURE_TYPE_BIND_BUFFER_MEMORY_INFO,
                                            .buffer = buffers[i].handle,
                                            .memory = memory.handle,
                                            .memoryOffset = i == 0 ? 0 : second_offset};
    }
    expect_success(scene->vk->BindBufferMemory2(scene->fixture->device, 2, infos),
                   "vkBindBufferMemory2");
    place_dst(scene, INDEXED, &buffers[0], 0);
    place_dst(scene, AABBS, &buffers[1], 0);
}

/* After a failure nobody knows which of the buffers are bound. */
static void fail_to_bind_both(struct scene *scene)
{
    struct test_buffer buffers[2];
    VkBindBufferMemoryInfo infos[2];
    const struct test_memory memory = scene_allocate(scene, PLACE_SIZE);

    for (int i = 0; i < 2; i++) {
        buffers[i] = scene_create_buffer(scene, PLACE_SIZE, PLACE_USAGE);
        infos[i] = (VkBindBufferMemoryInfo){.sType = VK_STRUCTURE_TYPE_BIND_BUFFER_MEMORY_INFO,
                                            .buffer = buffers[i].handle,
                                            .memory = memory.handle};
    }
    scene->fixture->platform->null_driver.fail_next("vkBindBufferMemory2",
                                                    VK_ERROR_OUT_OF_DEVICE_MEMORY);
    scene->vk->BindBufferMemory2(scene->fixture->device, 2, infos);
    place_dst(scene, INDEXED, &buffers[0], 0);
    place_dst(scene, AABBS, &buffers[1], 0);
}

/* ---- instances of memory ---- */

static const struct setup with_group = {.enable = ENABLE_GROUP};

/* Two structures at one offset of memory that each physical device has an instance of. */
static void use_instances(struct scene *scene, const uint32_t first[2], const uint32_t second[2])
{
    const uint32_t *const indices[2] = {first, second};
    const struct test_memory memory =
        scene_allocate_with(scene, PLACE_SIZE, VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT, NULL);
    struct test_buffer buffers[2];

    for (int i = 0; i < 2; i++) {
        const VkBindBufferMemoryDeviceGroupInfo group = {
            .sType = VK_STRUCTURE_TYPE_BIND_BUFFER_MEMORY_DEVICE_GROUP_INFO,
            .deviceIndexCount = indices[i] != NULL ? 2 : 0,
            .pDeviceIndices = indices[i],
        };
        buffers[i] = scene_create_buffer(scene, PLACE_SIZE, ACCEL_USAGE);
        const VkBindBufferMemoryInfo info = {.sType = VK_STRUCTURE_TYPE_BIND_BUFFER_MEMORY_INFO,
                                             .pNext = &group,
                                             .buffer = buffers[i].handle,
                                             .memory = memory.handle};
        expect_success(scene->vk->BindBufferMemory2(scene->fixture->device, 1, &info),
                       "vkBindBufferMemory2");
    }
    place_dst(scene, INDEXED, &buffers[0], 0);
    place_dst(scene, AABBS, &buffers[1], 0);
}

static void use_own_instances(struct scene *scene)
{
    use_instances(scene, NULL, NULL);
}

static void use_different_instances(struct scene *scene)
{
    static const uint32_t first[] = {0, 0}, second[] = {1, 1};
    use_instances(scene, first, second);
}

static const struct test_case cases[] = {
    SHARED(RULE(dst_and_dst_are_apart)),
    CASE("dsts_in_aliasing_buffers", .mutate = alias_buffers, .mutate_twin = use_buffers_apart),
    CASE("dsts_in_aliasing_buffers_with_shift", .mutate = alias_buffers_with_shift,
         .mutate_twin = shift_buffers_apart),
    CASE("update_in_aliasing_buffers", RULE(update_src_and_dst_do_not_alias),
         .mutate = alias_update_by_buffers, .mutate_twin = keep_update_apart_by_buffers),
    CASE("dst_and_scratch_in_aliasing_buffers", RULE(dst_and_scratch_are_apart),
         .mutate = alias_scratch_by_buffers, .mutate_twin = alias_scratch_apart_by_buffers),
    CASE("dsts_made_before_binding", EITHER_CALL_SIZE(bind_late, 0, PLACE_SIZE)),
    CASE("dsts_bound_by_bind2", EITHER_CALL_SIZE(bind_both, 0, PLACE_SIZE)),
    CASE("dsts_perhaps_bound", RULES(RULE_dst_and_dst_are_apart, RULE_dst_is_backed_by_memory),
         .silent = true, .mutate = fail_to_bind_both, .needs_null_driver = true),
    CASE("dsts_in_one_instance_of_memory", .commands = ON_COMMAND_BUFFERS, .setup = &with_group,
         .mutate = use_own_instances, .mutate_twin = use_different_instances),
};

CASE_LIST(cases_memory, cases);
