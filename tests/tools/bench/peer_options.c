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

static void read_driver(const struct command_line *line, const char *value, void *member)
{
    if (strcmp(value, "lavapipe") != 0 && strcmp(value, "null") != 0)
        command_line_wrong(line, "unknown driver", value);
    *(const char **)member = value;
}

void peer_options_read(struct peer_options *options, int argc, char **argv)
{
    static const struct command_line_option table[] = {
        {"driver", read_driver, offsetof(struct peer_options, driver), true},
        {"layers", command_line_text, offsetof(struct peer_options, layers), true},
        {"without-peer", command_line_clear, offsetof(struct peer_options, with_peer), false},
        {"most", command_line_count, offsetof(struct peer_options, most_builds), true},
        {"samples", command_line_count, offsetof(struct peer_options, samples), true},
        {"cold", command_line_set, offsetof(struct peer_options, cold), false},
        {"csv", command_line_text, offsetof(struct peer_options, csv), true},
        {"no-bars", command_line_clear, offsetof(struct peer_options, bars), false},
    };
    const struct command_line line = {"peer", usage, table, sizeof(table) / sizeof(table[0])};
    *options = (struct peer_options){.driver = "lavapipe",
                                     .most_builds = 100000,
                                     .samples = 21,
                                     .with_peer = true,
                                     .bars = true};
    command_line_read(&line, options, argc, argv);
}
