/* SPDX-License-Identifier: Apache-2.0 */
/* What backend cpu has built:
 *
 *     probe STRUCTURE [hits | misses]     vkTraceRaysASSAY of one ray along x, from -1 0.25 0.25
 *     same | differ PLACE PLACE SIZE      the host compares bytes
 *     costs [COUNTER NUMBER]...           vkGetCountersASSAY: since the last `costs`; `products`:
 *                                         of positions and transforms; `copied`: bytes of inputs */
#include "play.h"
#include "tests/fixture/trace.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

static void probe(struct play *play, char **words)
{
    const PFN_vkTraceRaysASSAY trace_rays =
        (PFN_vkTraceRaysASSAY)play->fixture.get_device_proc_addr(play->device, "vkTraceRaysASSAY");
    const AssayRay ray = {
        .origin = {-1, 0.25f, 0.25f}, .direction = {1, 0, 0}, .tMax = 1000, .cullMask = 0xff};
    AssayHit hit = {0};
    const AssayTraceInfo info = trace_info((uint64_t)play_object(play, words[1])->structure,
                                           ASSAY_ACCURACY_FAST, 1, &ray, &hit);
    if (!trace_rays && play->is_scarce)
        return; /* the library that reads settings may lose one without a word */
    PLAY_REQUIRE(play, trace_rays != NULL);
    play_note(play, trace_rays(play->device, &info));
    if (!words[2] || hit.isHit == play_is(words[2], "hits") || play->is_scarce)
        return;
    play_say(play, "the ray hits %s\n", hit.isHit ? "something" : "nothing");
    play->outcome = OUTCOME_FAILED;
}

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
    play_say(play, "the bytes are%s the same\n", is_same ? "" : " not");
    play->outcome = OUTCOME_FAILED;
}

static void expect_cost(struct play *play, const AssayCounters *now, const char *name,
                        uint64_t wanted)
{
    const AssayCounters *before = &play->counters;
    const struct {
        const char *name;
        uint64_t found;
    } all[] = {
        {"builds", now->builds - before->builds},
        {"updates", now->updates - before->updates},
        {"copies", now->copies - before->copies},
        {"products", now->matrixProducts - before->matrixProducts},
        {"copied", now->bytesSnapshot - before->bytesSnapshot},
    };
    size_t i = 0;
    while (i < ARRAY_COUNT(all) && !play_is(name, all[i].name))
        i++;
    PLAY_REQUIRE(play, i < ARRAY_COUNT(all));
    if (all[i].found == wanted || play->is_scarce)
        return;
    play_say(play, "%s: %" PRIu64 " instead of %" PRIu64 "\n", name, all[i].found, wanted);
    play->outcome = OUTCOME_FAILED;
}

static void expect_costs(struct play *play, char **words)
{
    const PFN_vkGetCountersASSAY get = (PFN_vkGetCountersASSAY)play->fixture.get_device_proc_addr(
        play->device, "vkGetCountersASSAY");
    AssayCounters now = {0};
    PLAY_REQUIRE(play, get || play->is_scarce);
    if (get)
        get(play->device, sizeof(now), &now);
    for (; words[0] && words[1]; words += 2)
        expect_cost(play, &now, words[0], strtoull(words[1], NULL, 0));
    play->counters = now;
}

bool play_cpu(struct play *play, char **words)
{
    if (play_is(words[0], "probe"))
        probe(play, words);
    else if (play_is(words[0], "same") || play_is(words[0], "differ"))
        compare(play, words);
    else if (play_is(words[0], "costs"))
        expect_costs(play, words + 1);
    else
        return false;
    return true;
}
