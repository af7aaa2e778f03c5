/* SPDX-License-Identifier: Apache-2.0 */
/* Translates the parameters of a build into the builder's input. */
#ifndef ASSAY_SNAPSHOTS_BUILD_INPUT_H
#define ASSAY_SNAPSHOTS_BUILD_INPUT_H

#include "src/snapshots/input.h"

/* The kind of BVH that the flags request. VK_BUILD_ACCELERATION_STRUCTURE_LOW_MEMORY_BIT_KHR is
 * kept among the BVH's flags and changes nothing else, because BVHs have one form. */
enum builder_quality build_input_quality(VkBuildAccelerationStructureFlagsKHR flags);

/* Fills in type, flags, formats and strides, without data. `chained` may be NULL. */
void build_input_describe(const VkAccelerationStructureGeometryKHR *geometry,
                          const struct chained_input *chained, struct builder_geometry *described);

VkResult build_input_open(const struct build_parameters *build, const struct input_memory *memory,
                          struct build_input *input);
void build_input_close(struct build_input *input);

#endif
