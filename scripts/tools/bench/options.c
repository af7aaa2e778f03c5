/* SPDX-License-Identifier: Apache-2.0 */
/* Reading the command line. */
#include "options.h"

#include <stdlib.h>
#include <string.h>

#include "command_line.h"

static const char usage[] =
    "usage: record [OPTION]...\n"
    "\n"
    "Measures what the layer adds to recording vkCmdBuildAccelerationStructuresKHR of\n"
    "one-geometry BLAS of 12 triangles: CPU time a build (begin, one call, end and reset\n"
    "of a command buffer, with and without the layer in turn) and memory a build. Exit\n"
    "status 0 only if all bars are met.\n"
    "\n"
    "  --driver NAME    null or lavapipe (default: both)\n"
    "  --sizes N,...    builds a call (default: 1,10,100,1000,10000)\n"
    "  --alive N        structures; calls of fewer builds go round them (default: as many\n"
    "                   as a call builds, over and over)\n"
    "  --buffers NAME   shared (large buffers, in which builds have ranges) or separate\n"
    "                   (four buffers a build; default: both)\n"
    "  --order NAME     created or shuffled: the order of builds in a call, by the creation\n"
    "                   of their structures and buffers (default: both)\n"
    "  --conflicts      all builds have the same dst and scratch\n"
    "  --samples N      a side (default: 31)\n"
    "  --quick          few short samples, and sizes up to 1000\n"
    "  --level LEVEL    the layer's setting (default: the layer's own)\n"
    "  --call-sites MODE\n"
    "                   frames or full: measures what that setting adds to the layer, when\n"
    "                   called from 16 functions deep, at the default level; no bars\n"
    "  --no-time-bars   asks of no time that it be short\n"
    "  --no-bars        only prints\n"
    "  --profile WITH   for a profiler: measures nothing, but records with the layer (on)\n"
    "                   or without it (off)\n"
    "  --times N        with --profile: how often (default: 10)\n"
    "  --help           this text\n"
    "\n"
    "VK_LAYER_PATH names the folder of the layer's manifest, if not this build tree's.\n";

static int compare(const void *a, const void *b)
{
    uint32_t x = *(const uint32_t *)a, y = *(const uint32_t *)b;
    return (x > y) - (x < y);
}

static void read_sizes(const struct command_line *line, const char *list, void *member)
{
    struct sizes *sizes = member;
    char *end;
    sizes->count = 0;
    for (const char *next = list;; next = end + 1) {
        if (sizes->count == MOST_SIZES)
            command_line_wrong(line, "too many sizes", list);
        sizes->builds[sizes->count++] = command_line_number(line, next, &end);
        if (!*end)
            break;
        if (*end != ',')
            command_line_wrong(line, "not a list of numbers", list);
    }
    qsort(sizes->builds, sizes->count, sizeof(sizes->builds[0]), compare);
}

static void read_driver(const struct command_line *line, const char *value, void *member)
{
    struct options *options = member;
    options->drivers[0] = value;
    options->driver_count = 1;
}

static void choose(bool chosen[2], int which)
{
    chosen[which] = true;
    chosen[!which] = false;
}

static void read_buffers(const struct command_line *line, const char *value, void *member)
{
    choose(member, strcmp(value, buffers_name(BUFFERS_SEPARATE)) == 0);
}

static void read_order(const struct command_line *line, const char *value, void *member)
{
    choose(member, strcmp(value, order_name(ORDER_SHUFFLED)) == 0);
}

static void be_quick(const struct command_line *line, const char *value, void *member)
{
    struct options *options = member;
    options->samples = 3;
    options->builds_per_sample = 200;
    read_sizes(line, "1,10,100,1000", &options->sizes);
}

static void drop_bars(const struct command_line *line, const char *value, void *member)
{
    struct options *options = member;
    options->memory_bars = false;
    options->time_bars = false;
}

static void read_call_sites(const struct command_line *line, const char *value, void *member)
{
    struct options *options = member;
    options->call_sites = value;
    drop_bars(line, value, member);
}

static void read_profile(const struct command_line *line, const char *value, void *member)
{
    struct options *options = member;
    options->profile = true;
    options->profile_with_layer = strcmp(value, "on") == 0;
}

void options_read(struct options *options, int argc, char **argv)
{
    static const struct command_line_option table[] = {
        {"driver", read_driver, 0, true, "null|lavapipe"},
        {"sizes", read_sizes, offsetof(struct options, sizes), true},
        {"alive", command_line_count, offsetof(struct options, alive), true},
        {"buffers", read_buffers, offsetof(struct options, with_buffers), true, "shared|separate"},
        {"order", read_order, offsetof(struct options, with_order), true, "created|shuffled"},
        {"conflicts", command_line_set, offsetof(struct options, conflicts), false},
        {"samples", command_line_count, offsetof(struct options, samples), true},
        {"quick", be_quick, 0, false},
        {"level", command_line_text, offsetof(struct options, level), true,
         "parameters|state|execution|content"},
        {"call-sites", read_call_sites, 0, true, "frames|full"},
        {"no-time-bars", command_line_clear, offsetof(struct options, time_bars), false},
        {"no-bars", drop_bars, 0, false},
        {"profile", read_profile, 0, true, "on|off"},
        {"times", command_line_count, offsetof(struct options, profile_times), true},
    };
    const struct command_line line = {"record", usage, table, sizeof(table) / sizeof(table[0])};
    *options = (struct options){.drivers = {"null", "lavapipe"},
                                .driver_count = 2,
                                .with_buffers = {true, true},
                                .with_order = {true, true},
                                .samples = 31,
                                .builds_per_sample = 2000,
                                .time_bars = true,
                                .memory_bars = true,
                                .profile_times = 10};
    read_sizes(&line, "1,10,100,1000,10000", &options->sizes);
    command_line_read(&line, options, argc, argv);
}

/* ---- the comparison with the other layer */

static const char peer_usage[] =
    "usage: peer [OPTION]...\n"
    "\n"
    "Measures what Assay, at each of its levels, and VK_LAYER_KHRONOS_validation, where the\n"
    "loader finds it, add to recording and submitting builds of one-geometry BLAS of 12\n"
    "triangles: all in one process, in turn with recording without a layer. The other layer\n"
    "has its default settings, which are core checks. Exit status 0 only if all bars are met\n"
    "that could be measured. Takes about eight minutes with the other layer, four without.\n"
    "\n"
    "  --driver NAME    lavapipe (default) or null\n"
    "  --layers FOLDER  where the other layer's manifest is, if the loader doesn't look there\n"
    "  --without-peer   measures Assay alone\n"
    "  --most N         builds a call at most (default: 100000)\n"
    "  --samples N      of each figure (default: 21)\n"
    "  --cold           times each right behind the one before, which has filled the\n"
    "                   processor's caches, instead of behind an unmeasured run of its own\n"
    "  --no-bars        only prints\n"
    "  --help           this text\n";

void peer_options_read(struct peer_options *options, int argc, char **argv)
{
    static const struct command_line_option table[] = {
        {"driver", command_line_text, offsetof(struct peer_options, driver), true, "lavapipe|null"},
        {"layers", command_line_text, offsetof(struct peer_options, layers), true},
        {"without-peer", command_line_clear, offsetof(struct peer_options, with_peer), false},
        {"most", command_line_count, offsetof(struct peer_options, most_builds), true},
        {"samples", command_line_count, offsetof(struct peer_options, samples), true},
        {"cold", command_line_set, offsetof(struct peer_options, cold), false},
        {"no-bars", command_line_clear, offsetof(struct peer_options, bars), false},
    };
    const struct command_line line = {"peer", peer_usage, table, sizeof(table) / sizeof(table[0])};
    *options = (struct peer_options){.driver = "lavapipe",
                                     .most_builds = 100000,
                                     .samples = 21,
                                     .with_peer = true,
                                     .bars = true};
    command_line_read(&line, options, argc, argv);
}
