/* SPDX-License-Identifier: Apache-2.0 */
/* Setting limits = harsh: commands in the dispatch tables of an instance and a device that give the
 * application, and the layer itself, the figures of src/state/builds/harsh.h. Without the setting
 * the tables hold what they would hold anyway. */
#ifndef ASSAY_LAYER_HARSH_H
#define ASSAY_LAYER_HARSH_H

#include "layer/layer.h"

/* Call after the table `vk` is filled in, and after backend cpu has replaced commands in it. */
void harsh_cover_instance(struct layer_instance *instance);
void harsh_cover_device(struct layer_device *device);

#endif
