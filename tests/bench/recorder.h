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

/* Begins the command buffer, records one call of all builds of the scene, ends and resets it;
 * `times` times. */
void recorder_run(const struct recorder *recorder, const struct scene *scene, uint32_t times);

/* CPU time of this thread for recorder_run, nanoseconds. */
double recorder_time(const struct recorder *recorder, const struct scene *scene, uint32_t times);

/* Bytes that stay allocated while all builds of the scene are recorded in one fresh command buffer,
 * in calls of builds_per_call. Negative where the C library doesn't tell. */
double recorder_memory(const struct scene *scene, uint32_t builds_per_call);

#endif
