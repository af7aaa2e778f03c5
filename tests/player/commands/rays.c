/* SPDX-License-Identifier: Apache-2.0 */
/* Rays that backend cpu traces:
 *
 *     probe STRUCTURE [from X Y Z] [along z | along nowhere] [time TIME | untimed]
 *         [first] [ignoring T] [entering T] [stopping] [misses | hits [MEMBER NUMBER]...]
 *                        vkTraceRaysASSAY of a ray along x, from -1 0.25 0.25 at time 0, and of
 *                        the same once more. `untimed`: rays have no time. `first`: they end at
 *                        their first hit. `ignoring`, `entering`, `stopping`: there is a
 *                        candidate function, which ignores what is nearer than T, adds T to the
 *                        t of boxes, or stops at what it does not ignore
 *     probe STRUCTURE wrong ARGUMENT      with an invalid argument
 *
 * MEMBER is a member of AssayHit, see below. */
#include "tests/fixture/trace.h"
#include "tests/player/play.h"

#include <float.h>
#include <math.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

enum { RAYS = 2 };

/* Numbers are equal if they differ by less than four roundings of the larger one, or of 1. */
static const float tolerance = 4 * FLT_EPSILON;

struct probe {
    AssayRay ray;
    size_t ray_size;
    bool has_candidates, stops;
    float ignored, entered;
    bool is_stopped[RAYS];
    unsigned wrong_rays; /* candidates of a ray that was not given, or has ended */
};

static float number_of(const struct play *play, const char *word)
{
    PLAY_REQUIRE(play, word != NULL);
    return strtof(word, NULL);
}

/* Reads a word and its operands. Returns the words behind them, or NULL if it is about the hit. */
static char **read_word(const struct play *play, char **words, struct probe *probe)
{
    AssayRay *ray = &probe->ray;
    if (play_is(words[0], "from")) {
        for (unsigned i = 0; i < 3; i++)
            ray->origin[i] = number_of(play, words[1 + i]);
        return words + 4;
    }
    if (play_is(words[0], "along")) {
        ray->direction[0] = 0;
        ray->direction[2] = play_is(words[1], "z");
        return words + 2;
    }
    if (play_is(words[0], "untimed")) {
        probe->ray_size = offsetof(AssayRay, time);
        return words + 1;
    }
    if (play_is(words[0], "first")) {
        ray->flags = 0x4;
        return words + 1;
    }
    if (play_is(words[0], "stopping")) {
        probe->has_candidates = probe->stops = true;
        return words + 1;
    }
    float *number = play_is(words[0], "time")       ? &ray->time
                    : play_is(words[0], "ignoring") ? &probe->ignored
                    : play_is(words[0], "entering") ? &probe->entered
                                                    : NULL;
    if (!number)
        return NULL;
    *number = number_of(play, words[1]);
    probe->has_candidates |= number != &ray->time;
    return words + 2;
}

static AssayAnswer answer(void *data, uint32_t ray, AssayHit *candidate)
{
    struct probe *probe = data;
    if (ray >= RAYS || probe->is_stopped[ray]) {
        probe->wrong_rays++;
        return ASSAY_ANSWER_IGNORE;
    }
    if (candidate->t < probe->ignored)
        return ASSAY_ANSWER_IGNORE;
    if (candidate->isAabb)
        candidate->t += probe->entered;
    probe->is_stopped[ray] = probe->stops;
    return probe->stops ? ASSAY_ANSWER_STOP : ASSAY_ANSWER_ACCEPT;
}

static void expect_member(struct play *play, const AssayHit *hit, const char *name,
                          const char *number)
{
    const struct {
        const char *name;
        float found;
    } all[] = {
        {"t", hit->t},
        {"u", hit->u},
        {"v", hit->v},
        {"geometry", (float)hit->geometry},
        {"primitive", (float)hit->primitive},
        {"instance", (float)hit->instance},
        {"custom", (float)hit->customIndex},
        {"box", (float)hit->isAabb},
        {"opaque", (float)hit->isOpaque},
    };
    size_t i = 0;
    while (i < ARRAY_COUNT(all) && !play_is(name, all[i].name))
        i++;
    PLAY_REQUIRE(play, i < ARRAY_COUNT(all));
    const float expected = number_of(play, number);
    const float size = fabsf(expected) > 1 ? fabsf(expected) : 1;
    if (fabsf(all[i].found - expected) < tolerance * size)
        return;
    report_say(&play->report, "%s of the hit: %.9g instead of %s\n", name, (double)all[i].found,
               number);
    play->report.outcome = OUTCOME_FAILED;
}

/* misses | hits [MEMBER NUMBER]... */
static void expect_hit(struct play *play, const AssayHit *hit, char **words)
{
    PLAY_REQUIRE(play, play_is(words[0], "hits") || play_is(words[0], "misses"));
    if (hit->isHit != play_is(words[0], "hits")) {
        report_say(&play->report, "the ray hits %s\n", hit->isHit ? "something" : "nothing");
        play->report.outcome = OUTCOME_FAILED;
    }
    for (words++; words[0]; words += 2)
        expect_member(play, hit, words[0], words[1]);
}

static void set_wrong(const struct play *play, AssayTraceInfo *info, const char *what)
{
    if (play_is(what, "ray-size"))
        info->raySize--;
    else if (play_is(what, "hit-size"))
        info->hitSize++;
    else if (play_is(what, "accuracy"))
        info->accuracy = (AssayAccuracy)(ASSAY_ACCURACY_EXACT + 1);
    else if (play_is(what, "rays"))
        info->rays = NULL;
    else if (play_is(what, "hits"))
        info->hits = (AssayHit *)(uintptr_t)0x1000;
    else if (play_is(what, "handle"))
        info->accelerationStructure++;
    else
        PLAY_REQUIRE(play, play_is(what, "info"));
}

void play_probe(struct play *play, char **words)
{
    const PFN_vkTraceRaysASSAY trace_rays =
        (PFN_vkTraceRaysASSAY)play->fixture.get_device_proc_addr(play->device, "vkTraceRaysASSAY");
    const struct play_object *object = play_object(play, words[1]);
    struct probe probe = {.ray = {.origin = {-1, 0.25f, 0.25f},
                                  .direction = {1, 0, 0},
                                  .tMax = 1000,
                                  .cullMask = 0xff},
                          .ray_size = sizeof(AssayRay)};
    _Alignas(AssayRay) char rays[RAYS * sizeof(AssayRay)];
    AssayHit hits[RAYS];
    const bool is_wrong = play_is(words[2], "wrong");
    memset(hits, 0xff, sizeof(hits)); /* a miss is written, too */
    words += is_wrong ? 4 : 2;
    for (char **next; words[0] && (next = read_word(play, words, &probe));)
        words = next;
    for (unsigned i = 0; i < RAYS; i++)
        memcpy(rays + i * probe.ray_size, &probe.ray, probe.ray_size);
    AssayTraceInfo info = trace_info((uint64_t)object->structure, ASSAY_ACCURACY_EXACT, RAYS,
                                     (const AssayRay *)(void *)rays, hits);
    info.raySize = probe.ray_size;
    info.candidate = probe.has_candidates ? answer : NULL;
    info.userData = &probe;
    if (is_wrong)
        set_wrong(play, &info, words[-1]);
    if (!trace_rays && play->is_scarce)
        return; /* the library that reads settings may lose one without a word */
    PLAY_REQUIRE(play, trace_rays != NULL);
    play_note(play,
              trace_rays(play->device, is_wrong && play_is(words[-1], "info") ? NULL : &info));
    PLAY_REQUIRE(play, !probe.wrong_rays);
    for (unsigned i = 0; i < RAYS && words[0] && !play->is_scarce; i++)
        expect_hit(play, &hits[i], words);
}
