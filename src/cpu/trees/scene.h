/* SPDX-License-Identifier: Apache-2.0 */
/* A structure opened for tracing: what it holds at that moment, held until it is closed. */
#ifndef ASSAY_CPU_TREES_SCENE_H
#define ASSAY_CPU_TREES_SCENE_H

#include "src/bvh/trace.h"
#include "src/cpu/device.h"
#include "src/cpu/trees/blas_references.h"

struct cpu_scene {
    struct cpu_device *device;
    struct cpu_tree *tree;
    struct blas_references references;
    struct blas_references micromaps; /* where the device has any */
    struct trace_scene traced;        /* for trace_closest() and trace_candidates() */
    struct trace_counters counters;   /* added to the device's when closed */
    uint64_t rays;                    /* the caller's to count */
};

/* VK_ERROR_VALIDATION_FAILED where the handle is no built structure. The scene must not move; one
 * thread traces in it. */
VkResult cpu_scene_open(struct cpu_device *device, uint64_t handle, enum trace_accuracy accuracy,
                        struct cpu_scene *scene);
void cpu_scene_close(struct cpu_scene *scene);

#endif
