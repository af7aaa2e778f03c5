/* SPDX-License-Identifier: Apache-2.0 */
/* The acceleration structures of one device of backend cpu, by handle.
 *
 * A handle is the structure's device address: a number of at least 2^62, above all addresses of
 * drivers. Live structures of the process have different handles. So an instance names a BLAS by
 * the same number in host and in device builds, and a look-up detects an invalid number. Handles
 * are not reused, except those of structures of generic type: in one buffer their addresses differ
 * by their offsets (vkGetAccelerationStructureDeviceAddressKHR), unless two have the same offset.
 *
 * The table's lock guards the table and the tree of each structure. It is only held for look-ups,
 * and no other lock is taken while it is held. */
#ifndef ASSAY_CPU_STRUCTURES_H
#define ASSAY_CPU_STRUCTURES_H

#include <stdbool.h>
#include <stdint.h>
#include <vulkan/vulkan_core.h>

#include "src/cpu/trees/tree.h"

struct cpu_structures;

VkResult cpu_structures_create(struct cpu_structures **structures);
void cpu_structures_destroy(struct cpu_structures *structures); /* accepts NULL */

/* A callback that runs before a structure gets another tree or is destroyed. Only the lock of the
 * list of watchers is held during the callback. */
struct cpu_watcher {
    struct cpu_watcher *next, *previous; /* private to structures.c */
    void (*before_change)(struct cpu_watcher *watcher, uint64_t handle);
};
void cpu_structures_watch(struct cpu_structures *structures, struct cpu_watcher *watcher);
void cpu_structures_unwatch(struct cpu_structures *structures, struct cpu_watcher *watcher);

/* Returns a new handle, unique in the process; also for objects of other types. */
uint64_t cpu_unique_handle(void);

struct cpu_structure_info {
    VkAccelerationStructureTypeKHR type;
    uint64_t size;
    uint64_t buffer_id; /* never reused; 0: unknown */
    uint64_t buffer_size, offset;
    /* VK_NV_ray_tracing only: vkGetAccelerationStructureMemoryRequirementsNV returns them. */
    uint64_t build_scratch, update_scratch;
};
VkResult cpu_structures_add(struct cpu_structures *structures,
                            const struct cpu_structure_info *info, uint64_t *handle);
void cpu_structures_remove(struct cpu_structures *structures, uint64_t handle);

/* Returns false if the handle is unknown. */
bool cpu_structures_find(struct cpu_structures *structures, uint64_t handle,
                         struct cpu_structure_info *info);

/* Returns a new reference to the structure's tree; NULL if it is not built or the handle is
 * unknown. */
struct cpu_tree *cpu_structures_tree(struct cpu_structures *structures, uint64_t handle);

/* Sets the structure's tree (NULL: not built). Takes over the caller's reference in every case.
 * Returns false if the handle is unknown. */
bool cpu_structures_set_tree(struct cpu_structures *structures, uint64_t handle,
                             struct cpu_tree *tree);

#endif
