/* SPDX-License-Identifier: Apache-2.0 */
/* The acceleration structures of one device of backend cpu, by handle.
 *
 * A handle is the structure's device address: a number from 2^62 on, where no driver's addresses
 * are, and no two live structures of the process have the same. So an instance names a BLAS by the
 * same number in host and in device builds, and a stale or wild number is found out by look-up. It
 * is given out once, except for structures of generic type: those of one buffer have addresses as
 * far apart as their offsets (vkGetAccelerationStructureDeviceAddressKHR), as long as their places
 * differ.
 *
 * Its own lock guards the table and which tree each structure has; it is held for look-ups alone,
 * and no other lock is taken under it. */
#ifndef ASSAY_CPU_STRUCTURES_H
#define ASSAY_CPU_STRUCTURES_H

#include <stdbool.h>
#include <stdint.h>
#include <vulkan/vulkan_core.h>

#include "src/cpu/trees/tree.h"

struct cpu_structures;

VkResult cpu_structures_create(struct cpu_structures **structures);
void cpu_structures_destroy(struct cpu_structures *structures); /* NULL: nothing */

/* Who needs structures as they are now: told of each, before it gets another tree or is destroyed.
 * No lock of the structures is held meanwhile, but one that keeps watchers alive. */
struct cpu_watcher {
    struct cpu_watcher *next, *previous; /* of structures.c */
    void (*before_change)(struct cpu_watcher *watcher, uint64_t handle);
};
void cpu_structures_watch(struct cpu_structures *structures, struct cpu_watcher *watcher);
void cpu_structures_unwatch(struct cpu_structures *structures, struct cpu_watcher *watcher);

/* A number that no object of the process has; for handles of other kinds, too. */
uint64_t cpu_unique_handle(void);

struct cpu_structure_info {
    VkAccelerationStructureTypeKHR type;
    uint64_t size;
    uint64_t buffer_id; /* that no other buffer ever has; 0: not known */
    uint64_t buffer_size, offset;
    uint64_t build_scratch, update_scratch; /* of VK_NV_ray_tracing, which asks by structure */
};
VkResult cpu_structures_add(struct cpu_structures *structures,
                            const struct cpu_structure_info *info, uint64_t *handle);
void cpu_structures_remove(struct cpu_structures *structures, uint64_t handle);

/* False where there is none. */
bool cpu_structures_find(struct cpu_structures *structures, uint64_t handle,
                         struct cpu_structure_info *info);

/* A reference to the structure's tree; NULL where it has none, or is none. */
struct cpu_tree *cpu_structures_tree(struct cpu_structures *structures, uint64_t handle);

/* Makes the tree the structure's; takes the caller's reference in every case. NULL: none. False
 * where there is no such structure. */
bool cpu_structures_set_tree(struct cpu_structures *structures, uint64_t handle,
                             struct cpu_tree *tree);

#endif
