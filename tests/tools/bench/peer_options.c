/* SPDX-License-Identifier: Apache-2.0 */
/* Reading the command line of the comparison. */
#include "peer_options.h"

#include <string.h>

#include "command_line.h"

static const char usage[] =
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
    "  --csv FILE       writes the figures there, too\n"
    "  --no-bars        only prints\n"
    "  --help           this text\n";

static const struct command_line line;

static _Noreturn void wrong(const char *what, const char *value)
{
    command_line_wrong(&line, what, value);
}

static void read_option(void *read, int option)
{
    struct peer_options *options = read;
    switch (option) {
    case 'd':
        if (strcmp(optarg, "lavapipe") != 0 && strcmp(optarg, "null") != 0)
            wrong("unknown driver", optarg);
        options->driver = optarg;
        break;
    case 'l':
        options->layers = optarg;
        break;
    case 'w':
        options->with_peer = false;
        break;
    case 'm':
        options->most_builds = command_line_count(&line, optarg);
        break;
    case 'n':
        options->samples = command_line_count(&line, optarg);
        break;
    case 'C':
        options->cold = true;
        break;
    case 'c':
        options->csv = optarg;
        break;
    case 'B':
        options->bars = false;
        break;
    default:
        break;
    }
}

static const struct option names[] = {
    {"driver", required_argument, NULL, 'd'},  {"layers", required_argument, NULL, 'l'},
    {"without-peer", no_argument, NULL, 'w'},  {"most", required_argument, NULL, 'm'},
    {"samples", required_argument, NULL, 'n'}, {"cold", no_argument, NULL, 'C'},
    {"csv", required_argument, NULL, 'c'},     {"no-bars", no_argument, NULL, 'B'},
    {"help", no_argument, NULL, 'h'},          {NULL, 0, NULL, 0}};

static const struct command_line line = {
    .program = "peer", .usage = usage, .names = names, .read_option = read_option};

void peer_options_read(struct peer_options *options, int argc, char **argv)
{
    *options = (struct peer_options){.driver = "lavapipe",
                                     .most_builds = 100000,
                                     .samples = 21,
                                     .with_peer = true,
                                     .bars = true};
    command_line_read(&line, options, argc, argv);
}
