/* SPDX-License-Identifier: Apache-2.0 */
/* Making trees: by builds, updates and copies. Nothing here knows which structure a tree is for, or
 * whether the host or a device asked. */
#ifndef ASSAY_CPU_TREES_MAKE_H
#define ASSAY_CPU_TREES_MAKE_H

#include "src/bvh/bvh.h"
#include "src/cpu/trees/tree.h"
#include "src/snapshots/build_parameters.h"
#include "src/snapshots/memory.h"

/* Results are VK_SUCCESS, VK_ERROR_OUT_OF_HOST_MEMORY, or VK_ERROR_VALIDATION_FAILED where the
 * parameters or the data allow no tree: data that can't be read, unknown formats, another shape
 * than the source of an update has, a structure too small. */
VkResult cpu_result(enum builder_result result);

struct cpu_device;

struct cpu_making {
    struct cpu_device *device; /* counts, and keeps the claims of scratch */
    const struct build_parameters *build;
    struct input_memory memory;
    struct builder_resolver resolver;
    struct builder_resolver micromaps; /* that displace triangles */
    const void *source;                /* of an update */
    uint64_t size_max;                 /* of the tree */
    void *scratch;                     /* the application's, on the host; or NULL */
    struct builder_team *team;         /* threads that may take part; or NULL */
};

/* Allocates and writes the bytes of `tree`. */
VkResult cpu_make_by_build(const struct cpu_making *making, struct cpu_tree *tree);

/* VkCopyAccelerationStructureModeKHR clone and compact. */
VkResult cpu_make_by_copy(struct cpu_device *device, VkCopyAccelerationStructureModeKHR mode,
                          const void *source, uint64_t size_max, struct cpu_tree *tree);
VkResult cpu_make_by_deserializing(struct cpu_device *device, const struct input_memory *memory,
                                   uint64_t address, uint64_t size_max, struct cpu_tree *tree);

#endif
