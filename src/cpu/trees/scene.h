/* SPDX-License-Identifier: Apache-2.0 */
/* A structure opened for tracing. It holds the trees that the structure has when it is opened. */
#ifndef ASSAY_CPU_TREES_SCENE_H
#define ASSAY_CPU_TREES_SCENE_H

#include "src/bvh/trace.h"
#include "src/cpu/device.h"
#include "src/cpu/trees/blas_references.h"

struct cpu_scene {
    struct cpu_device *device;
    struct cpu_tree *tree;
    struct blas_references references;
    struct blas_references micromaps; /* if device->has_micromaps */
    struct trace_scene traced;        /* for trace_closest() and trace_candidates() */
    struct trace_counters counters;   /* cpu_scene_close adds them to the device's */
    uint64_t rays;                    /* counted by the caller */
};

/* Returns VK_ERROR_VALIDATION_FAILED if the handle is not a built structure. The scene must not
 * move. Only one thread may trace in it. */
VkResult cpu_scene_open(struct cpu_device *device, uint64_t handle, enum trace_accuracy accuracy,
                        struct cpu_scene *scene);
void cpu_scene_close(struct cpu_scene *scene);

#endif
