/* SPDX-License-Identifier: Apache-2.0 */
/* Which formats the physical device supports as inputs of builds. Both functions return UNKNOWN if
 * the value is no format. */
#ifndef ASSAY_LAYER_FORMATS_H
#define ASSAY_LAYER_FORMATS_H

#include "layer/layer.h"

enum tristate layer_vertex_format_supported(struct layer_device *device, VkFormat format);
enum tristate layer_radius_format_supported(struct layer_device *device, VkFormat format);

#endif
