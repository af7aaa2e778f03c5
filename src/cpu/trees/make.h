/* SPDX-License-Identifier: Apache-2.0 */
/* Makes trees by builds, updates and copies, for host and device commands alike. */
#ifndef ASSAY_CPU_TREES_MAKE_H
#define ASSAY_CPU_TREES_MAKE_H

#include "src/bvh/bvh.h"
#include "src/cpu/trees/tree.h"
#include "src/snapshots/build_parameters.h"
#include "src/snapshots/memory.h"

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

#endif
