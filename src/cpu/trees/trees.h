/* SPDX-License-Identifier: Apache-2.0 */
/* How trees are made, for host and device commands alike, and how they are held while they are
 * read. */
#ifndef ASSAY_CPU_TREES_TREES_H
#define ASSAY_CPU_TREES_TREES_H

#include <stdbool.h>

#include "src/base/handle_table.h"
#include "src/bvh/bvh.h"
#include "src/bvh/trace.h"
#include "src/cpu/device.h"
#include "src/cpu/structures.h"
#include "src/cpu/trees/tree.h"
#include "src/model/build_parameters.h"
#include "src/platform/threads.h"
#include "src/snapshots/memory.h"
#include "src/snapshots/recording.h"

/* All functions return VK_SUCCESS, VK_ERROR_OUT_OF_HOST_MEMORY, or VK_ERROR_VALIDATION_FAILED if
 * the parameters or the data are invalid: unreadable data, an unknown format, an update whose shape
 * differs from its source, a structure that is too small. */
VkResult cpu_result(enum builder_result result);

struct cpu_device;

struct cpu_making {
    struct cpu_device *device; /* for its counters and scratch claims */
    const struct build_parameters *build;
    struct input_memory memory;
    struct builder_resolver resolver;
    struct builder_resolver micromaps; /* displacement micromaps */
    const void *source;                /* of an update, or NULL */
    uint64_t size_max;                 /* limit of the tree's size */
    void *scratch;                     /* the application's scratch of a host build, or NULL */
    struct builder_team *team;         /* threads that may help, or NULL */
};

/* All functions below allocate and write the bytes of `tree`. */
VkResult cpu_make_by_build(const struct cpu_making *making, struct cpu_tree *tree);

/* VkCopyAccelerationStructureModeKHR clone and compact. */
VkResult cpu_make_by_copy(struct cpu_device *device, VkCopyAccelerationStructureModeKHR mode,
                          const void *source, uint64_t size_max, struct cpu_tree *tree);
VkResult cpu_make_by_deserializing(struct cpu_device *device, const struct input_memory *memory,
                                   uint64_t address, uint64_t size_max, struct cpu_tree *tree);

/* ---- Trees of device builds. They are made on first use, from the snapshots that an execution of
 * the command buffer has copied. */

/* All return one reference, or NULL if memory runs out. `size_max` is the structure's size. All
 * take over the reference of `source`. */

/* `source`: of an update; otherwise NULL. A TLAS refers to the trees that structures have now. */
struct cpu_tree *cpu_lazy_build(struct cpu_device *device, struct execution *execution,
                                const struct recorded_build *build, struct cpu_tree *source,
                                uint64_t size_max);

struct cpu_tree *cpu_lazy_compaction(struct cpu_device *device, struct execution *execution,
                                     struct cpu_tree *source, uint64_t size_max);

struct cpu_tree *cpu_lazy_deserialization(struct cpu_device *device, struct execution *execution,
                                          const struct snapshot *serialized, uint64_t size_max);

/* ---- trees that a TLAS refers to, held while they are read */

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
