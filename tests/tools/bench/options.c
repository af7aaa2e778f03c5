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
    "  --csv FILE       writes the figures there, too\n"
    "  --no-time-bars   asks of no time that it be short\n"
    "  --no-bars        only prints\n"
    "  --profile WITH   for a profiler: measures nothing, but records with the layer (on)\n"
    "                   or without it (off)\n"
    "  --times N        with --profile: how often (default: 10)\n"
    "  --help           this text\n"
    "\n"
    "VK_LAYER_PATH names the folder of the layer's manifest, if not this build tree's.\n";

static const struct command_line line;

static _Noreturn void wrong(const char *what, const char *value)
{
    command_line_wrong(&line, what, value);
}

static int compare(const void *a, const void *b)
{
    uint32_t x = *(const uint32_t *)a, y = *(const uint32_t *)b;
    return (x > y) - (x < y);
}

static void read_sizes(struct options *options, const char *list)
{
    char *end;
    options->size_count = 0;
    for (const char *next = list;; next = end + 1) {
        if (options->size_count == MOST_SIZES)
            wrong("too many sizes", list);
        options->sizes[options->size_count++] = command_line_number(&line, next, &end);
        if (!*end)
            break;
        if (*end != ',')
            wrong("not a list of numbers", list);
    }
    qsort(options->sizes, options->size_count, sizeof(options->sizes[0]), compare);
}

/* Which of two names it is. */
static int read_name(const char *text, const char *first, const char *second)
{
    if (strcmp(text, first) != 0 && strcmp(text, second) != 0)
        wrong("unknown name", text);
    return strcmp(text, second) == 0;
}

static const char *read_level(const char *text)
{
    static const char *const levels[] = {"parameters", "state", "execution", "content"};
    for (size_t i = 0; i < sizeof(levels) / sizeof(levels[0]); i++) {
        if (strcmp(text, levels[i]) == 0)
            return text;
    }
    wrong("unknown level", text);
}

static void choose(bool chosen[2], int which)
{
    chosen[which] = true;
    chosen[!which] = false;
}

static void be_quick(struct options *options)
{
    options->samples = 3;
    options->builds_per_sample = 200;
    read_sizes(options, "1,10,100,1000");
}

static void read_option(void *read, int option)
{
    struct options *options = read;
    switch (option) {
    case 'd':
        options->drivers[0] = read_name(optarg, "null", "lavapipe") ? "lavapipe" : "null";
        options->driver_count = 1;
        break;
    case 's':
        read_sizes(options, optarg);
        break;
    case 'a':
        options->alive = command_line_count(&line, optarg);
        break;
    case 'b':
        choose(options->with_buffers,
               read_name(optarg, buffers_name(BUFFERS_SHARED), buffers_name(BUFFERS_SEPARATE)));
        break;
    case 'o':
        choose(options->with_order,
               read_name(optarg, order_name(ORDER_CREATED), order_name(ORDER_SHUFFLED)));
        break;
    case 'x':
        options->conflicts = true;
        break;
    case 'n':
        options->samples = command_line_count(&line, optarg);
        break;
    case 'q':
        be_quick(options);
        break;
    case 'l':
        options->level = read_level(optarg);
        break;
    case 'c':
        options->csv = optarg;
        break;
    case 'B':
        options->memory_bars = false;
        options->time_bars = false;
        break;
    case 'T':
        options->time_bars = false;
        break;
    case 'p':
        options->profile = true;
        options->profile_with_layer = read_name(optarg, "off", "on");
        break;
    case 't':
        options->profile_times = command_line_count(&line, optarg);
        break;
    default:
        break;
    }
}

static const struct option names[] = {
    {"alive", required_argument, NULL, 'a'},   {"driver", required_argument, NULL, 'd'},
    {"sizes", required_argument, NULL, 's'},   {"buffers", required_argument, NULL, 'b'},
    {"order", required_argument, NULL, 'o'},   {"conflicts", no_argument, NULL, 'x'},
    {"samples", required_argument, NULL, 'n'}, {"quick", no_argument, NULL, 'q'},
    {"level", required_argument, NULL, 'l'},   {"csv", required_argument, NULL, 'c'},
    {"no-bars", no_argument, NULL, 'B'},       {"no-time-bars", no_argument, NULL, 'T'},
    {"profile", required_argument, NULL, 'p'}, {"times", required_argument, NULL, 't'},
    {"help", no_argument, NULL, 'h'},          {NULL, 0, NULL, 0}};

static const struct command_line line = {
    .program = "record", .usage = usage, .names = names, .read_option = read_option};

void options_read(struct options *options, int argc, char **argv)
{
    *options = (struct options){.drivers = {"null", "lavapipe"},
                                .driver_count = 2,
                                .with_buffers = {true, true},
                                .with_order = {true, true},
                                .samples = 31,
                                .builds_per_sample = 2000,
                                .time_bars = true,
                                .memory_bars = true,
                                .profile_times = 10};
    read_sizes(options, "1,10,100,1000,10000");
    command_line_read(&line, options, argc, argv);
}
