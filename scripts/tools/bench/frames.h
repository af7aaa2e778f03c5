/* SPDX-License-Identifier: Apache-2.0 */
/* Frames of an application: each records the builds of a scene, submits them and waits. */
#ifndef BENCH_FRAMES_H
#define BENCH_FRAMES_H

#include "recorder.h"

/* What each frame builds. */
struct frame_kind {
    const char *name;
    uint32_t builds;     /* bottom-level structures, or 1 top-level structure */
    uint32_t primitives; /* triangles, or instances, of each */
    bool is_top_level;
    bool updates;                             /* each frame updates what the first has built */
    uint32_t builds_a_call, builds_a_barrier; /* 0: one call, after one barrier */
    bool has_own_inputs;                      /* each build; otherwise all read the same */
    bool by_host;                             /* vkBuildAccelerationStructuresKHR */
    bool has_timestamps;                      /* around what the device builds */
};

struct frames;

/* Creates the structures and inputs of a scene. */
struct frames *frames_open(const struct frame_kind *kind, struct side *side);
void frames_close(struct frames *frames);

struct frame_times {
    double wall, cpu, thread; /* nanoseconds; CPU time of all threads of the process, and of this */
    double device;            /* between the timestamps, in nanoseconds; 0 without them */
};

struct frame_times frames_run(struct frames *frames);

#endif
