/* SPDX-License-Identifier: Apache-2.0 */
/* The tables of the comparison, and the bars that they are held to. */
#ifndef BENCH_PEER_REPORT_H
#define BENCH_PEER_REPORT_H

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

/* The contenders, which take turns. */
enum contender { NO_LAYER, PARAMETERS, STATE, EXECUTION, CONTENT, PEER, CONTENDERS };
const char *contender_name(enum contender contender);

/* Nanoseconds a build, of each; NAN where it wasn't measured. */
struct figures {
    double of[CONTENDERS];
};

struct peer_report {
    bool with_bars;
    uint32_t bars, missed, unmeasured;
    double
        at_reference; /* what the layer adds at the size that growth is measured against, or NAN */
};

void peer_report_open(struct peer_report *report);
/* Prints how many bars were met. Returns whether none was missed. */
bool peer_report_close(struct peer_report *report);

/* One table a scene, smallest sizes first. */
void peer_report_scene(struct peer_report *report, const char *scene);
void peer_report_recording(struct peer_report *report, const char *scene, uint32_t builds,
                           const struct figures *figures);

void peer_report_submissions(void);
void peer_report_submission(struct peer_report *report, uint32_t builds,
                            const struct figures *first, const struct figures *again);

/* [i]: of 1 << i threads, each of which records `builds` a call; see struct thread_times. */
enum { THREAD_COUNTS = 3 };
void peer_report_threads(struct peer_report *report, uint32_t builds,
                         const struct figures wall[THREAD_COUNTS],
                         const struct figures cpu[THREAD_COUNTS]);

#endif
