/* SPDX-License-Identifier: Apache-2.0 */
/* What reached the null driver since the last such line:
 *
 *     below BARRIER [, BARRIER]...      the stages and accesses of any command
 *     below nothing
 *
 * BARRIER: [COUNT] [own] [behind] [passed] STAGES[:ACCESSES] > STAGES[:ACCESSES] [with NUMBER].
 * `own`: of a buffer that the program did not create. `behind`: recorded behind a build; others in
 * front of all. `passed`: the driver got the memory of the last command itself; without it, a copy
 * will do. `with`: the size of a buffer or address range, the new layout of an image, or the
 * subpass that a dependency of a render pass leads to. A command
 * with one mask of stages has it in front of `> none`. So has a semaphore that a batch signals; one
 * that it waits for has it behind `none >`. */
#include "tests/player/commands/sync.h"

#include <stdlib.h>

enum { BARRIERS_MAX = 256 };

static bool is_own(const struct play *play, VkBuffer buffer)
{
    bool is_known = !buffer;
    for (unsigned i = 0; i < play->object_count; i++)
        is_known |= play->objects[i].buffer.handle == buffer;
    return !is_known;
}

static bool is_lent(const struct play *play, const void *masks)
{
    return (uintptr_t)masks - (uintptr_t)play->lent < play->lent_size;
}

struct expected {
    struct null_driver_barrier barrier; /* `builds`: 1 if behind a build */
    bool is_own, is_passed, has_detail;
};

/* Returns the words behind it. */
static char **read_barrier(struct play *play, char **words, struct expected *expected)
{
    expected->is_own = play_is(words[0], "own");
    words += expected->is_own;
    const bool is_behind = play_is(words[0], "behind");
    words += is_behind;
    expected->is_passed = play_is(words[0], "passed");
    words += expected->is_passed;
    PLAY_REQUIRE(play, words[0] && play_is(words[1], ">") && words[2]);
    expected->barrier = (struct null_driver_barrier){
        .src = play_stages(play, words[0]),
        .dst = play_stages(play, words[2]),
        .src_access = play_accesses(play, words[0]),
        .dst_access = play_accesses(play, words[2]),
        .builds = is_behind,
    };
    words += 3;
    expected->has_detail = play_is(words[0], "with");
    if (expected->has_detail) {
        expected->barrier.detail = strtoull(words[1], NULL, 0);
        words += 2;
    }
    return words[0] ? words + 1 : words;
}

static bool is_alike(const struct play *play, const struct null_driver_barrier *found,
                     const struct expected *expected)
{
    const struct null_driver_barrier *wanted = &expected->barrier;
    return found->src == wanted->src && found->dst == wanted->dst &&
           found->src_access == wanted->src_access && found->dst_access == wanted->dst_access &&
           (found->builds != 0) == wanted->builds &&
           is_own(play, found->buffer) == expected->is_own &&
           (!expected->is_passed || is_lent(play, found->masks)) &&
           (!expected->has_detail || found->detail == wanted->detail);
}

void play_expect_below(struct play *play, char **words)
{
    static struct null_driver_barrier found[BARRIERS_MAX];
    struct expected expected;
    const uint32_t count = play->platform->null_driver.take_barriers(found, BARRIERS_MAX);
    uint32_t at = 0;
    bool is_good = true;
    while (*words && !play_is(*words, "nothing")) {
        const bool is_counted = words[0][0] >= '0' && words[0][0] <= '9';
        const uint32_t end = at + (is_counted ? (uint32_t)atoi(words[0]) : 1);
        words = read_barrier(play, words + is_counted, &expected);
        for (; at < end; at++)
            is_good = is_good && at < count && is_alike(play, &found[at], &expected);
    }
    if ((is_good && at == count) || play->is_scarce)
        return;
    for (uint32_t i = 0; i < count; i++)
        report_say(&play->report, "the driver got %s%#llx:%#llx > %#llx:%#llx with %llu%s%s\n",
                   is_lent(play, found[i].masks) ? "passed " : "", (unsigned long long)found[i].src,
                   (unsigned long long)found[i].src_access, (unsigned long long)found[i].dst,
                   (unsigned long long)found[i].dst_access, (unsigned long long)found[i].detail,
                   found[i].builds ? ", behind a build" : "",
                   is_own(play, found[i].buffer) ? ", of another buffer" : "");
    report_say(&play->report, "the driver got %u barriers\n", count);
    play->report.outcome = OUTCOME_FAILED;
}
