/* SPDX-License-Identifier: Apache-2.0 */
/* Translates parameters of VK_EXT_opacity_micromap to the equivalent parameters of
 * VK_KHR_acceleration_structure: a micromap is a structure with a type of its own. */
#ifndef ASSAY_SNAPSHOTS_MICROMAP_INFO_H
#define ASSAY_SNAPSHOTS_MICROMAP_INFO_H

#include "src/snapshots/build_parameters.h"

/* Fails as build_parameters_copy() does. */
VkResult micromap_info_copy(struct readable_cache *cache, const VkMicromapBuildInfoEXT *info,
                            struct build_parameters *copy);

#endif
