/* SPDX-License-Identifier: Apache-2.0 */
/* From the parameters of a build to the builder's input. */
#ifndef ASSAY_CPU_INPUT_H
#define ASSAY_CPU_INPUT_H

#include "build/build.h"
#include "cpu/build_info.h"
#include "cpu/memory.h"

/* Which kind of tree the flags ask for. VK_BUILD_ACCELERATION_STRUCTURE_LOW_MEMORY_BIT_KHR is kept
 * among the tree's flags and changes nothing else: trees have one form. */
enum builder_quality cpu_quality(VkBuildAccelerationStructureFlagsKHR flags);

/* Type, flags, formats and strides; no data. */
void cpu_describe_geometry(const VkAccelerationStructureGeometryKHR *geometry,
                           struct builder_geometry *described);

/* The input with its data, as far as that can be read now; what can't be is left out of the sizes,
 * so that the builder finds it out of range. Resolver and threads are the caller's to fill in. */
struct cpu_input {
    struct builder_input input;
    struct builder_geometry *geometries; /* owned */
    struct cpu_memory memory;            /* of arrays of pointers */
};
VkResult cpu_input_open(const struct cpu_build_info *build, const struct cpu_memory *memory,
                        struct cpu_input *input);
void cpu_input_close(struct cpu_input *input);

#endif
