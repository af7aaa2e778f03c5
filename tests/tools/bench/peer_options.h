/* SPDX-License-Identifier: Apache-2.0 */
/* What the command line of the comparison asks for. */
#ifndef BENCH_PEER_OPTIONS_H
#define BENCH_PEER_OPTIONS_H

#include <stdbool.h>
#include <stdint.h>

struct peer_options {
    const char *driver;
    const char *layers; /* a folder in which the other layer may be, or NULL */
    const char *csv;    /* or NULL */
    uint32_t most_builds;
    uint32_t samples;
    bool with_peer, bars;
    bool cold; /* a sample begins with what the one before left in the processor's caches */
};

/* Ends the process where the line is wrong, or asks for help. */
void peer_options_read(struct peer_options *options, int argc, char **argv);

#endif
