/* SPDX-License-Identifier: Apache-2.0 */
/* Comparing while the driver's fences fail: whichever wait fails or times out, nothing crashes or
 * stays allocated, and only what was compared is reported. On the null driver, which hits nothing.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tests/player/play.h"
#include "tests/unit/unit_test.h"

enum { WAITS = 10, BUILDS = 3 };

static struct platform platform;
static struct play play;
static struct program program;

/* A message about the driver's answers, or about what was not compared. */
static bool is_expected(const char *text)
{
    return strstr(text, "Driver: no hit") || strstr(text, "builds were not compared") ||
           strstr(text, "builds are unchecked") || strstr(text, "The device was lost");
}

static uint32_t compared, compared_tops; /* messages about answers in the last life */

/* Executes commands of a program, whose messages are kept. */
static void execute(const char *text)
{
    program.line_count = 0;
    program.used = 0;
    play_words(&play, program_add(&program, text, 1)->words);
}

/* Returns the number of waits. */
static uint64_t live(uint32_t failing, VkResult result)
{
    program.line_count = 0;
    play = (struct play){.platform = &platform, .level = "content"};
    assert_true(play_begin(&play, &program));
    execute("init A0 floats 0 0 0 1 1 1");
    if (failing)
        platform.null_driver.fail_at("vkWaitForFences", failing, result);
    for (int i = 0; i < BUILDS; i++)
        execute("build B0 boxes A0 primitives 1; submit; host wait q0");
    execute("init I0 instances B0; top T0 instances I0 B0; submit; host wait q0; close");
    const uint64_t waits = platform.null_driver.calls("vkWaitForFences");
    assert_int_equal(platform.null_driver.allocated(), 0);
    assert_int_equal(platform.null_driver.invalid_queries(), 0);
    play_end(&play);
    play_close(&play);
    const struct messages *messages = &play.fixture.messages;
    compared = compared_tops = 0;
    for (uint32_t i = 0; i < messages_kept(messages); i++) {
        if (!is_expected(messages->items[i].text))
            fail_msg("wait %u: %s", failing, messages->items[i].text);
        compared += strstr(messages->items[i].text, "Driver: no hit") != NULL;
        compared_tops += strstr(messages->items[i].text, "makes a TLAS whose instance 0") != NULL;
    }
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
        assert_in_range(messages_count(&play.fixture.messages, "ASSAY-compare-missed", words), 1,
                        UINT32_MAX);
    }
}

const char *unit_test_open(const char *name)
{
    setenv("VK_ASSAY_VALIDATION_COMPARE_RAYS", "16", 1);
    return platform_open(&platform, name ? name : "null");
}
