/* SPDX-License-Identifier: Apache-2.0 */
/* What goes wrong on the null driver, and what reaches it:
 *
 *     allocation NUMBER fails           of the layer's, counted from here; then it may report less
 *     allocations fail from NUMBER      allocations succeed
 *     fail CALL RESULT [NUMBER]         the driver does nothing in its next call of that name, or
 *                              in the one of this number
 *     lose device              until `find device`, submissions and waits return DEVICE_LOST
 *     fault lose|hang at submit|wait|build [NUMBER] [early] [at-once] [computes|signals]
 *                              [address PLACE|NUMBER [type NUMBER]]
 *                              the device is lost or hangs at the next call or build, or at the one
 *                              of this number. `early`: before the copies in front of the build;
 *                              `at-once`: the submission returns the loss; `computes`, `signals`:
 *                              progress during the hang; `address`: of VK_EXT_device_fault;
 *                              `type`: a VkDeviceFaultAddressTypeEXT instead of READ_INVALID
 *     mock on | off            submissions complete, and nothing in them is executed
 *     end hang                 executes what was submitted
 *
 *     count CALL|CALL...       from here on. `memory`: bytes that are allocated; `invalid-queries`:
 *                              of addresses
 *     counted NUMBER [to NUMBER]      expects that so many of these calls have reached the driver
 *
 * RESULT is a VkResult without VK_ and ERROR_. A line that ends with `returns RESULT` expects it.
 */
#include "tests/player/play.h"

#include <stdlib.h>
#include <string.h>

static const struct {
    const char *name;
    VkResult result;
} results[] = {
    {"SUCCESS", VK_SUCCESS},
    {"NOT_READY", VK_NOT_READY},
    {"TIMEOUT", VK_TIMEOUT},
    {"DEVICE_LOST", VK_ERROR_DEVICE_LOST},
    {"OUT_OF_HOST_MEMORY", VK_ERROR_OUT_OF_HOST_MEMORY},
    {"OUT_OF_DEVICE_MEMORY", VK_ERROR_OUT_OF_DEVICE_MEMORY},
    {"VALIDATION_FAILED", VK_ERROR_VALIDATION_FAILED_EXT},
    {"INITIALIZATION_FAILED", VK_ERROR_INITIALIZATION_FAILED},
};

const char *play_name_of(VkResult result)
{
    for (size_t i = 0; i < ARRAY_COUNT(results); i++)
        if (results[i].result == result)
            return results[i].name;
    return "another result";
}

VkResult play_result_named(const struct play *play, const char *name)
{
    for (size_t i = 0; i < ARRAY_COUNT(results); i++)
        if (play_is(name, results[i].name))
            return results[i].result;
    play_fail(play, "returns what?");
}

/* ---- planned faults */

static enum null_driver_place place_named(const struct play *play, const char *name)
{
    PLAY_REQUIRE(play, play_is(name, "submit") || play_is(name, "wait") || play_is(name, "build"));
    return play_is(name, "submit") ? NULL_DRIVER_AT_SUBMIT
           : play_is(name, "wait") ? NULL_DRIVER_AT_WAIT
                                   : NULL_DRIVER_AT_BUILD;
}

static bool is_number(const char *word)
{
    return *word >= '0' && *word <= '9';
}

/* fault KIND at PLACE OPTIONS */
static void plan(struct play *play, char **words)
{
    struct null_driver_fault fault = {
        .precision = 64, .address_type = VK_DEVICE_FAULT_ADDRESS_TYPE_READ_INVALID_EXT};
    PLAY_REQUIRE(play, (play_is(words[1], "lose") || play_is(words[1], "hang")) &&
                           play_is(words[2], "at"));
    fault.kind = play_is(words[1], "lose") ? NULL_DRIVER_LOSE : NULL_DRIVER_HANG;
    fault.at = place_named(play, words[3]);
    for (words += 4; *words; words++) {
        if (is_number(*words))
            fault.number = (uint32_t)atoi(*words);
        else if (play_is(*words, "early"))
            fault.skips_copies = true;
        else if (play_is(*words, "at-once"))
            fault.is_at_once = true;
        else if (play_is(*words, "computes"))
            fault.progress = NULL_DRIVER_COMPUTES;
        else if (play_is(*words, "signals"))
            fault.progress = NULL_DRIVER_SIGNALS;
        else if (play_is(*words, "type") && words[1])
            fault.address_type = (VkDeviceFaultAddressTypeEXT)atoi(*++words);
        else if (play_is(*words, "address") && words[1])
            fault.address =
                is_number(*++words) ? strtoull(*words, NULL, 0) : play_address(play, *words);
        else
            play_fail(play, *words);
    }
    play->platform->null_driver.plan_fault(&fault);
}

/* ---- calls */

static uint64_t calls_named(const struct null_driver_api *driver, const char *name)
{
    return play_is(name, "memory")            ? driver->allocated()
           : play_is(name, "invalid-queries") ? driver->invalid_queries()
                                              : driver->calls(name);
}

/* Calls by the names that the last `count` has. */
static uint64_t calls_of(const struct play *play, const char *names)
{
    uint64_t count = 0;
    char name[128];
    for (;; names++) {
        const size_t length = strcspn(names, "|");
        PLAY_REQUIRE(play, length < sizeof(name));
        memcpy(name, names, length);
        name[length] = '\0';
        const uint64_t calls = calls_named(&play->platform->null_driver, name);
        PLAY_REQUIRE(play, calls != UINT64_MAX);
        count += calls;
        names += length;
        if (!*names)
            return count;
    }
}

/* counted NUMBER [to NUMBER] */
static void expect_calls(struct play *play, char **words)
{
    const uint64_t count = calls_of(play, play->counted) - play->count_before;
    const uint64_t least = play_number(play, words[1]);
    const uint64_t most = play_is(words[2], "to") ? play_number(play, words[3]) : least;
    if (count >= least && count <= most)
        return;
    report_say(&play->report, "%llu calls of %s instead of %llu to %llu\n",
               (unsigned long long)count, play->counted, (unsigned long long)least,
               (unsigned long long)most);
    play->report.outcome = OUTCOME_FAILED;
}

static bool fail_allocations(struct play *play, char **words)
{
    const bool is_one = play_is(words[0], "allocation"), is_end = play_is(words[1], "succeed");
    if (!is_one && !play_is(words[0], "allocations"))
        return false;
    const char *number = is_end ? "0" : words[is_one ? 1 : 3];
    PLAY_REQUIRE(play, number != NULL);
    play->is_scarce |= !is_end;
    play->platform->fail_allocations(atoi(number) - 1, !is_one);
    return true;
}

bool play_fault(struct play *play, char **words)
{
    const struct null_driver_api *driver = &play->platform->null_driver;
    if (play_is(words[0], "fail")) {
        PLAY_REQUIRE(play, words[1] != NULL && words[2] != NULL);
        driver->fail_at(words[1], words[3] ? (uint32_t)atoi(words[3]) : 1,
                        play_result_named(play, words[2]));
    } else if (play_is(words[0], "fault")) {
        plan(play, words);
    } else if (play_is(words[0], "end") && play_is(words[1], "hang")) {
        driver->end_hang();
    } else if (play_is(words[0], "mock")) {
        driver->set_executes_nothing(play_is(words[1], "on"));
    } else if (play_is(words[0], "count")) {
        play->counted = words[1];
        play->count_before = calls_of(play, words[1]);
    } else if (play_is(words[0], "counted")) {
        expect_calls(play, words);
    } else if (play_is(words[1], "device") &&
               (play_is(words[0], "lose") || play_is(words[0], "find"))) {
        driver->set_device_lost(play_is(words[0], "lose"));
        play->was_lost = true;
    } else {
        return fail_allocations(play, words);
    }
    return true;
}
