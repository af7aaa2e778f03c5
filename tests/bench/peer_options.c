/* SPDX-License-Identifier: Apache-2.0 */
/* Reading the command line of the comparison. */
#include "peer_options.h"

#include <getopt.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char usage[] =
    "usage: peer [OPTION]...\n"
    "\n"
    "Measures what Assay, at each of its levels, and VK_LAYER_KHRONOS_validation, where the\n"
    "loader finds it, add to recording and submitting builds of one-geometry BLAS of 12\n"
    "triangles: all in one process, in turn with recording without a layer. The other layer\n"
    "has its default settings, which are core checks. Exit status 0 only if all bars are met\n"
    "that could be measured. Takes about four minutes with the other layer, two without.\n"
    "\n"
    "  --driver NAME    lavapipe (default) or null\n"
    "  --layers FOLDER  where the other layer's manifest is, if the loader doesn't look there\n"
    "  --without-peer   measures Assay alone\n"
    "  --most N         builds a call at most (default: 100000)\n"
    "  --samples N      of each figure (default: 21)\n"
    "  --csv FILE       writes the figures there, too\n"
    "  --no-bars        only prints\n"
    "  --help           this text\n";

static _Noreturn void wrong(const char *what, const char *value)
{
    fprintf(stderr, "peer: %s: %s\n\n%s", what, value, usage);
    exit(2);
}

static uint32_t read_count(const char *text)
{
    char *end;
    unsigned long number = strtoul(text, &end, 10);
    if (end == text || *end || number == 0 || number > 10000000)
        wrong("not a number from 1 to 10000000", text);
    return (uint32_t)number;
}

static void read_option(struct peer_options *options, int option)
{
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
        options->most_builds = read_count(optarg);
        break;
    case 'n':
        options->samples = read_count(optarg);
        break;
    case 'c':
        options->csv = optarg;
        break;
    case 'B':
        options->bars = false;
        break;
    case 'h':
        fputs(usage, stdout);
        exit(0);
    default: /* getopt has said what is wrong */
        fprintf(stderr, "\n%s", usage);
        exit(2);
    }
}

void peer_options_read(struct peer_options *options, int argc, char **argv)
{
    static const struct option names[] = {{"driver", required_argument, NULL, 'd'},
                                          {"layers", required_argument, NULL, 'l'},
                                          {"without-peer", no_argument, NULL, 'w'},
                                          {"most", required_argument, NULL, 'm'},
                                          {"samples", required_argument, NULL, 'n'},
                                          {"csv", required_argument, NULL, 'c'},
                                          {"no-bars", no_argument, NULL, 'B'},
                                          {"help", no_argument, NULL, 'h'},
                                          {NULL, 0, NULL, 0}};
    *options = (struct peer_options){.driver = "lavapipe",
                                     .most_builds = 100000,
                                     .samples = 21,
                                     .with_peer = true,
                                     .bars = true};
    int option;
    while ((option = getopt_long(argc, argv, "", names, NULL)) != -1)
        read_option(options, option);
    if (optind < argc)
        wrong("unknown argument", argv[optind]);
}
