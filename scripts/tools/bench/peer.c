/* SPDX-License-Identifier: Apache-2.0 */
/* What Assay adds to recording and submitting builds, at each level, beside what the Khronos layer
 * adds: all of them in turn, in one process. */
#include <math.h>
#include <stdlib.h>
#include <unistd.h>

#include "options.h"
#include "peer_report.h"
#include "recorder.h"
#include "scripts/tools/measure.h"

enum {
    BUILDS_PER_SAMPLE = 2000,
    PEER_MOST_BUILDS = 10000,  /* it takes minutes for more */
    SUBMIT_MOST_BUILDS = 1000, /* drivers for the CPU execute them */
    SUBMIT_SAMPLES = 9,
    THREAD_BUILDS = 1000,
    THREAD_SAMPLE_NS = 3 * 1000 * 1000, /* short: it may pass undisturbed, */
    THREAD_SAMPLES = 10                 /* and many, for each of another figure */
};

static const uint32_t sizes[] = {1, 10, 100, 1000, 10000, 100000};
enum { SIZE_COUNT = sizeof(sizes) / sizeof(sizes[0]) };

/* An application that builds one structure has others: calls go round all that are alive. Both
 * layers take several times as long for that as for the same few over and over. */
enum { ALIVE = 10000 };

static const struct scene_kind {
    const char *name;
    enum buffers buffers;
    enum order order;
    uint32_t alive; /* structures; a call's builds where those are more */
} scene_kinds[] = {
    {"in order", BUFFERS_SHARED, ORDER_CREATED, ALIVE},
    {"in order with a buffer for each input", BUFFERS_SEPARATE, ORDER_CREATED, ALIVE},
    {"shuffled with a buffer for each input", BUFFERS_SEPARATE, ORDER_SHUFFLED, ALIVE},
    {"in order, the same over and over", BUFFERS_SHARED, ORDER_CREATED, 0}};
enum { SCENE_KINDS = sizeof(scene_kinds) / sizeof(scene_kinds[0]) };

struct comparison {
    const struct peer_options *options;
    struct peer_report report;
    bool takes_part[CONTENDERS];
    struct side sides[CONTENDERS];
    struct recorder recorders[CONTENDERS];

    /* The current figure: which contenders are measured, on what, and the samples of each. */
    bool is_measured[CONTENDERS];
    uint32_t builds; /* a call */
    struct scene scenes[CONTENDERS];
    double *samples[CONTENDERS];
};

/* ---- the contenders */

static bool find_peer(const struct peer_options *options)
{
    VkLayerProperties found;
    if (!options->with_peer)
        return false;
    if (!layer_find(BENCH_PEER, &found)) {
        printf("The loader finds no " BENCH_PEER
               ": Assay is measured alone. To install it:\n"
               "apt install vulkan-validationlayers, or see vulkan.lunarg.com/sdk.\n");
        return false;
    }
    printf("%s %u.%u.%u, implementation version %u, with its default settings\n", found.layerName,
           VK_API_VERSION_MAJOR(found.specVersion), VK_API_VERSION_MINOR(found.specVersion),
           VK_API_VERSION_PATCH(found.specVersion), found.implementationVersion);
    return true;
}

static void open_all(struct comparison *comparison)
{
    layers_select_all(comparison->options->layers);
    driver_select(comparison->options->driver);
    bool has_peer = find_peer(comparison->options);
    for (int c = 0; c < CONTENDERS; c++) {
        comparison->takes_part[c] = c != PEER || has_peer;
        if (!comparison->takes_part[c])
            continue;
        const char *layer = c == PEER ? BENCH_PEER : c == NO_LAYER ? NULL : GPU_LAYER;
        side_open(&comparison->sides[c], layer,
                  c == PEER ? NULL : contender_name((enum contender)c));
        recorder_open(&comparison->recorders[c], &comparison->sides[c]);
    }
}

static void close_all(struct comparison *comparison)
{
    for (int c = 0; c < CONTENDERS; c++) {
        if (!comparison->takes_part[c])
            continue;
        recorder_close(&comparison->recorders[c]);
        side_close(&comparison->sides[c]);
    }
}

/* ---- figures */

/* Makes a scene for all that are to be measured on calls of so many builds. */
static void begin_figure(struct comparison *comparison, const struct scene_kind *kind,
                         uint32_t builds)
{
    comparison->builds = builds;
    for (int c = 0; c < CONTENDERS; c++) {
        comparison->is_measured[c] =
            comparison->takes_part[c] && (c != PEER || builds <= PEER_MOST_BUILDS);
        if (!comparison->is_measured[c])
            continue;
        scene_create(&comparison->scenes[c], &comparison->sides[c], kind->buffers, kind->order,
                     builds > kind->alive ? builds : kind->alive);
        comparison->samples[c] = tool_alloc(comparison->options->samples, sizeof(double));
    }
}

static void end_figure(struct comparison *comparison)
{
    for (int c = 0; c < CONTENDERS; c++) {
        if (!comparison->is_measured[c])
            continue;
        scene_destroy(&comparison->scenes[c]);
        free(comparison->samples[c]);
    }
}

/* To who watches. */
static void show_progress(uint32_t done, uint32_t all)
{
    if (!isatty(STDERR_FILENO))
        return;
    if (done < all)
        fprintf(stderr, "\r%u of %u samples", done, all);
    else
        fprintf(stderr, "\r%30s\r", "");
}

/* Takes a sample of each in turn; each is first as often. */
static void take_samples(struct comparison *comparison, uint32_t count,
                         double (*take)(struct comparison *comparison, int contender, void *user),
                         void *user)
{
    for (uint32_t i = 0; i < count; i++) {
        show_progress(i, count);
        for (uint32_t turn = 0; turn < CONTENDERS; turn++) {
            int c = (int)((i + turn) % CONTENDERS);
            if (comparison->is_measured[c])
                comparison->samples[c][i] = take(comparison, c, user);
        }
    }
    show_progress(count, count);
}

static struct figures quantiles(struct comparison *comparison, uint32_t count, double share)
{
    struct figures figures;
    for (int c = 0; c < CONTENDERS; c++)
        figures.of[c] = comparison->is_measured[c] ? quantile(comparison->samples[c], count, share)
                                                   : (double)NAN;
    return figures;
}

/* ---- recording */

/* The contender before leaves its data in the processor's caches, and leaves the more the more it
 * costs. So a recording that is not measured comes in between, unless an option forbids it. */
static double take_recording(struct comparison *comparison, int c, void *user)
{
    const struct scene *scene = &comparison->scenes[c];
    const struct recorder *recorder = &comparison->recorders[c];
    uint32_t times = (BUILDS_PER_SAMPLE + scene->count - 1) / scene->count;
    if (!comparison->options->cold)
        recorder_run(recorder, scene, comparison->builds, times);
    return recorder_time(recorder, scene, comparison->builds, times) /
           ((double)scene->count * times);
}

static void measure_recording(struct comparison *comparison, const struct scene_kind *kind)
{
    uint32_t count = comparison->options->samples;
    peer_report_scene(&comparison->report, kind->name);
    for (int s = 0; s < SIZE_COUNT && sizes[s] <= comparison->options->most_builds; s++) {
        begin_figure(comparison, kind, sizes[s]);
        take_samples(comparison, 1, take_recording, NULL); /* what is done once */
        take_samples(comparison, count, take_recording, NULL);
        struct figures figures = quantiles(comparison, count, 0.5);
        peer_report_recording(&comparison->report, kind->name, sizes[s], &figures);
        end_figure(comparison);
    }
}

/* ---- submissions */

/* Submissions and threads take builds of these alone. */
static const struct scene_kind same_builds = {"in order", BUFFERS_SHARED, ORDER_CREATED, 0};

struct submit_samples {
    double again[CONTENDERS][SUBMIT_SAMPLES];
    uint32_t taken[CONTENDERS];
};

static double take_submission(struct comparison *comparison, int c, void *user)
{
    struct submit_samples *samples = user;
    const struct scene *scene = &comparison->scenes[c];
    struct submit_times times = recorder_submit(&comparison->recorders[c], scene);
    samples->again[c][samples->taken[c]++] = times.again / scene->count;
    return times.first / scene->count;
}

static void measure_submission(struct comparison *comparison, uint32_t builds)
{
    struct submit_samples samples = {0};
    begin_figure(comparison, &same_builds, builds);
    for (int c = 0; c < CONTENDERS; c++)
        if (comparison->is_measured[c])
            recorder_clear_inputs(&comparison->recorders[c], &comparison->scenes[c]);
    uint32_t count = comparison->options->samples;
    count = count < SUBMIT_SAMPLES ? count : SUBMIT_SAMPLES;
    take_samples(comparison, count, take_submission, &samples);
    struct figures first = quantiles(comparison, count, 0.5), again = first;
    for (int c = 0; c < CONTENDERS; c++)
        if (comparison->is_measured[c])
            again.of[c] = quantile(samples.again[c], count, 0.5);
    peer_report_submission(&comparison->report, builds, &first, &again);
    end_figure(comparison);
}

static void measure_submissions(struct comparison *comparison)
{
    peer_report_submissions();
    for (int s = 0; s < SIZE_COUNT && sizes[s] <= SUBMIT_MOST_BUILDS &&
                    sizes[s] <= comparison->options->most_builds;
         s++)
        measure_submission(comparison, sizes[s]);
}

/* ---- threads */

struct thread_plan {
    uint32_t threads;
    uint32_t times[CONTENDERS];
    struct figures cpu;
};

static double take_threads(struct comparison *comparison, int c, void *user)
{
    struct thread_plan *plan = user;
    struct thread_times times = threads_time(&comparison->sides[c], &comparison->scenes[c],
                                             plan->threads, THREAD_BUILDS, plan->times[c]);
    plan->cpu.of[c] = times.cpu;
    return times.wall;
}

/* Calls enough for a sample of each. */
static void plan_threads(struct comparison *comparison, struct thread_plan *plan)
{
    plan->threads = 1;
    for (int c = 0; c < CONTENDERS; c++)
        plan->times[c] = 1;
    for (int c = 0; c < CONTENDERS; c++)
        if (comparison->is_measured[c])
            plan->times[c] +=
                (uint32_t)(THREAD_SAMPLE_NS / (take_threads(comparison, c, plan) * THREAD_BUILDS));
}

static void keep_least(struct figures *least, const struct figures *figures)
{
    for (int c = 0; c < CONTENDERS; c++)
        least->of[c] = fmin(least->of[c], figures->of[c]);
}

/* The least of all samples: what else runs on the machine only adds to them. */
static void measure_threads(struct comparison *comparison)
{
    struct figures wall[THREAD_COUNTS], cpu[THREAD_COUNTS], none;
    struct thread_plan plan;
    for (int c = 0; c < CONTENDERS; c++)
        none.of[c] = plan.cpu.of[c] = (double)NAN;
    for (int t = 0; t < THREAD_COUNTS; t++)
        wall[t] = cpu[t] = none;
    begin_figure(comparison, &same_builds, MOST_THREADS * THREAD_BUILDS);
    plan_threads(comparison, &plan);
    for (uint32_t i = 0; i < comparison->options->samples * THREAD_SAMPLES; i++) {
        for (int t = 0; t < THREAD_COUNTS; t++) {
            plan.threads = 1u << t;
            take_samples(comparison, 1, take_threads, &plan);
            struct figures figures = quantiles(comparison, 1, 0);
            keep_least(&wall[t], &figures);
            keep_least(&cpu[t], &plan.cpu);
        }
    }
    peer_report_threads(&comparison->report, THREAD_BUILDS, wall, cpu);
    end_figure(comparison);
}

int main(int argc, char **argv)
{
    struct peer_options options;
    struct comparison comparison = {.options = &options};
    peer_options_read(&options, argc, argv);
    peer_report_open(&comparison.report);
    comparison.report.with_bars = options.bars;
    open_all(&comparison);
    for (int kind = 0; kind < SCENE_KINDS; kind++)
        measure_recording(&comparison, &scene_kinds[kind]);
    measure_submissions(&comparison);
    measure_threads(&comparison);
    close_all(&comparison);
    return peer_report_close(&comparison.report) ? EXIT_SUCCESS : EXIT_FAILURE;
}
