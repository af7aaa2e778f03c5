/* SPDX-License-Identifier: Apache-2.0 */
/* What backend cpu has built:
 *
 *     probe ...                           traces a ray: rays.c
 *     same | differ PLACE PLACE SIZE      the host compares bytes
 *     holds PLACE NUMBER...               the host reads numbers of 64 bits
 *     costs [only] [COUNTER NUMBER]...    vkGetCountersASSAY: since the last `costs`. `only`: all
 *                        other counters are the same
 *
 *     sizes [more] [scratch] SHAPE
 *                        `size` is the size of the structure that such a build needs, whoever
 *                        builds it, or of its scratch; `more`: than `size` was
 *
 * COUNTER is a word of the table below. NUMBER may be `some`: more than 0; or `size`: that which
 * the host got last. */
#include "tests/player/play.h"

#include <stddef.h>
#include <stdlib.h>
#include <string.h>

/* ---- bytes */

static void compare(struct play *play, char **words)
{
    VkDeviceSize a, b;
    const struct play_object *first = play_place(play, words[1], &a),
                             *second = play_place(play, words[2], &b);
    PLAY_REQUIRE(play, words[3] != NULL);
    const bool is_same =
        memcmp(first->buffer.bytes + a, second->buffer.bytes + b, strtoull(words[3], NULL, 0)) == 0;
    if (play->is_scarce || is_same == play_is(words[0], "same"))
        return;
    report_say(&play->report, "the bytes are%s the same\n", is_same ? "" : " not");
    play->report.outcome = OUTCOME_FAILED;
}

static void expect_numbers(struct play *play, char **words)
{
    const unsigned char *bytes = play_bytes(play, words[1]);
    for (words += 2; *words; words++, bytes += sizeof(uint64_t)) {
        uint64_t found;
        memcpy(&found, bytes, sizeof(found));
        play_expect_number(play, "a number", found, play_number(play, *words));
    }
}

/* ---- counters */

static const struct {
    const char *name;
    size_t offset;
} counters[] = {
    {"builds", offsetof(AssayCounters, builds)},
    {"updates", offsetof(AssayCounters, updates)},
    {"copies", offsetof(AssayCounters, copies)},
    {"primitives", offsetof(AssayCounters, primitives)},
    {"built", offsetof(AssayCounters, bytesBuilt)},
    {"serialized", offsetof(AssayCounters, bytesSerialized)},
    {"scratch", offsetof(AssayCounters, ownScratch)},
    {"rays", offsetof(AssayCounters, rays)},
    {"nodes", offsetof(AssayCounters, nodesVisited)},
    {"instances", offsetof(AssayCounters, instancesEntered)},
    {"tested", offsetof(AssayCounters, primitivesTested)},
    {"exact", offsetof(AssayCounters, exactCalls)},
    {"bytes", offsetof(AssayCounters, bytesSnapshot)},
    {"products", offsetof(AssayCounters, matrixProducts)},
    {"micromaps", offsetof(AssayCounters, micromapsRead)},
};

static uint64_t counter_of(const AssayCounters *all, size_t counter)
{
    return *(const uint64_t *)(const void *)((const char *)all + counters[counter].offset);
}

/* The word that says what is wanted of a counter, or NULL. */
static const char *wanted_of(char **words, const char *name)
{
    for (; words[0]; words += 2)
        if (play_is(words[0], name))
            return words[1];
    return NULL;
}

static void expect_costs(struct play *play, char **words)
{
    const PFN_vkGetCountersASSAY get = (PFN_vkGetCountersASSAY)play->fixture.get_device_proc_addr(
        play->device, "vkGetCountersASSAY");
    const bool is_only = play_is(words[0], "only");
    AssayCounters now = {0}, first = {.updates = UINT64_MAX};
    unsigned understood = 0, count = 0;
    PLAY_REQUIRE(play, get || play->is_scarce);
    if (get) {
        get(play->device, sizeof(now), &now);
        get(play->device, sizeof(now.builds), &first);
        PLAY_REQUIRE(play, first.builds == now.builds && first.updates == UINT64_MAX);
    }
    for (words += is_only; words[2 * count]; count++)
        PLAY_REQUIRE(play, words[2 * count + 1] != NULL);
    for (size_t i = 0; i < ARRAY_COUNT(counters); i++) {
        const char *wanted = wanted_of(words, counters[i].name);
        const uint64_t found = counter_of(&now, i) - counter_of(&play->counters, i);
        understood += wanted != NULL;
        if (play_is(wanted, "some"))
            play_expect_number(play, counters[i].name, found > 0, true);
        else if (wanted || is_only)
            play_expect_number(play, counters[i].name, found,
                               wanted ? play_number(play, wanted) : 0);
    }
    PLAY_REQUIRE(play, understood == count);
    play->counters = now;
}

/* ---- sizes */

static void get_sizes(struct play *play, char **words)
{
    const VkDeviceSize before = play->last_size;
    const bool is_more = play_is(words[0], "more"), is_scratch = play_is(words[is_more], "scratch");
    VkAccelerationStructureBuildSizesInfoKHR sizes[3];
    words += is_more + is_scratch;
    for (int i = 0; i < 3; i++)
        sizes[i] = play_build_sizes(play, words, (VkAccelerationStructureBuildTypeKHR)i);
    play_expect_number(play, "sizes differ",
                       memcmp(&sizes[0], &sizes[1], sizeof(sizes[0])) != 0 ||
                           memcmp(&sizes[0], &sizes[2], sizeof(sizes[0])) != 0,
                       false);
    play->last_size = is_scratch ? sizes[0].buildScratchSize : sizes[0].accelerationStructureSize;
    play_expect_number(play, "the size is more", play->last_size > (is_more ? before : 0), true);
    play_expect_number(play, "scratch of builds is more than that of updates",
                       sizes[0].buildScratchSize > sizes[0].updateScratchSize, true);
}

bool play_cpu(struct play *play, char **words)
{
    if (play_is(words[0], "probe"))
        play_probe(play, words);
    else if (play_is(words[0], "same") || play_is(words[0], "differ"))
        compare(play, words);
    else if (play_is(words[0], "holds"))
        expect_numbers(play, words);
    else if (play_is(words[0], "sizes"))
        get_sizes(play, words + 1);
    else if (play_is(words[0], "costs"))
        expect_costs(play, words + 1);
    else
        return false;
    return true;
}
