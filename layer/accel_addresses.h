/* SPDX-License-Identifier: Apache-2.0 */
/* Device addresses of acceleration structures that the application did not query. */
#ifndef ASSAY_LAYER_ACCEL_ADDRESSES_H
#define ASSAY_LAYER_ACCEL_ADDRESSES_H

#include "layer/layer.h"

/* Queries the next layer for the address of a structure, or of all if `structure` is
 * VK_NULL_HANDLE, if it is unknown and the query is valid. A query may change what a layer below
 * reports, because the Khronos layer learns addresses from queries: call this only if an address is
 * needed. */
void layer_query_accel_address(struct layer_device *device, VkAccelerationStructureKHR structure);

#endif
