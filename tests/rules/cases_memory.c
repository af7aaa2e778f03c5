/* SPDX-License-Identifier: Apache-2.0 */
/* Where bytes live: overlap through aliasing buffers, late bindings, instances of memory. */
#include "case.h"
#include "placing.h"

/* ---- buffers that alias ---- */

/* Two buffers of the scene that is played, in one memory, the second at an offset of it. */
static struct test_buffer buffers[2];
static void make_two_buffers(struct scene *scene, VkDeviceSize offset)
{
    const struct test_memory memory = scene_allocate(scene, 2 * PLACE_SIZE);
    for (int i = 0; i < 2; i++) {
        buffers[i] = scene_create_buffer(scene, PLACE_SIZE, PLACE_USAGE);
        scene_bind(scene, &buffers[i], &memory, i == 0 ? 0 : offset);
    }
}

static void dst_in_first(struct scene *scene, uint32_t build, VkDeviceSize offset)
{
    place_dst(scene, build, &buffers[0], offset);
}

static void dst_in_second(struct scene *scene, uint32_t build, VkDeviceSize offset)
{
    place_dst(scene, build, &buffers[1], offset);
}

static void src_in_first(struct scene *scene, uint32_t build, VkDeviceSize offset)
{
    place_src(scene, build, &buffers[0], offset);
}

static void scratch_in_second(struct scene *scene, uint32_t build, VkDeviceSize offset)
{
    place_scratch(scene, build, &buffers[1], offset);
}

#define TWO_BUFFERS(offset) CALL_WITH_SIZE(make_two_buffers, offset)
#define DSTS(first, second)                                                                        \
    CALL_FOR(dst_in_first, INDEXED, first), CALL_FOR(dst_in_second, AABBS, second)

/* ---- bindings made late ---- */

/* The structures are created while their buffers have no memory. */
static void bind_late(struct scene *scene, VkDeviceSize second_offset)
{
    for (int i = 0; i < 2; i++)
        buffers[i] = scene_create_buffer(scene, PLACE_SIZE, PLACE_USAGE);
    place_dst(scene, INDEXED, &buffers[0], 0);
    place_dst(scene, AABBS, &buffers[1], 0);
    const struct test_memory memory = scene_allocate(scene, 2 * PLACE_SIZE);
    scene_bind(scene, &buffers[0], &memory, 0);
    scene_bind(scene, &buffers[1], &memory, second_offset);
}

/* vkBindBufferMemory2 of two buffers at once. */
static VkResult bind2(struct scene *scene, VkDeviceSize second_offset)
{
    VkBindBufferMemoryInfo infos[2];
    const struct test_memory memory = scene_allocate(scene, 2 * PLACE_SIZE);

    for (int i = 0; i < 2; i++) {
        buffers[i] = scene_create_buffer(scene, PLACE_SIZE, PLACE_USAGE);
        infos[i] = (VkBindBufferMemoryInfo){.sType = VK_STRUCTURE_TYPE_BIND_BUFFER_MEMORY_INFO,
                                            .buffer = buffers[i].handle,
                                            .memory = memory.handle,
                                            .memoryOffset = i == 0 ? 0 : second_offset};
    }
    const VkResult result = scene->vk->BindBufferMemory2(scene->fixture->device, 2, infos);
    place_dst(scene, INDEXED, &buffers[0], 0);
    place_dst(scene, AABBS, &buffers[1], 0);
    return result;
}

static void bind_both(struct scene *scene, VkDeviceSize second_offset)
{
    expect_success(bind2(scene, second_offset), "vkBindBufferMemory2");
}

/* After a failure nobody knows which of the buffers are bound. */
static void fail_to_bind_both(struct scene *scene)
{
    scene->fixture->platform->null_driver.fail_next("vkBindBufferMemory2",
                                                    VK_ERROR_OUT_OF_DEVICE_MEMORY);
    bind2(scene, 0);
}

/* ---- instances of memory ---- */

/* Two structures at one offset of memory that each physical device has an instance of. */
static void use_instances(struct scene *scene, const uint32_t first[2], const uint32_t second[2])
{
    const uint32_t *const indices[2] = {first, second};
    const struct test_memory memory =
        scene_allocate_with(scene, PLACE_SIZE, VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT, NULL);

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
    /* The same offsets in the buffers; the twin has other places in the memory. */
    CASE("dsts_in_aliasing_buffers", EDITS(TWO_BUFFERS(0), DSTS(PLACE_FAR, PLACE_FAR)),
         TWIN_EDITS(TWO_BUFFERS(PLACE_SIZE), DSTS(PLACE_FAR, PLACE_FAR))),
    /* Other offsets in the buffers, the same place in the memory. */
    CASE("dsts_in_aliasing_buffers_with_shift",
         EDITS(TWO_BUFFERS(PLACE_FAR), DSTS(2 * PLACE_FAR, PLACE_FAR)),
         TWIN_EDITS(TWO_BUFFERS(PLACE_FAR), DSTS(PLACE_FAR, PLACE_FAR))),
    CASE("update_in_aliasing_buffers", RULE(update_src_and_dst_do_not_alias),
         EDITS(TWO_BUFFERS(PLACE_FAR), CALL_FOR(src_in_first, UPDATE, PLACE_FAR),
               CALL_FOR(dst_in_second, UPDATE, 0)),
         TWIN_EDITS(TWO_BUFFERS(PLACE_FAR), CALL_FOR(src_in_first, UPDATE, 0),
                    CALL_FOR(dst_in_second, UPDATE, 0))),
    CASE("dst_and_scratch_in_aliasing_buffers", RULE(dst_and_scratch_are_apart),
         EDITS(TWO_BUFFERS(0), CALL_FOR(dst_in_first, INDEXED, PLACE_FAR),
               CALL_FOR(scratch_in_second, AABBS, PLACE_FAR)),
         TWIN_EDITS(TWO_BUFFERS(0), CALL_FOR(dst_in_first, INDEXED, PLACE_FAR),
                    CALL_FOR(scratch_in_second, AABBS, 2 * PLACE_FAR))),
    CASE("dsts_made_before_binding", EITHER_CALL_SIZE(bind_late, 0, PLACE_SIZE)),
    CASE("dsts_bound_by_bind2", EITHER_CALL_SIZE(bind_both, 0, PLACE_SIZE)),
    CASE("dsts_perhaps_bound", RULES(RULE_dst_and_dst_are_apart, RULE_dst_is_backed_by_memory),
         .silent = true, .mutate = fail_to_bind_both, .needs_null_driver = true),
    CASE("dsts_in_one_instance_of_memory", .commands = ON_COMMAND_BUFFERS,
         SETUP(.enable = ENABLE_GROUP), .mutate = use_own_instances,
         .mutate_twin = use_different_instances),
};

CASE_LIST(cases_memory, cases);
