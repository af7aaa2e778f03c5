/* SPDX-License-Identifier: Apache-2.0 */
/* Trees that a TLAS refers to, held while they are read; and a structure opened for tracing. */
#ifndef ASSAY_CPU_TREES_SCENE_H
#define ASSAY_CPU_TREES_SCENE_H

#include <stdbool.h>

#include "src/base/handle_table.h"
#include "src/bvh/bvh.h"
#include "src/bvh/trace.h"
#include "src/cpu/device.h"
#include "src/cpu/structures.h"
#include "src/platform/threads.h"

struct blas_references {
    struct cpu_structures *structures;
    struct cpu_watcher watcher;
    bool is_watching;
    pthread_mutex_t lock; /* guards the members below; taken before the lock of structures */
    struct handle_table references;
    bool out_of_memory; /* memory ran out for a reference, so it was not found */
};

void blas_references_init(struct blas_references *references, struct cpu_structures *structures);
void blas_references_release(struct blas_references *references);

/* From now on each reference resolves to the tree that its structure has at the time of this call,
 * even if it is first resolved later. */
void blas_references_hold_all(struct blas_references *references);

/* The resolver finds built bottom-level structures on first use. */
struct builder_resolver blas_references_resolver(struct blas_references *references);

/* The resolver finds built micromaps on first use. */
struct builder_resolver blas_references_micromaps(struct blas_references *references);

/* ---- A structure opened for tracing. It holds the trees that the structure has when it is opened
 */

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
