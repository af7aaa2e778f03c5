/* SPDX-License-Identifier: Apache-2.0 */
/* Trees of device builds. They are made on first use, from the snapshots that an execution of the
 * command buffer has copied. */
#ifndef ASSAY_CPU_TREES_LAZY_BVH_H
#define ASSAY_CPU_TREES_LAZY_BVH_H

#include "src/cpu/device.h"
#include "src/snapshots/recording.h"

/* All return one reference, or NULL if memory runs out. `size_max` is the structure's size. All
 * take over the reference of `source`. */

/* `source`: of an update; otherwise NULL. A TLAS refers to the trees that structures have now. */
struct cpu_tree *cpu_lazy_build(struct cpu_device *device, struct execution *execution,
                                const struct recorded_build *build, struct cpu_tree *source,
                                uint64_t size_max);

struct cpu_tree *cpu_lazy_compaction(struct cpu_device *device, struct cpu_tree *source,
                                     uint64_t size_max);

struct cpu_tree *cpu_lazy_deserialization(struct cpu_device *device, struct execution *execution,
                                          const struct snapshot *serialized, uint64_t size_max);

#endif
