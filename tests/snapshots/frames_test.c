/* SPDX-License-Identifier: Apache-2.0 */
/* Frames that build the same scene: in the steady state the layer creates nothing, and when the
 * builds stop it gives its memory back. On the null driver, which counts calls. */
#include "tests/snapshots/scene.h"

enum { IN_FLIGHT = 2, BOXES = 1000000, BOX_SIZE = sizeof(VkAabbPositionsKHR), IDLE_FRAMES = 10 };

static VkCommandBuffer commands[IN_FLIGHT];
static VkFence fences[IN_FLIGHT];
static uint32_t frame;

static void open_scene(void)
{
    SCENE_OPEN(.boxes_size = (VkDeviceSize)BOXES * BOX_SIZE, .structure_size = 1 << 26);
    for (uint32_t i = 0; i < IN_FLIGHT; i++) {
        commands[i] = fixture_begin(&fixture, 0);
        GET(fixture.vk.EndCommandBuffer(commands[i]));
        fences[i] = fence_create(&fixture.vk, fixture.device);
        GET(fixture_submit(&fixture, commands[i], fences[i]));
    }
    frame = 0;
}

static void close_scene(void)
{
    fixture_expect_silence(&fixture);
    for (uint32_t i = 0; i < IN_FLIGHT; i++)
        fixture.vk.DestroyFence(fixture.device, fences[i], NULL);
    scene_close();
}

/* Waits for the frame before the last, then records and submits. */
static void play_frame(uint32_t boxes)
{
    const STRUCT(VkCommandBufferBeginInfo, begin);
    const uint32_t i = frame++ % IN_FLIGHT;
    GET(fixture.vk.WaitForFences(fixture.device, 1, &fences[i], VK_TRUE, UINT64_MAX));
    GET(fixture.vk.ResetFences(fixture.device, 1, &fences[i]));
    GET(fixture.vk.BeginCommandBuffer(commands[i], &begin));
    if (boxes)
        scene_build_boxes(commands[i], boxes);
    GET(fixture.vk.EndCommandBuffer(commands[i]));
    GET(fixture_submit(&fixture, commands[i], fences[i]));
}

static void play_frames(uint32_t count, uint32_t boxes)
{
    for (uint32_t i = 0; i < count; i++)
        play_frame(boxes);
}

static uint64_t calls(const char *name)
{
    return platform.null_driver.calls(name);
}

static void expect_nothing_created(void)
{
    static const char *const names[] = {"vkAllocateMemory", "vkMapMemory",  "vkCreateBuffer",
                                        "vkCreateFence",    "vkFreeMemory", "vkDestroyFence"};
    for (size_t i = 0; i < ARRAY_COUNT(names); i++)
        assert_int_equal(calls(names[i]), 0);
}

#define FRAMES_TEST(name) TEST_BETWEEN_IF(name, open_scene, close_scene, true)

FRAMES_TEST(test_steady_state_creates_nothing)
{
    play_frames(4, BOXES);
    platform.null_driver.reset();
    play_frames(20, BOXES);
    expect_nothing_created();
}

/* A sixteenth more or less needs no other memory. */
FRAMES_TEST(test_slightly_larger_frames_create_nothing)
{
    play_frames(4, BOXES - BOXES / 40);
    platform.null_driver.reset();
    for (int i = 0; i < 20; i++)
        play_frame(BOXES - BOXES / 40 + i * 1000);
    expect_nothing_created();
}

/* Builds in every 20th submission are a steady state, too, once the layer has seen it. */
FRAMES_TEST(test_rare_builds_create_nothing)
{
    for (int i = 0; i < 60; i++)
        play_frame(i % 20 == 0 ? BOXES : 0);
    platform.null_driver.reset();
    for (int i = 60; i < 200; i++)
        play_frame(i % 20 == 0 ? BOXES : 0);
    expect_nothing_created();
}

FRAMES_TEST(test_idle_frames_give_memory_back)
{
    play_frames(4, BOXES);
    platform.null_driver.reset();
    play_frames(IN_FLIGHT + IDLE_FRAMES, 0);
    assert_int_equal(calls("vkFreeMemory"), IN_FLIGHT); /* each chunk has more than 16 MiB */
}

/* In the steady state the layer has 1.1 times the inputs of the frames in flight at most. */
FRAMES_TEST(test_memory_is_that_of_the_inputs)
{
    const uint64_t before = platform.null_driver.allocated();
    play_frames(20, BOXES);
    const uint64_t taken = platform.null_driver.allocated() - before;
    const uint64_t inputs = (uint64_t)IN_FLIGHT * BOXES * BOX_SIZE;
    assert_in_range(taken, inputs, inputs / 10 * 11);
}

FRAMES_TEST(test_small_memory_stays)
{
    play_frames(4, 1000);
    platform.null_driver.reset();
    for (int i = 0; i < 100; i++)
        play_frame(i == 99 ? 1000 : 0);
    expect_nothing_created();
}
