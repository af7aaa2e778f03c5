/* SPDX-License-Identifier: Apache-2.0 */
/* What a frame costs without the layer, at level execution and at level content: each frame builds,
 * submits and waits. Prints medians in milliseconds. */
#include <stdio.h>
#include <string.h>

#include "command_line.h"
#include "frames.h"
#include "tests/null_driver/null_driver.h"
#include "tests/tools/fail.h"
#include "tests/tools/measure.h"

enum { WITHOUT, EXECUTION, CONTENT, SIDES, MOST_FRAMES = 1001 };

static const struct frame_kind kinds[] = {
    {"one small build", 1, 12, false, false},
    {"1,000 instances", 1, 1000, true, false},
    {"100,000 instances", 1, 100000, true, false},
    {"1,000,000 instances", 1, 1000000, true, false},
    {"1,000,000 triangles built", 1, 1000000, false, false},
    {"1,000,000 triangles updated", 1, 1000000, false, true},
    {"1,000 x 1,000 triangles", 1000, 1000, false, false},
};

struct options {
    const char *driver; /* NULL: the environment's */
    uint32_t frames;    /* 0: by the size of the scene */
    int only;           /* profile: one side alone; -1: all */
    const char *scene;  /* part of a scene's name; NULL: all scenes */
};

struct samples {
    double wall[MOST_FRAMES], cpu[MOST_FRAMES];
};

static uint32_t frames_of(const struct options *options, const struct frame_kind *kind)
{
    if (options->frames)
        return options->frames;
    const uint32_t primitives = kind->builds * kind->primitives;
    return primitives >= 1000000 ? 11 : primitives >= 100000 ? 31 : 201;
}

static void measure(const struct options *options, const struct frame_kind *kind,
                    struct side sides[SIDES])
{
    static struct samples samples[SIDES];
    const uint32_t count = frames_of(options, kind);
    struct frames *frames[SIDES] = {NULL};
    for (int s = 0; s < SIDES; s++) {
        if (options->only >= 0 && options->only != s)
            continue;
        frames[s] = frames_open(kind, &sides[s]);
        for (int i = 0; i < 3; i++) /* what is made once */
            frames_run(frames[s]);
    }
    for (uint32_t i = 0; i < count; i++) {
        for (uint32_t turn = 0; turn < SIDES; turn++) {
            const uint32_t s = (i + turn) % SIDES;
            if (!frames[s])
                continue;
            const struct frame_times times = frames_run(frames[s]);
            samples[s].wall[i] = times.wall / 1e6;
            samples[s].cpu[i] = times.cpu / 1e6;
        }
    }
    printf("%-28s", kind->name);
    for (int s = 0; s < SIDES; s++)
        printf(" %9.3f / %9.3f", frames[s] ? quantile(samples[s].wall, count, 0.5) : 0.0,
               frames[s] ? quantile(samples[s].cpu, count, 0.5) : 0.0);
    printf("\n");
    fflush(stdout);
    for (int s = 0; s < SIDES; s++)
        frames_close(frames[s]);
}

/* ---- the command line */

static const char usage[] =
    "usage: content [OPTION]...\n"
    "\n"
    "Measures frames that record one call of builds, submit it and wait: without the layer,\n"
    "at level execution and at level content, in turn. Prints medians in milliseconds: wall\n"
    "time / CPU time of all threads of the process, for each of the three.\n"
    "\n"
    "  --driver NAME    null or lavapipe (default: what the environment names)\n"
    "  --scene NAME     only scenes with this in their names\n"
    "  --frames N       of each scene (default: 11 to 201, by its size)\n"
    "  --only SIDE      for a profiler: none, execution or content alone\n"
    "  --help           this text\n";

static void read_side(const struct command_line *line, const char *value, void *member)
{
    static const char *const names[SIDES] = {"none", "execution", "content"};
    for (int s = 0; s < SIDES; s++) {
        if (strcmp(value, names[s]) == 0) {
            *(int *)member = s;
            return;
        }
    }
    command_line_wrong(line, "unknown side", value);
}

static const struct command_line_option option_table[] = {
    {"driver", command_line_text, offsetof(struct options, driver), true},
    {"scene", command_line_text, offsetof(struct options, scene), true},
    {"frames", command_line_count, offsetof(struct options, frames), true},
    {"only", read_side, offsetof(struct options, only), true},
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

int main(int argc, char **argv)
{
    static const char *const levels[SIDES] = {NULL, "execution", "content"};
    const struct command_line line = {"content", usage, option_table,
                                      sizeof(option_table) / sizeof(option_table[0])};
    struct options options = {.only = -1};
    struct side sides[SIDES];
    command_line_read(&line, &options, argc, argv);
    if (options.frames > MOST_FRAMES)
        tool_fail("--frames is at most %d", MOST_FRAMES);
    if (options.driver)
        driver_select(options.driver);
    if (options.driver && strcmp(options.driver, "null") == 0)
        raise_limits();
    for (int s = 0; s < SIDES; s++)
        side_open(&sides[s], levels[s] ? GPU_LAYER : NULL, levels[s]);
    printf("%s: wall / CPU, ms\n%-28s %21s %21s %21s\n", sides[0].gpu.properties.deviceName, "",
           "no layer", "execution", "content");
    for (size_t i = 0; i < sizeof(kinds) / sizeof(kinds[0]); i++)
        if (!options.scene || strstr(kinds[i].name, options.scene))
            measure(&options, &kinds[i], sides);
    for (int s = 0; s < SIDES; s++)
        side_close(&sides[s]);
    return 0;
}
