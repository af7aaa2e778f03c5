/* SPDX-License-Identifier: Apache-2.0 */
/* What the layer adds to recording acceleration-structure builds: runs the cases, in turn with the
 * layer and without. */
#include <stdio.h>
#include <stdlib.h>

#include "options.h"
#include "probes.h"
#include "recorder.h"
#include "scripts/tools/measure.h"

/* ---- the two tables, and the bars that they are held to */

struct report {
    bool time_bars, memory_bars;
    double reference; /* the overhead at size GROWTH_FROM; 0 until measured */
    uint32_t bars, missed;
};

/* One measurement of one case. `spread` is half the interquartile range of the differences of
 * samples taken in turn. */
struct row {
    const char *driver, *buffers, *order;
    uint32_t builds_per_call;
    double without, with, spread; /* nanoseconds, or bytes, a build */
};

static const double most_overhead = 500; /* nanoseconds a build, from BAR_FROM builds a call up */
static const double most_growth = 1.5;   /* of the overhead a build from GROWTH_FROM to GROWTH_TO */
static const double most_memory = 512;   /* bytes a recorded build */
enum { BAR_FROM = 100, GROWTH_FROM = 1000, GROWTH_TO = 10000 };

static void report_open(struct report *report)
{
    *report = (struct report){.time_bars = true, .memory_bars = true};
    /* Rows come slowly: show each when it is there, also through a pipe. */
    setvbuf(stdout, NULL, _IOLBF, 0);
}

static void print_bar(struct report *report, const char *what, double value, double most)
{
    bool met = value <= most;
    report->bars++;
    report->missed += !met;
    printf("  %s at most %g: %s", what, most, met ? "met" : "MISSED");
}

static void report_time_head(uint32_t samples)
{
    printf("CPU ns a build of recording, medians of %u samples in turn\n\n", samples);
    printf("%-8s  %-8s  %-8s  %11s  %8s  %8s  %8s  %6s  %8s  %6s\n", "driver", "buffers", "order",
           "builds/call", "without", "with", "overhead", "+-", "ratio", "growth");
}

static void report_time(struct report *report, const struct row *row)
{
    double overhead = row->with - row->without;
    bool grows = row->builds_per_call > GROWTH_FROM && report->reference > 0;
    double growth = grows ? overhead / report->reference : 0;

    printf("%-8s  %-8s  %-8s  %11u  %8.1f  %8.1f  %8.1f  %6.1f  %8.1f", row->driver, row->buffers,
           row->order, row->builds_per_call, row->without, row->with, overhead, row->spread,
           row->with / row->without);
    if (grows)
        printf("  %6.2f", growth);
    else
        printf("  %6s", "");
    if (report->time_bars && row->builds_per_call >= BAR_FROM)
        print_bar(report, "overhead", overhead, most_overhead);
    if (report->time_bars && grows && row->builds_per_call == GROWTH_TO)
        print_bar(report, "growth", growth, most_growth);
    putchar('\n');
    if (row->builds_per_call == GROWTH_FROM)
        report->reference = overhead;
}

static void report_memory_head(uint32_t builds)
{
    printf("\nBytes a build that stay allocated while %u are recorded in one command buffer\n\n",
           builds);
    printf("%-8s  %-8s  %11s  %8s  %8s  %8s\n", "driver", "buffers", "builds/call", "without",
           "with", "layer");
}

static void report_memory(struct report *report, const struct row *row)
{
    double layer = row->with - row->without;
    printf("%-8s  %-8s  %11u  %8.1f  %8.1f  %8.1f", row->driver, row->buffers, row->builds_per_call,
           row->without, row->with, layer);
    if (report->memory_bars)
        print_bar(report, "layer", layer, most_memory);
    putchar('\n');
}

/* Prints how many bars were met. Returns whether all were. */
static bool report_close(const struct report *report)
{
    if (report->bars)
        printf("\nbars: %u of %u met\n", report->bars - report->missed, report->bars);
    return report->missed == 0;
}

/* ---- what is measured */

enum { WITHOUT, WITH, SIDES, MEMORY_BUILDS = 10000 };

/* One driver's two sides, and what is measured on them. */
struct bench {
    const struct options *options;
    const char *driver;
    struct side sides[SIDES];
    struct recorder recorders[SIDES];
};

struct bench_case {
    enum buffers buffers;
    enum order order;
    uint32_t builds; /* a call */
    uint32_t alive;  /* structures; as many as builds at least */
};

static void open_side(struct side *side, const struct options *options, bool is_with)
{
    const VkLayerSettingEXT call_sites = {GPU_LAYER, "call_sites", VK_LAYER_SETTING_TYPE_STRING_EXT,
                                          1, &options->call_sites};
    if (options->call_sites)
        side_open_with(side, GPU_LAYER, &call_sites, is_with);
    else
        side_open(side, is_with ? GPU_LAYER : NULL, options->level);
}

static void open_bench(struct bench *bench, const struct options *options, const char *driver)
{
    *bench = (struct bench){.options = options, .driver = driver};
    driver_select(driver);
    for (int s = 0; s < SIDES; s++) {
        open_side(&bench->sides[s], options, s == WITH);
        bench->sides[s].findings->are_expected = options->conflicts;
        recorder_open(&bench->recorders[s], &bench->sides[s]);
    }
}

static void close_bench(struct bench *bench)
{
    for (int s = 0; s < SIDES; s++) {
        recorder_close(&bench->recorders[s]);
        side_close(&bench->sides[s]);
    }
}

static struct row row_of(const struct bench *bench, const struct bench_case *which,
                         uint32_t builds_per_call)
{
    return (struct row){.driver = bench->driver,
                        .buffers = buffers_name(which->buffers),
                        .order = order_name(which->order),
                        .builds_per_call = builds_per_call};
}

/* ---- time */

/* Nanoseconds a build: fills `samples` values a side. */
static void take_samples(const struct bench *bench, const struct scene scenes[SIDES],
                         uint32_t builds_per_call, double *samples[SIDES])
{
    uint32_t builds = scenes[WITH].count;
    uint32_t times = (bench->options->builds_per_sample + builds - 1) / builds;
    for (int s = 0; s < SIDES; s++)
        recorder_run(&bench->recorders[s], &scenes[s], builds_per_call, times);
    for (uint32_t i = 0; i < bench->options->samples; i++) {
        for (uint32_t turn = 0; turn < SIDES; turn++) {
            int s = (int)((i + turn) % SIDES); /* either is first as often */
            double time = recorder_time(&bench->recorders[s], &scenes[s], builds_per_call, times);
            samples[s][i] = time / ((double)builds * times);
        }
    }
}

/* Callers that have frame pointers, and are as many as a call site has. */
enum { CALLERS = 16 };

__attribute__((noipa)) static void take_samples_deep(int callers, const struct bench *bench,
                                                     const struct scene scenes[SIDES],
                                                     uint32_t builds_per_call,
                                                     double *samples[SIDES])
{
    if (callers)
        take_samples_deep(callers - 1, bench, scenes, builds_per_call, samples);
    else
        take_samples(bench, scenes, builds_per_call, samples);
    __asm__ volatile("" ::: "memory"); /* no tail call */
}

static void measure_time(const struct bench *bench, const struct bench_case *which,
                         struct report *report)
{
    uint32_t count = bench->options->samples;
    struct row row = row_of(bench, which, which->builds);
    struct scene scenes[SIDES];
    double *samples[SIDES], *differences = tool_alloc(count, sizeof(double));
    for (int s = 0; s < SIDES; s++) {
        samples[s] = tool_alloc(count, sizeof(double));
        scene_create(&scenes[s], &bench->sides[s], which->buffers, which->order, which->alive);
        if (bench->options->conflicts)
            scene_conflict(&scenes[s]);
    }
    take_samples_deep(bench->options->call_sites ? CALLERS : 0, bench, scenes, which->builds,
                      samples);
    for (uint32_t i = 0; i < count; i++)
        differences[i] = samples[WITH][i] - samples[WITHOUT][i];
    row.spread = (quantile(differences, count, 0.75) - quantile(differences, count, 0.25)) / 2;
    row.without = quantile(samples[WITHOUT], count, 0.5);
    row.with = quantile(samples[WITH], count, 0.5);
    report_time(report, &row);
    for (int s = 0; s < SIDES; s++) {
        scene_destroy(&scenes[s]);
        free(samples[s]);
    }
    free(differences);
}

/* ---- memory */

static void measure_memory(const struct bench *bench, enum buffers buffers, struct report *report)
{
    static const uint32_t calls_of[] = {1, MEMORY_BUILDS};
    const struct bench_case which = {
        .buffers = buffers, .builds = MEMORY_BUILDS, .alive = MEMORY_BUILDS};
    struct scene scenes[SIDES];
    for (int s = 0; s < SIDES; s++) {
        scene_create(&scenes[s], &bench->sides[s], which.buffers, which.order, which.alive);
        recorder_run(&bench->recorders[s], &scenes[s], MEMORY_BUILDS, 2); /* what is kept once */
    }
    for (size_t i = 0; i < sizeof(calls_of) / sizeof(calls_of[0]); i++) {
        double without = recorder_memory(&scenes[WITHOUT], calls_of[i]);
        double with = recorder_memory(&scenes[WITH], calls_of[i]);
        struct row row = row_of(bench, &which, calls_of[i]);
        if (without < 0 || with < 0)
            tool_fail("the C library's allocator does not say how much is allocated");
        row.without = without / MEMORY_BUILDS;
        row.with = with / MEMORY_BUILDS;
        report_memory(report, &row);
    }
    for (int s = 0; s < SIDES; s++)
        scene_destroy(&scenes[s]);
}

/* ---- all of it */

static uint32_t larger_of(uint32_t a, uint32_t b)
{
    return a > b ? a : b;
}

static void measure_times(const struct bench *bench, struct report *report)
{
    const struct options *options = bench->options;
    for (int buffers = 0; buffers < 2; buffers++) {
        for (int order = 0; order < 2; order++) {
            if (!options->with_buffers[buffers] || !options->with_order[order])
                continue;
            report->reference = 0; /* of this series, whose smallest size comes first */
            for (uint32_t i = 0; i < options->sizes.count; i++) {
                const struct bench_case which = {
                    (enum buffers)buffers, (enum order)order, options->sizes.builds[i],
                    larger_of(options->sizes.builds[i], options->alive)};
                measure_time(bench, &which, report);
            }
        }
    }
}

static bool measure(const struct options *options)
{
    struct report report;
    struct bench benches[2];
    report_open(&report);
    report.time_bars = options->time_bars;
    report.memory_bars = options->memory_bars;
    report_time_head(options->samples);
    for (uint32_t d = 0; d < options->driver_count; d++) {
        open_bench(&benches[d], options, options->drivers[d]);
        measure_times(&benches[d], &report);
    }
    report_memory_head(MEMORY_BUILDS);
    for (uint32_t d = 0; d < options->driver_count; d++) {
        for (int buffers = 0; buffers < 2; buffers++) {
            if (options->with_buffers[buffers])
                measure_memory(&benches[d], (enum buffers)buffers, &report);
        }
        close_bench(&benches[d]);
    }
    return report_close(&report);
}

/* A profiler that collects only in here sees recordings, and nothing of what leads to them. */
__attribute__((noipa)) void profiled_recording(const struct recorder *recorder,
                                               const struct scene *scene, uint32_t builds_per_call);
void profiled_recording(const struct recorder *recorder, const struct scene *scene,
                        uint32_t builds_per_call)
{
    recorder_run(recorder, scene, builds_per_call, 1);
}

static void profile(const struct options *options)
{
    struct side side;
    struct recorder recorder;
    struct scene scene;
    driver_select(options->drivers[0]);
    open_side(&side, options, options->profile_with_layer);
    side.findings->are_expected = options->conflicts;
    recorder_open(&recorder, &side);
    scene_create(&scene, &side, options->with_buffers[0] ? BUFFERS_SHARED : BUFFERS_SEPARATE,
                 options->with_order[0] ? ORDER_CREATED : ORDER_SHUFFLED,
                 larger_of(options->sizes.builds[0], options->alive));
    if (options->conflicts)
        scene_conflict(&scene);
    probes_advance_clock();
    recorder_run(&recorder, &scene, options->sizes.builds[0], 2);
    uint64_t probes = probes_count();
    for (uint32_t i = 0; i < options->profile_times; i++) {
        probes_advance_clock();
        profiled_recording(&recorder, &scene, options->sizes.builds[0]);
    }
    printf("recorded %llu builds, %llu probes\n",
           (unsigned long long)options->profile_times * scene.count,
           (unsigned long long)(probes_count() - probes));
    scene_destroy(&scene);
    recorder_close(&recorder);
    side_close(&side);
}

int main(int argc, char **argv)
{
    struct options options;
    options_read(&options, argc, argv);
    if (options.profile) {
        profile(&options);
        return EXIT_SUCCESS;
    }
    return measure(&options) ? EXIT_SUCCESS : EXIT_FAILURE;
}
