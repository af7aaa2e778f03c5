/* SPDX-License-Identifier: Apache-2.0 */
/* What the command line asks for. */
#ifndef BENCH_OPTIONS_H
#define BENCH_OPTIONS_H

#include <stdbool.h>
#include <stdint.h>

#include "scene.h"

enum { MOST_SIZES = 16 };

/* Builds a call, ascending. */
struct sizes {
    uint32_t builds[MOST_SIZES], count;
};

struct options {
    const char *drivers[2];
    uint32_t driver_count;
    struct sizes sizes;
    uint32_t alive;                      /* structures; a call's builds where those are more */
    bool with_buffers[2], with_order[2]; /* by enum buffers and enum order */
    bool conflicts;                      /* see scene_conflict */
    uint32_t samples;
    uint32_t builds_per_sample; /* at least; a call's builds where those are more */
    const char *level;          /* or NULL */
    const char *call_sites;     /* NULL: compare with no layer; else with the setting off */
    bool time_bars, memory_bars;

    /* For a profiler: record on one side alone, as often as asked for, and measure nothing. */
    bool profile, profile_with_layer;
    uint32_t profile_times;
};

/* Options of the comparison with the other layer. */
struct peer_options {
    const char *driver;
    const char *layers; /* a folder in which the other layer may be, or NULL */
    uint32_t most_builds;
    uint32_t samples;
    bool with_peer, bars;
    bool cold; /* a sample begins with what the one before left in the processor's caches */
};

/* Ends the process where the line is wrong, or asks for help. */
void options_read(struct options *options, int argc, char **argv);
void peer_options_read(struct peer_options *options, int argc, char **argv);

#endif
