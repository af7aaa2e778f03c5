/* SPDX-License-Identifier: Apache-2.0 */
/* Translates parameters of VK_NV_ray_tracing to the equivalent parameters of
 * VK_KHR_acceleration_structure. */
#ifndef ASSAY_SNAPSHOTS_NV_INFO_H
#define ASSAY_SNAPSHOTS_NV_INFO_H

#include "src/snapshots/build_parameters.h"

/* The data that the parameters read. VK_NV_ray_tracing names it by buffer and offset: `find`
 * returns a number that stands for that byte, in place of a device address; it is not 0, because 0
 * stands for no address. */
struct nv_data {
    uint64_t (*find)(void *context, VkBuffer buffer, VkDeviceSize offset);
    void *context;
    VkBuffer instances; /* instance data of a top-level structure */
    VkDeviceSize instance_offset;
};

/* `data` may be NULL if only sizes are needed. Fails as build_parameters_copy() does. */
VkResult nv_info_copy(struct readable_cache *cache, const VkAccelerationStructureInfoNV *info,
                      const struct nv_data *data, struct build_parameters *copy);

#endif
