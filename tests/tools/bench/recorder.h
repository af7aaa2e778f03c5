/* SPDX-License-Identifier: Apache-2.0 */
/* Recording a scene's builds, and what that costs in time and memory. */
#ifndef BENCH_RECORDER_H
#define BENCH_RECORDER_H

#include "scene.h"

struct recorder {
    const struct side *side;
    VkCommandPool pool;
    VkCommandBuffer commands;
};

void recorder_open(struct recorder *recorder, const struct side *side);
void recorder_close(struct recorder *recorder);

/* Records all builds of the scene, in calls of `builds_per_call`, each of which has the command
 * buffer for itself: it is begun before, and ended and reset behind it. `times` times. */
void recorder_run(const struct recorder *recorder, const struct scene *scene,
                  uint32_t builds_per_call, uint32_t times);

/* The same with one call of the `count` builds from `first` on. */
void recorder_run_some(const struct recorder *recorder, const struct scene *scene, uint32_t first,
                       uint32_t count, uint32_t times);

/* CPU time of this thread for recorder_run, nanoseconds. */
double recorder_time(const struct recorder *recorder, const struct scene *scene,
                     uint32_t builds_per_call, uint32_t times);

/* What a submission of the scene's builds takes, CPU time of this thread in nanoseconds, to the end
 * of the wait for it: the first time, and once more. They are recorded before. */
struct submit_times {
    double first, again;
};
struct submit_times recorder_submit(const struct recorder *recorder, const struct scene *scene);

/* Fills the inputs of a scene with zeros, so that its builds can be executed. */
void recorder_clear_inputs(const struct recorder *recorder, const struct scene *scene);

/* Bytes that stay allocated while all builds of the scene are recorded in one fresh command buffer,
 * in calls of builds_per_call. Negative where the C library doesn't tell. */
double recorder_memory(const struct scene *scene, uint32_t builds_per_call);

#endif
