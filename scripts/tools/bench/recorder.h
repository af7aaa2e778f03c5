/* SPDX-License-Identifier: Apache-2.0 */
/* Recording a scene's builds, and what that costs in time and memory. */
#ifndef BENCH_RECORDER_H
#define BENCH_RECORDER_H

#include "scene.h"

struct recorder {
    const struct side *side;
    VkCommandPool pool;
    VkCommandBuffer commands;
    VkFence fence;
};

void recorder_open(struct recorder *recorder, const struct side *side);
void recorder_close(struct recorder *recorder);

/* The command buffer is begun, ended, submitted and waited for. */
void recorder_begin(const struct recorder *recorder, VkCommandBufferUsageFlags flags);
void recorder_end(const struct recorder *recorder);
void recorder_submit_and_wait(const struct recorder *recorder);

/* Records all builds of the scene, in calls of `builds_per_call`, each of which has the command
 * buffer for itself: it is begun before, and ended and reset behind it. `times` times. */
void recorder_run(const struct recorder *recorder, const struct scene *scene,
                  uint32_t builds_per_call, uint32_t times);

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

/* ---- threads that record side by side, each in a command pool of its own */

enum { MOST_THREADS = 4 };

/* Nanoseconds a build: over what the threads record together, the time that they take together by
 * the wall clock, which also tells of waits but needs a machine that is idle, and the sum of their
 * CPU times. */
struct thread_times {
    double wall, cpu;
};

/* Lets `count` threads record `times` calls of `builds` builds each. The scene has the builds of
 * all of them. */
struct thread_times threads_time(const struct side *side, const struct scene *scene, uint32_t count,
                                 uint32_t builds, uint32_t times);

#endif
