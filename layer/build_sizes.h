/* SPDX-License-Identifier: Apache-2.0 */
/* Sizes of builds, asked of the commands below the layer once for each shape of a build. */
#ifndef ASSAY_LAYER_BUILD_SIZES_H
#define ASSAY_LAYER_BUILD_SIZES_H

#include "layer/layer.h"

/* The answer of vkGetAccelerationStructureBuildSizesKHR; `counts` are the primitive counts. Leaves
 * `sizes` unchanged if there is no such command. */
void layer_find_build_sizes(struct layer_device *device,
                            const VkAccelerationStructureBuildGeometryInfoKHR *info,
                            const uint32_t *counts, VkAccelerationStructureBuildTypeKHR build_type,
                            struct size_facts *sizes);

#endif
