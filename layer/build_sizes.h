/* SPDX-License-Identifier: Apache-2.0 */
/* Sizes of builds. The commands below the layer are called once for each shape of a build;
 * size_cache.h keeps the result. */
#ifndef ASSAY_LAYER_BUILD_SIZES_H
#define ASSAY_LAYER_BUILD_SIZES_H

#include "layer/layer.h"

/* Writes what vkGetAccelerationStructureBuildSizesKHR returns; `counts` are the primitive counts.
 * Leaves `sizes` unchanged if the device has no such command, or may not call it. */
void layer_find_build_sizes(struct layer_device *device,
                            const VkAccelerationStructureBuildGeometryInfoKHR *info,
                            const uint32_t *counts, VkAccelerationStructureBuildTypeKHR build_type,
                            struct size_facts *sizes);

#endif
