/* SPDX-License-Identifier: Apache-2.0 */
/* What accuracy costs in time on this scene, and what it is worth. The truth is accuracy exact. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "src/scene/report/report.h"

enum {
    CHUNK = 512, /* rays that a thread takes */
    TIMES = 3,   /* passes, of which the faster counts */
    PROBES = 64, /* rays that show how much work the others are */
    RAYS_LEAST = 8,
};
#define WORK_MOST 5e6      /* nodes and primitives of a set at accuracy exact */
#define SAME_DISTANCE 1e-3 /* relative: a level that is less accurate finds the same hit */

const char *const accuracy_names[3] = {"fast", "robust", "exact"};
const char *const quality_names[3] = {"fast", "balanced", "high"};

/* ---- answers */

static enum trace_answer keep_distance(void *context, struct trace_hit *candidate)
{
    struct answer *answer = context;
    uint32_t at = answer->count < ANSWER_MOST ? answer->count : ANSWER_MOST;
    answer->count++;
    while (at > 0 && answer->t[at - 1] > candidate->t) {
        if (at < ANSWER_MOST)
            answer->t[at] = answer->t[at - 1];
        at--;
    }
    if (at < ANSWER_MOST)
        answer->t[at] = candidate->t;
    return TRACE_IGNORE;
}

void answer_find(const struct trace_scene *scene, const struct trace_ray *ray,
                 struct answer *answer)
{
    const struct trace_visitor visitor = {keep_distance, answer};
    answer->count = 0;
    trace_candidates(scene, ray, &visitor);
}

static bool are_same(float a, float b)
{
    return fabs((double)a - b) <= SAME_DISTANCE * fmax(fabs((double)a), fabs((double)b));
}

bool wrong_add(struct wrong *wrong, const struct answer *truth, const struct answer *answer)
{
    const uint32_t truths = truth->count < ANSWER_MOST ? truth->count : ANSWER_MOST,
                   answers = answer->count < ANSWER_MOST ? answer->count : ANSWER_MOST;
    /* The ends of lists that were cut are not compared: one hit more or less moves all behind it.
     */
    const bool is_cut = truth->count > ANSWER_MOST || answer->count > ANSWER_MOST;
    uint32_t i = 0, j = 0, missed = 0, more = 0;
    while (i < truths && j < answers) {
        if (are_same(truth->t[i], answer->t[j])) {
            i++;
            j++;
        } else if (truth->t[i] < answer->t[j]) {
            missed++;
            i++;
        } else {
            more++;
            j++;
        }
    }
    missed += is_cut ? 0 : truths - i;
    more += is_cut ? 0 : answers - j;
    const bool is_nearest_wrong =
        (truths > 0) != (answers > 0) || (truths && !are_same(truth->t[0], answer->t[0]));
    wrong->rays++;
    wrong->missed += missed > 0;
    wrong->doubled += more > 0;
    wrong->nearest += is_nearest_wrong;
    wrong->wrong += missed || more || is_nearest_wrong;
    return missed || more || is_nearest_wrong;
}

static json_int_t in_a_million(uint64_t count, uint64_t rays)
{
    return rays ? (json_int_t)((count * 1000000 + rays / 2) / rays) : 0;
}

json_t *wrong_make(const struct wrong *wrong)
{
    return json_pack("{s:I, s:I, s:I, s:I, s:I}", "rays", (json_int_t)wrong->rays, "wrong",
                     in_a_million(wrong->wrong, wrong->rays), "missed",
                     in_a_million(wrong->missed, wrong->rays), "double",
                     in_a_million(wrong->doubled, wrong->rays), "nearest",
                     in_a_million(wrong->nearest, wrong->rays));
}

/* ---- sets of rays */

struct pass {
    struct trace_scene scene;
    const struct ray_set *set;
    struct answer *truths; /* filled if `finds_truths` */
    bool finds_truths;
    struct wrong *wrongs; /* one for each chunk */
    double *ns;
};

static void time_chunk(void *context, uint32_t index)
{
    const struct pass *pass = context;
    const uint32_t end =
        pass->set->count < (index + 1) * CHUNK ? pass->set->count : (index + 1) * CHUNK;
    struct trace_hit hit;
    const double begin = report_cpu_ns();
    for (uint32_t i = index * CHUNK; i < end; i++)
        trace_closest(&pass->scene, &pass->set->rays[i], &hit);
    pass->ns[index] = report_cpu_ns() - begin;
}

static void answer_chunk(void *context, uint32_t index)
{
    const struct pass *pass = context;
    const uint32_t end =
        pass->set->count < (index + 1) * CHUNK ? pass->set->count : (index + 1) * CHUNK;
    struct answer answer;
    for (uint32_t i = index * CHUNK; i < end; i++) {
        answer_find(&pass->scene, &pass->set->rays[i],
                    pass->finds_truths ? &pass->truths[i] : &answer);
        if (!pass->finds_truths)
            wrong_add(&pass->wrongs[index], &pass->truths[i], &answer);
    }
}

static uint32_t chunks_of(const struct ray_set *set)
{
    return (set->count + CHUNK - 1) / CHUNK;
}

double accuracy_time(struct report *report, enum trace_accuracy accuracy, const struct ray_set *set)
{
    struct pass pass = {.scene = report_scene(report, accuracy), .set = set};
    double least = INFINITY;
    pass.ns = capture_allocate(NULL, chunks_of(set), sizeof(*pass.ns));
    for (int i = 0; i < TIMES; i++) {
        double sum = 0;
        report_parallel(chunks_of(set), time_chunk, &pass);
        for (uint32_t chunk = 0; chunk < chunks_of(set); chunk++)
            sum += pass.ns[chunk];
        least = fmin(least, sum / set->count);
    }
    free(pass.ns);
    return least;
}

static void find_answers(struct report *report, enum trace_accuracy accuracy,
                         const struct ray_set *set, struct answer *truths, struct wrong *wrong)
{
    struct pass pass = {.scene = report_scene(report, accuracy),
                        .set = set,
                        .truths = truths,
                        .finds_truths = !wrong,
                        .wrongs = capture_allocate(NULL, chunks_of(set), sizeof(*pass.wrongs))};
    memset(pass.wrongs, 0, chunks_of(set) * sizeof(*pass.wrongs));
    report_parallel(chunks_of(set), answer_chunk, &pass);
    for (uint32_t i = 0; i < chunks_of(set) && wrong; i++) {
        wrong->rays += pass.wrongs[i].rays;
        wrong->wrong += pass.wrongs[i].wrong;
        wrong->missed += pass.wrongs[i].missed;
        wrong->doubled += pass.wrongs[i].doubled;
        wrong->nearest += pass.wrongs[i].nearest;
    }
    free(pass.wrongs);
}

/* ---- the part of the report */

void answers_find(struct report *report, enum trace_accuracy accuracy, const struct ray_set *set,
                  struct answer *answers)
{
    find_answers(report, accuracy, set, answers, NULL);
}

/* Leaves out rays of sets that are too much work: from far away, boxes are padded so far that a ray
 * meets all of them. Counts of work do not depend on the machine. */
static void limit_work(struct report *report, struct ray_set sets[RAY_SETS])
{
    for (int set = 0; set < RAY_SETS; set++) {
        struct trace_counters work = {0};
        struct trace_scene scene = report_scene(report, TRACE_EXACT);
        struct answer answer;
        scene.counters = &work;
        uint32_t probes = 0;
        while (probes < PROBES && probes < sets[set].count &&
               (double)(work.nodes + work.primitives) < WORK_MOST)
            answer_find(&scene, &sets[set].rays[probes++], &answer);
        const double each = (double)(work.nodes + work.primitives + 10 * work.exact_calls) / probes;
        if (set == RAYS_CAMERA)
            report->camera_work = each;
        const uint32_t most =
            WORK_MOST / each > RAYS_LEAST ? (uint32_t)fmin(WORK_MOST / each, 1e9) : RAYS_LEAST;
        sets[set].count = most < sets[set].count ? most : sets[set].count;
    }
}

static json_t *make_sets(const struct ray_set sets[RAY_SETS])
{
    json_t *array = json_array();
    for (int i = 0; i < RAY_SETS; i++)
        json_array_append_new(array, json_pack("{s:s, s:s, s:I}", "rays", sets[i].name, "says",
                                               sets[i].says, "count", (json_int_t)sets[i].count));
    return array;
}

static json_t *make_quality(const struct report *report, enum builder_quality quality,
                            const struct report_built *built)
{
    uint64_t primitives = 0;
    for (uint32_t i = 0; i < report->mesh_count; i++)
        primitives += report->meshes[i].primitives;
    return json_pack("{s:s, s:f, s:f, s:I, s:I, s:i, s:I}", "quality", quality_names[quality],
                     "ms build", built->ms, "sah", built->sah, "bytes", (json_int_t)built->bytes,
                     "nodes", (json_int_t)built->nodes, "depth", built->depth, "primitives",
                     (json_int_t)primitives);
}

void accuracy_report(struct report *report, struct ray_set sets[RAY_SETS])
{
    json_t *qualities = json_array(), *rows = json_array();
    struct answer *truths[RAY_SETS];
    struct report_built built;
    report_build(report, BUILDER_BALANCED, 0, &built);
    limit_work(report, sets);
    for (int set = 0; set < RAY_SETS; set++)
        truths[set] = capture_allocate(NULL, sets[set].count, sizeof(*truths[set]));
    for (int quality = BUILDER_FAST; quality <= BUILDER_HIGH; quality++) {
        char part[64];
        snprintf(part, sizeof(part), "accuracy in time, quality %s", quality_names[quality]);
        report_progress(report, part);
        report_build(report, (enum builder_quality)quality, 0, &built);
        json_array_append_new(qualities,
                              make_quality(report, (enum builder_quality)quality, &built));
        for (int set = 0; set < RAY_SETS; set++)
            find_answers(report, TRACE_EXACT, &sets[set], truths[set], NULL);
        for (int accuracy = TRACE_FAST; accuracy <= TRACE_EXACT; accuracy++)
            for (int set = 0; set < RAY_SETS; set++) {
                struct wrong wrong = {.rays = 0};
                json_t *row =
                    json_pack("{s:s, s:s, s:s, s:f}", "quality", quality_names[quality], "accuracy",
                              accuracy_names[accuracy], "set", sets[set].name, "ns a ray",
                              accuracy_time(report, (enum trace_accuracy)accuracy, &sets[set]));
                if (accuracy == TRACE_EXACT)
                    wrong.rays = sets[set].count;
                else
                    find_answers(report, (enum trace_accuracy)accuracy, &sets[set], truths[set],
                                 &wrong);
                json_object_update_new(row, wrong_make(&wrong));
                json_array_append_new(rows, row);
            }
    }
    for (int set = 0; set < RAY_SETS; set++)
        free(truths[set]);
    json_object_set_new(report->root, "accuracy",
                        json_pack("{s:o, s:o, s:o}", "sets", make_sets(sets), "qualities",
                                  qualities, "rows", rows));
}
