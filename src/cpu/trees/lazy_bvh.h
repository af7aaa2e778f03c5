/* SPDX-License-Identifier: Apache-2.0 */
/* Trees that command buffers build, made when their bytes are first asked for: from snapshots that
 * an execution of the command buffer has copied. */
#ifndef ASSAY_CPU_TREES_LAZY_BVH_H
#define ASSAY_CPU_TREES_LAZY_BVH_H

#include "src/cpu/device.h"
#include "src/snapshots/recording.h"

/* All return one reference, or NULL without memory; `size_max` is the structure's size. */

/* `source`: of an update, whose reference is taken; or NULL. The structures that a TLAS refers to
 * are those of now. */
struct cpu_tree *cpu_lazy_build(struct cpu_device *device, struct execution *execution,
                                const struct recorded_build *build, struct cpu_tree *source,
                                uint64_t size_max);

/* Takes the source's reference. */
struct cpu_tree *cpu_lazy_compaction(struct cpu_device *device, struct cpu_tree *source,
                                     uint64_t size_max);

struct cpu_tree *cpu_lazy_deserialization(struct cpu_device *device, struct execution *execution,
                                          const struct snapshot *serialized, uint64_t size_max);

#endif
