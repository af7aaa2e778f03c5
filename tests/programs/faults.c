/* SPDX-License-Identifier: Apache-2.0 */
/* What goes wrong on the null driver:
 *
 *     fail CALL RESULT         the driver does nothing in its next call of that name
 *     lose device              until `find device`, submissions and waits return DEVICE_LOST
 *
 * RESULT is a VkResult without VK_ and ERROR_. A line that ends with `returns RESULT` expects it.
 */
#include "play.h"

static const struct {
    const char *name;
    VkResult result;
} results[] = {
    {"SUCCESS", VK_SUCCESS},
    {"NOT_READY", VK_NOT_READY},
    {"DEVICE_LOST", VK_ERROR_DEVICE_LOST},
    {"OUT_OF_HOST_MEMORY", VK_ERROR_OUT_OF_HOST_MEMORY},
    {"OUT_OF_DEVICE_MEMORY", VK_ERROR_OUT_OF_DEVICE_MEMORY},
    {"VALIDATION_FAILED", VK_ERROR_VALIDATION_FAILED_EXT},
};

VkResult play_result_named(const struct play *play, const char *name)
{
    for (size_t i = 0; i < ARRAY_COUNT(results); i++)
        if (play_is(name, results[i].name))
            return results[i].result;
    play_fail(play, "returns what?");
}

bool play_fault(struct play *play, char **words)
{
    const struct null_driver_api *driver = &play->platform->null_driver;
    if (play_is(words[0], "fail")) {
        PLAY_REQUIRE(play, words[1] != NULL);
        driver->fail_next(words[1], play_result_named(play, words[2]));
    } else if (play_is(words[1], "device") &&
               (play_is(words[0], "lose") || play_is(words[0], "find"))) {
        driver->set_device_lost(play_is(words[0], "lose"));
        play->was_lost = true;
    } else {
        return false;
    }
    return true;
}
