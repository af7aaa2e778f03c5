/* SPDX-License-Identifier: Apache-2.0 */
/* What a frame costs without the layer, at level execution and at level content, there also with
 * setting hazards: each frame builds, submits and waits. Prints medians in milliseconds. */
#include <stdio.h>
#include <string.h>

#include "command_line.h"
#include "frames.h"
#include "scripts/tools/measure.h"
#include "tests/null_driver/null_driver.h"

enum { MOST_SIDES = 8, MOST_FRAMES = 1001 };

static const VkBool32 on = VK_TRUE, off = VK_FALSE;
static const char *const execution = "execution", *const content = "content";
enum { MOST_SETTINGS = 2 };
#define SETTING(layer, key, type, value)                                                           \
    {                                                                                              \
        layer, key, VK_LAYER_SETTING_TYPE_##type##_EXT, 1, value                                   \
    }
#define LEVEL(name) SETTING(GPU_LAYER, "level", STRING, name)
#define SWITCH(layer, key) SETTING(layer, key, BOOL32, &on)
#define NO_HAZARDS SETTING(GPU_LAYER, "hazards", BOOL32, &off)

/* Sides of both comparisons, or of one. */
enum comparison { IN_BOTH, OF_CONTENT, OF_HAZARDS };

static const struct side_kind {
    const char *name, *layer;
    enum comparison comparison;
    VkLayerSettingEXT settings[MOST_SETTINGS]; /* those without a name are none */
} side_kinds[MOST_SIDES] = {
    {"none", NULL, IN_BOTH, {{0}}},
    {"execution", GPU_LAYER, IN_BOTH, {LEVEL(&execution), NO_HAZARDS}},
    {"content", GPU_LAYER, OF_CONTENT, {LEVEL(&content), NO_HAZARDS}},
    {"content, hazards", GPU_LAYER, OF_CONTENT, {LEVEL(&content), SWITCH(GPU_LAYER, "hazards")}},
    {"hazards", GPU_LAYER, OF_HAZARDS, {SWITCH(GPU_LAYER, "hazards")}},
    {"khronos", BENCH_PEER, IN_BOTH, {{0}}},
    {"khronos GPU-AV", BENCH_PEER, OF_CONTENT, {SWITCH(BENCH_PEER, "gpuav_enable")}},
    {"khronos syncval", BENCH_PEER, OF_HAZARDS, {SWITCH(BENCH_PEER, "validate_sync")}},
};

static uint32_t count_settings(const struct side_kind *kind)
{
    uint32_t count = 0;
    while (count < MOST_SETTINGS && kind->settings[count].pSettingName)
        count++;
    return count;
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

struct options {
    const char *driver; /* NULL: the environment's */
    uint32_t frames;    /* 0: by the size of the scene */
    const char *only;   /* a side; NULL: all */
    const char *scene;  /* part of a scene's name; NULL: all scenes */
    const char *csv;    /* or NULL */
    bool with_peer, hazards;
};

struct bench {
    struct options options;
    struct side sides[MOST_SIDES];
    bool is_open[MOST_SIDES];
    FILE *csv;
};

struct samples {
    double wall[MOST_FRAMES], cpu[MOST_FRAMES];
};

static uint32_t frames_of(const struct options *options, const struct frame_kind *kind)
{
    if (options->frames)
        return options->frames;
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

static void print(const struct bench *bench, const struct frame_kind *kind, uint32_t count)
{
    printf("%-28s", kind->name);
    for (int s = 0; s < MOST_SIDES; s++) {
        if (!bench->is_open[s])
            continue;
        const double wall = quantile(samples[s].wall, count, 0.5);
        const double cpu = quantile(samples[s].cpu, count, 0.5);
        printf(" %9.3f / %8.3f", wall, cpu);
        if (bench->csv)
            fprintf(bench->csv, "\"%s\",%s,%.4f,%.4f\n", kind->name, side_kinds[s].name, wall, cpu);
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
    "  --peer           with VK_LAYER_KHRONOS_validation, too: as it is by default, and with\n"
    "                   its GPU-assisted checks\n"
    "  --only SIDE      for a profiler: the name of a column\n"
    "  --csv FILE       writes the figures there, too\n"
    "  --help           this text\n";

static const struct command_line_option option_table[] = {
    {"driver", command_line_text, offsetof(struct options, driver), true},
    {"scene", command_line_text, offsetof(struct options, scene), true},
    {"frames", command_line_count, offsetof(struct options, frames), true},
    {"only", command_line_text, offsetof(struct options, only), true},
    {"hazards", command_line_set, offsetof(struct options, hazards), false},
    {"peer", command_line_set, offsetof(struct options, with_peer), false},
    {"csv", command_line_text, offsetof(struct options, csv), true},
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
        const bool is_peer = kind->layer && strcmp(kind->layer, BENCH_PEER) == 0;
        const bool is_compared = kind->comparison != (options->hazards ? OF_CONTENT : OF_HAZARDS);
        bench->is_open[s] = options->only ? strcmp(options->only, kind->name) == 0
                                          : is_compared && (!is_peer || options->with_peer);
        if (bench->is_open[s])
            side_open_with(&bench->sides[s], kind->layer, kind->settings, count_settings(kind));
        if (bench->is_open[s] && is_peer)
            bench->sides[s].findings->is_open = false; /* ray queries are not enabled */
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
    if (options->driver && strcmp(options->driver, "null") == 0)
        raise_limits();
    bench.csv = command_line_open_csv(options->csv, "scene,side,wall_ms,cpu_ms");
    open_sides(&bench);
    print_heads(&bench);
    const struct frame_kind *kinds = options->hazards ? hazard_kinds : content_kinds;
    for (size_t i = 0; kinds[i].name; i++)
        if (!options->scene || strstr(kinds[i].name, options->scene))
            measure(&bench, &kinds[i]);
    for (int s = 0; s < MOST_SIDES; s++)
        if (bench.is_open[s])
            side_close(&bench.sides[s]);
    command_line_close_csv(bench.csv);
    return 0;
}
