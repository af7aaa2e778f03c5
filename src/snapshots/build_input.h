/* SPDX-License-Identifier: Apache-2.0 */
/* From the parameters of a build to the builder's input. */
#ifndef ASSAY_SNAPSHOTS_BUILD_INPUT_H
#define ASSAY_SNAPSHOTS_BUILD_INPUT_H

#include "src/snapshots/input.h"

/* Which kind of tree the flags ask for. VK_BUILD_ACCELERATION_STRUCTURE_LOW_MEMORY_BIT_KHR is kept
 * among the tree's flags and changes nothing else: trees have one form. */
enum builder_quality build_input_quality(VkBuildAccelerationStructureFlagsKHR flags);

/* Type, flags, formats and strides; no data. `chained`: NULL: nothing. */
void build_input_describe(const VkAccelerationStructureGeometryKHR *geometry,
                          const struct chained_input *chained, struct builder_geometry *described);

VkResult build_input_open(const struct build_parameters *build, const struct input_memory *memory,
                          struct build_input *input);
void build_input_close(struct build_input *input);

#endif
