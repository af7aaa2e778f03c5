/* SPDX-License-Identifier: Apache-2.0 */
/* What a frame costs without the layer, at level execution and at level content, there also with
 * setting hazards; or at each level: each frame builds, submits and waits. Prints medians. Or what
 * setting guard costs the device. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "command_line.h"
#include "frames.h"
#include "scripts/tools/measure.h"
#include "tests/null_driver/null_driver.h"

enum { MOST_SIDES = 16, MOST_FRAMES = 1001, GUARD_FRAMES = 15 };

static const VkBool32 on = VK_TRUE, off = VK_FALSE;
static const char *const parameters = "parameters", *const state = "state",
                         *const execution = "execution", *const content = "content",
                         *const json = "json", *const references = "references";
static const uint32_t compared_rays = 1000, large_budget_mib = 1024;
enum { MOST_SETTINGS = 3 };
#define SETTING(layer, key, type, value)                                                           \
    {                                                                                              \
        layer, key, VK_LAYER_SETTING_TYPE_##type##_EXT, 1, value                                   \
    }
#define LEVEL(name) SETTING(GPU_LAYER, "level", STRING, name)
#define SWITCH(layer, key) SETTING(layer, key, BOOL32, &on)
#define LARGE_BUDGET SETTING(GPU_LAYER, "content_budget_mib", UINT32, &large_budget_mib)
#define NO_HAZARDS SETTING(GPU_LAYER, "hazards", BOOL32, &off)

/* What is compared; a side may take part in several comparisons. */
enum { OF_CONTENT = 1, OF_HAZARDS = 2, OF_LEVELS = 4, OF_GUARD = 8, OF_ALL = 15 };

static const struct side_kind {
    const char *name, *layer;
    uint32_t comparisons;
    VkLayerSettingEXT settings[MOST_SETTINGS]; /* those without a name are none */
} side_kinds[MOST_SIDES] = {
    {"none", NULL, OF_ALL, {{0}}},
    {"execution", GPU_LAYER, OF_CONTENT | OF_HAZARDS, {LEVEL(&execution), NO_HAZARDS}},
    {"content", GPU_LAYER, OF_CONTENT, {LEVEL(&content), NO_HAZARDS}},
    {"content, hazards", GPU_LAYER, OF_CONTENT, {LEVEL(&content), SWITCH(GPU_LAYER, "hazards")}},
    {"hazards", GPU_LAYER, OF_HAZARDS, {SWITCH(GPU_LAYER, "hazards")}},
    {"parameters", GPU_LAYER, OF_LEVELS, {LEVEL(&parameters)}},
    {"state", GPU_LAYER, OF_LEVELS, {LEVEL(&state)}},
    {"execution", GPU_LAYER, OF_LEVELS, {LEVEL(&execution)}},
    {"content", GPU_LAYER, OF_LEVELS, {LEVEL(&content)}},
    /* To the file that the environment names. */
    {"execution + record",
     GPU_LAYER,
     OF_LEVELS,
     {LEVEL(&execution), SWITCH(GPU_LAYER, "record_builds"),
      SETTING(GPU_LAYER, "log_format", STRING, &json)}},
    {"content + compare",
     GPU_LAYER,
     OF_LEVELS,
     {LEVEL(&content), SETTING(GPU_LAYER, "compare_rays", UINT32, &compared_rays)}},
    {"copy", GPU_LAYER, OF_GUARD, {LEVEL(&content), LARGE_BUDGET}},
    {"copy and guard",
     GPU_LAYER,
     OF_GUARD,
     {LEVEL(&content), LARGE_BUDGET, SETTING(GPU_LAYER, "guard", STRING, &references)}},
    {"khronos", BENCH_PEER, OF_CONTENT | OF_HAZARDS, {{0}}},
    {"khronos GPU-AV", BENCH_PEER, OF_CONTENT, {SWITCH(BENCH_PEER, "gpuav_enable")}},
    {"khronos syncval", BENCH_PEER, OF_HAZARDS, {SWITCH(BENCH_PEER, "validate_sync")}},
};

static bool is_peer(const struct side_kind *kind)
{
    return kind->layer && strcmp(kind->layer, BENCH_PEER) == 0;
}

static void open_side(struct side *side, const struct side_kind *kind)
{
    uint32_t count = 0;
    while (count < MOST_SETTINGS && kind->settings[count].pSettingName)
        count++;
    side_open_with(side, kind->layer, kind->settings, count);
    /* Ray queries are not enabled; and drivers may differ in what rays hit. */
    if (is_peer(kind) || kind->settings[1].pValues == &compared_rays)
        side->findings->is_open = false;
}

/* The first one without a name ends the list. */
static const struct frame_kind content_kinds[] = {
    {"one small build", 1, 12, false, false, 0, 0},
    {"1,000 instances", 1, 1000, true, false, 0, 0},
    {"100,000 instances", 1, 100000, true, false, 0, 0},
    {"1,000,000 instances", 1, 1000000, true, false, 0, 0},
    {"1,000,000 triangles built", 1, 1000000, false, false, 0, 0},
    {"1,000,000 triangles updated", 1, 1000000, false, true, 0, 0},
    {"1,000 x 1,000 triangles", 1000, 1000, false, false, 0, 0},
    {0},
};
static const struct frame_kind hazard_kinds[] = {
    {"1,000 builds, 1 a call", 1000, 12, false, false, 1, 100},
    {"1,000 builds, 10 a call", 1000, 12, false, false, 10, 100},
    {"1,000 builds, 100 a call", 1000, 12, false, false, 100, 100},
    {"10,000 builds, 10 a call", 10000, 12, false, false, 10, 100},
    {"100,000 builds, 10 a call", 100000, 12, false, false, 10, 100},
    {"100,000 builds, 100 a call", 100000, 12, false, false, 100, 100},
    {0},
};

/* Each by the device, and by the host if it can build; a frame of many is a sample. */
static const struct frame_kind level_kinds[] = {
    {"one mesh", 1, 70000, false, false, 0, 0, .has_own_inputs = true},
    {"1,000 small meshes", 1000, 12, false, false, 0, 0, .has_own_inputs = true},
    {"100,000 instances", 1, 100000, true, false, 0, 0},
    {0},
};

struct options {
    const char *driver; /* NULL: the environment's */
    uint32_t frames;    /* 0: by the size of the scene */
    const char *only;   /* a side; NULL: all */
    const char *scene;  /* part of a scene's name; NULL: all scenes */
    bool with_peer, hazards, levels, guard, quick;
};

struct bench {
    struct options options;
    struct side sides[MOST_SIDES];
    bool is_open[MOST_SIDES];
};

/* A sample is the milliseconds of a frame; with --levels, the nanoseconds of a build. */
struct samples {
    double wall[MOST_FRAMES], cpu[MOST_FRAMES], thread[MOST_FRAMES];
};

static bool is_null(const struct options *options)
{
    return options->driver && strcmp(options->driver, "null") == 0;
}

static uint32_t frames_of(const struct options *options, const struct frame_kind *kind)
{
    if (options->frames)
        return options->frames;
    if (options->levels)
        return options->quick ? 3 : is_null(options) ? 31 : 7;
    const uint32_t primitives = kind->builds * kind->primitives;
    if (kind->builds_a_call)
        return kind->builds >= 100000 ? 5 : kind->builds >= 10000 ? 11 : 51;
    return primitives >= 1000000 ? 11 : primitives >= 100000 ? 101 : 201;
}

static struct samples samples[MOST_SIDES];

static void take_samples(struct frames *const frames[MOST_SIDES], uint32_t count)
{
    for (uint32_t i = 0; i < count; i++) {
        for (uint32_t turn = 0; turn < MOST_SIDES; turn++) {
            const uint32_t s = (i + turn) % MOST_SIDES;
            if (!frames[s])
                continue;
            const struct frame_times times = frames_run(frames[s]);
            samples[s].wall[i] = times.wall / 1e6;
            samples[s].cpu[i] = times.cpu / 1e6;
        }
    }
}

/* ---- what each level adds */

/* So many frames as take a millisecond, in which a level of some nanoseconds is not lost; one
 * where the driver takes its time. */
static void take_level_sample(struct frames *frames, const struct frame_kind *kind, uint32_t times,
                              struct samples *to, uint32_t i)
{
    to->cpu[i] = to->thread[i] = 0;
    for (uint32_t n = 0; n < times; n++) {
        const struct frame_times frame = frames_run(frames);
        to->cpu[i] += frame.cpu / kind->builds / times;
        to->thread[i] += frame.thread / kind->builds / times;
    }
}

/* Bytes that stay allocated once a scene is there and built, in a world that has seen nothing
 * else. */
static double measure_bytes(const struct side_kind *side_kind, const struct frame_kind *kind)
{
    struct side side;
    open_side(&side, side_kind);
    const double before = bytes_allocated();
    struct frames *frames = frames_open(kind, &side);
    frames_run(frames);
    const double bytes = (bytes_allocated() - before) / kind->builds;
    frames_close(frames);
    side_close(&side);
    return bytes;
}

static void print_level(const struct bench *bench, const struct frame_kind *kind, int s,
                        uint32_t count, double bytes)
{
    const double spread =
        quantile(samples[s].thread, count, 0.75) - quantile(samples[s].thread, count, 0.25);
    const double without = quantile(samples[0].thread, count, 0.5);
    printf("%s,\"%s\",%s,%s,%u,%.0f,%.0f,%.0f,%.0f,%.0f\n", bench->options.driver, kind->name,
           kind->by_host ? "host" : "device", side_kinds[s].name, kind->builds, without,
           quantile(samples[s].thread, count, 0.5) - without, spread / 2,
           quantile(samples[s].cpu, count, 0.5) - quantile(samples[0].cpu, count, 0.5), bytes);
}

static void measure_levels(struct bench *bench, const struct frame_kind *kind)
{
    const uint32_t count = frames_of(&bench->options, kind);
    struct frames *frames[MOST_SIDES] = {NULL};
    double bytes[MOST_SIDES];
    uint32_t times[MOST_SIDES];
    fprintf(stderr, "  levels: %s, %s, by the %s\n", bench->options.driver, kind->name,
            kind->by_host ? "host" : "device");
    for (int s = 0; s < MOST_SIDES; s++) {
        if (!bench->is_open[s])
            continue;
        bytes[s] = measure_bytes(&side_kinds[s], kind);
        frames[s] = frames_open(kind, &bench->sides[s]);
        frames_run(frames[s]);
        for (times[s] = 1; is_null(&bench->options); times[s] *= 2) {
            take_level_sample(frames[s], kind, times[s], &samples[s], 0);
            if (samples[s].thread[0] * kind->builds * times[s] >= 1e6)
                break;
        }
    }
    for (uint32_t i = 0; i < count; i++)
        for (uint32_t turn = 0; turn < MOST_SIDES; turn++) {
            const uint32_t s = (i + turn) % MOST_SIDES;
            if (frames[s])
                take_level_sample(frames[s], kind, times[s], &samples[s], i);
        }
    for (int s = 0; s < MOST_SIDES; s++) {
        if (s && frames[s])
            print_level(bench, kind, s, count, bytes[s] - bytes[0]);
        frames_close(frames[s]);
    }
    fflush(stdout);
}

static void measure_all_levels(struct bench *bench)
{
    printf(
        "driver,scene,by,level,builds,without_ns,added_ns,spread_ns,added_all_threads_ns,"
        "added_bytes\n");
    for (size_t i = 0; level_kinds[i].name; i++) {
        struct frame_kind kind = level_kinds[i];
        if (bench->options.quick)
            *(kind.builds > 1 ? &kind.builds : &kind.primitives) /= 100;
        measure_levels(bench, &kind);
        kind.by_host = true;
        if (bench->sides[0].gpu.has_host)
            measure_levels(bench, &kind);
    }
}

/* ---- what setting guard costs the device */

/* Milliseconds between timestamps of the fastest frame, because other work of the machine only adds
 * to it. */
static double measure_device(struct side *side, const struct frame_kind *kind)
{
    double best = INFINITY;
    struct frames *frames = frames_open(kind, side);
    for (uint32_t i = 0; i <= GUARD_FRAMES; i++) { /* the first makes what is made once */
        const double device = frames_run(frames).device / 1e6;
        best = i ? fmin(best, device) : best;
    }
    frames_close(frames);
    return best;
}

static void measure_guard(struct bench *bench)
{
    printf("| instances | build | and copy (level content) | and guard | copy | guard |\n");
    printf("| --- | --- | --- | --- | --- | --- |\n");
    for (uint32_t count = 1000; count <= 1000000; count *= 10) {
        const struct frame_kind kind = {"", 1, count, true, .has_timestamps = true};
        double times[3];
        int measured = 0;
        for (int s = 0; s < MOST_SIDES; s++)
            if (bench->is_open[s])
                times[measured++] = measure_device(&bench->sides[s], &kind);
        printf("| %u | %.3f ms | %.3f ms | %.3f ms | %.1f M/s | %.1f M/s |\n", count, times[0],
               times[1], times[2], count / (times[1] - times[0]) / 1e3,
               count / (times[2] - times[1]) / 1e3);
        fflush(stdout);
    }
}

/* ---- frames */

static void print(const struct bench *bench, const struct frame_kind *kind, uint32_t count)
{
    printf("%-28s", kind->name);
    for (int s = 0; s < MOST_SIDES; s++) {
        if (!bench->is_open[s])
            continue;
        printf(" %9.3f / %8.3f", quantile(samples[s].wall, count, 0.5),
               quantile(samples[s].cpu, count, 0.5));
    }
    printf("\n");
    fflush(stdout);
}

static void measure(struct bench *bench, const struct frame_kind *kind)
{
    const uint32_t count = frames_of(&bench->options, kind);
    struct frames *frames[MOST_SIDES] = {NULL};
    for (int s = 0; s < MOST_SIDES; s++) {
        if (!bench->is_open[s])
            continue;
        frames[s] = frames_open(kind, &bench->sides[s]);
        for (int i = 0; i < 3; i++) /* what is made once */
            frames_run(frames[s]);
    }
    take_samples(frames, count);
    print(bench, kind, count);
    for (int s = 0; s < MOST_SIDES; s++)
        frames_close(frames[s]);
}

/* ---- the command line */

static const char usage[] =
    "usage: content [OPTION]...\n"
    "\n"
    "Measures frames that record one call of builds, submit it and wait: without the layer,\n"
    "at level execution, and at level content with and without setting hazards, in turn. Prints\n"
    "medians in milliseconds: wall time / CPU time of all threads of the process.\n"
    "\n"
    "  --driver NAME    null or lavapipe (default: what the environment names)\n"
    "  --scene NAME     only scenes with this in their names\n"
    "  --frames N       of each scene (default: 11 to 201, by its size)\n"
    "  --hazards        compares many small builds, with a barrier every 100, with and without\n"
    "                   setting hazards (and the Khronos layer's synchronization validation)\n"
    "  --levels         prints what each level, setting record_builds and setting compare_rays\n"
    "                   add to a build of another list of scenes, in nanoseconds of CPU time\n"
    "                   and in bytes, as CSV; needs --driver\n"
    "  --guard          measures on the device what setting guard adds to builds of 1,000 to\n"
    "                   1,000,000 instances, as timestamps tell it: the fastest of 15\n"
    "  --quick          with --levels: a hundredth of the size, and three samples\n"
    "  --peer           with VK_LAYER_KHRONOS_validation, too: as it is by default, and with\n"
    "                   its GPU-assisted checks\n"
    "  --only SIDE      for a profiler: the name of a column\n"
    "  --help           this text\n";

static const struct command_line_option option_table[] = {
    {"driver", command_line_text, offsetof(struct options, driver), true},
    {"scene", command_line_text, offsetof(struct options, scene), true},
    {"frames", command_line_count, offsetof(struct options, frames), true},
    {"only", command_line_text, offsetof(struct options, only), true},
    {"hazards", command_line_set, offsetof(struct options, hazards), false},
    {"levels", command_line_set, offsetof(struct options, levels), false},
    {"guard", command_line_set, offsetof(struct options, guard), false},
    {"quick", command_line_set, offsetof(struct options, quick), false},
    {"peer", command_line_set, offsetof(struct options, with_peer), false},
};

/* The null driver's default limits are small. */
static void raise_limits(void)
{
    struct null_driver_api api;
    if (!null_driver_load(BENCH_NULL_DRIVER, &api))
        tool_fail("%s", dlerror());
    struct null_driver_config config = api.default_config();
    config.as_properties.maxInstanceCount = 1 << 24;
    api.configure(&config);
}

static void open_sides(struct bench *bench)
{
    const struct options *options = &bench->options;
    uint32_t count = 0;
    for (int s = 0; s < MOST_SIDES; s++) {
        const struct side_kind *kind = &side_kinds[s];
        const bool is_compared = kind->comparisons & (options->guard     ? OF_GUARD
                                                      : options->levels  ? OF_LEVELS
                                                      : options->hazards ? OF_HAZARDS
                                                                         : OF_CONTENT);
        bench->is_open[s] = is_compared && (options->only ? strcmp(options->only, kind->name) == 0
                                                          : !is_peer(kind) || options->with_peer);
        if (bench->is_open[s])
            open_side(&bench->sides[s], kind);
        count += bench->is_open[s];
    }
    if (!count)
        tool_fail("no side has the name %s", options->only);
}

static void print_heads(const struct bench *bench)
{
    printf("milliseconds: wall / CPU\n%-28s", "");
    for (int s = 0; s < MOST_SIDES; s++)
        if (bench->is_open[s])
            printf(" %20s", side_kinds[s].name);
    printf("\n");
}

int main(int argc, char **argv)
{
    const struct command_line line = {"content", usage, option_table,
                                      sizeof(option_table) / sizeof(option_table[0])};
    static struct bench bench;
    const struct options *options = &bench.options;
    command_line_read(&line, &bench.options, argc, argv);
    if (options->frames > MOST_FRAMES)
        tool_fail("--frames is at most %d", MOST_FRAMES);
    if (options->with_peer)
        layers_select_all(NULL);
    if (options->driver)
        driver_select(options->driver);
    if (is_null(options))
        raise_limits();
    if (options->guard && (options->only || options->with_peer))
        command_line_wrong(&line, "goes with neither --only nor --peer", "--guard");
    if (options->levels && !options->driver)
        command_line_wrong(&line, "needs --driver", "--levels");
    open_sides(&bench);
    if (options->guard) {
        measure_guard(&bench);
    } else if (options->levels) {
        measure_all_levels(&bench);
    } else {
        print_heads(&bench);
        const struct frame_kind *kinds = options->hazards ? hazard_kinds : content_kinds;
        for (size_t i = 0; kinds[i].name; i++)
            if (!options->scene || strstr(kinds[i].name, options->scene))
                measure(&bench, &kinds[i]);
    }
    for (int s = 0; s < MOST_SIDES; s++)
        if (bench.is_open[s])
            side_close(&bench.sides[s]);
    return 0;
}
