/* SPDX-License-Identifier: Apache-2.0 */
/* Comparing while the driver's fences fail: whichever wait fails or times out, nothing crashes or
 * stays allocated, and only what was compared is reported. On the null driver, which hits nothing.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tests/snapshots/scene.h"

enum { BUFFER_SIZE = 1 << 16, WAITS = 10, BUILDS = 3 };

/* A message about the driver's answers, or about what was not compared. */
static bool is_expected(const char *text)
{
    return strstr(text, "Driver: no hit") || strstr(text, "builds were not compared") ||
           strstr(text, "builds are unchecked") || strstr(text, "The device was lost");
}

static uint32_t compared, compared_tops; /* messages about answers in the last life */

static void submit(VkCommandBuffer commands)
{
    GET(fixture.vk.EndCommandBuffer(commands));
    GET(fixture_submit(&fixture, commands, VK_NULL_HANDLE));
    fixture.vk.QueueWaitIdle(fixture.queue);
}

/* Returns the number of waits. */
static uint64_t live(uint32_t failing, VkResult result)
{
    SCENE_OPEN(.boxes_size = BUFFER_SIZE, .structure_size = BUFFER_SIZE, .has_tlas = true);
    struct device_buffer instances = scene_input(BUFFER_SIZE);
    const VkAabbPositionsKHR box = {0, 0, 0, 1, 1, 1};
    memcpy(scene.boxes.bytes, &box, sizeof(box));
    if (failing)
        platform.null_driver.fail_at("vkWaitForFences", failing, result);
    for (int i = 0; i < BUILDS; i++)
        submit(scene_record_boxes(0, 1));
    scene_write_instance(&instances, true);
    VkCommandBuffer commands = fixture_begin(&fixture, 0);
    scene_build_instance(commands, instances.address, false);
    submit(commands);
    scene_close();
    const uint64_t waits = platform.null_driver.calls("vkWaitForFences");
    const struct messages *messages = &fixture.instance.messages;
    compared = compared_tops = 0;
    for (uint32_t i = 0; i < messages_kept(messages); i++) {
        if (!is_expected(messages->items[i].text))
            fail_msg("wait %u: %s", failing, messages->items[i].text);
        compared += strstr(messages->items[i].text, "Driver: no hit") != NULL;
        compared_tops += strstr(messages->items[i].text, "makes a TLAS whose instance 0") != NULL;
    }
    assert_int_equal(platform.null_driver.allocated(), 0);
    platform.null_driver.reset();
    return waits;
}

TEST(test_each_wait)
{
    static const VkResult results[] = {VK_TIMEOUT, VK_ERROR_OUT_OF_HOST_MEMORY,
                                       VK_ERROR_OUT_OF_DEVICE_MEMORY, VK_ERROR_DEVICE_LOST};
    const uint64_t waits = live(0, VK_SUCCESS);
    assert_in_range(waits, 2 * BUILDS, WAITS * (BUILDS + 1));
    const uint32_t all = compared;
    assert_in_range(all, BUILDS, UINT32_MAX);
    assert_in_range(compared_tops, 1, UINT32_MAX);
    for (uint32_t failing = 1; failing <= waits; failing++) {
        uint32_t least = all;
        for (size_t i = 0; i < sizeof(results) / sizeof(results[0]); i++) {
            live(failing, results[i]);
            least = compared < least ? compared : least;
        }
        assert_int_equal(compared, least); /* on a lost device nothing more is compared */
    }
}

TEST(test_messages_name_submissions)
{
    live(0, VK_SUCCESS);
    for (int i = 1; i <= BUILDS; i++) {
        char words[32];
        snprintf(words, sizeof(words), ", submission %d", i);
        assert_in_range(messages_count(&fixture.instance.messages, "ASSAY-compare-missed", words),
                        1, UINT32_MAX);
    }
}

const char *unit_test_open(const char *name)
{
    setenv("VK_ASSAY_VALIDATION_COMPARE_RAYS", "16", 1);
    return platform_open(&platform, name ? name : "null");
}
