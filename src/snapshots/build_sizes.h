/* SPDX-License-Identifier: Apache-2.0 */
/* The sizes of structures, micromaps and scratch, computed from the parameters of a build. */
#ifndef ASSAY_SNAPSHOTS_BUILD_SIZES_H
#define ASSAY_SNAPSHOTS_BUILD_SIZES_H

#include "src/snapshots/build_parameters.h"

/* `counts` may be NULL: the counts of the ranges are used. Writes zeros for geometries that the
 * builder does not support. */
VkResult build_parameters_sizes(const struct build_parameters *build, const uint32_t *counts,
                                struct builder_sizes *sizes);

/* Implements vkGetAccelerationStructureBuildSizesKHR. Also writes zeros if a parameter can't be
 * read, or without memory. */
void cpu_build_sizes(const VkAccelerationStructureBuildGeometryInfoKHR *info,
                     const uint32_t *counts, struct builder_sizes *sizes);

#endif
