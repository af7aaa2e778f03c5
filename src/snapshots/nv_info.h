/* SPDX-License-Identifier: Apache-2.0 */
/* Parameters of VK_NV_ray_tracing, as those of VK_KHR_acceleration_structure that ask for the same.
 */
#ifndef ASSAY_SNAPSHOTS_NV_INFO_H
#define ASSAY_SNAPSHOTS_NV_INFO_H

#include "src/snapshots/build_parameters.h"

/* What the parameters read, which VK_NV_ray_tracing names by buffer and offset: `find` gives a
 * number that stands for that byte in the place of a device address; not 0, which stands for none.
 */
struct nv_data {
    uint64_t (*find)(void *context, VkBuffer buffer, VkDeviceSize offset);
    void *context;
    VkBuffer instances; /* of a top-level structure */
    VkDeviceSize instance_offset;
};

/* `data`: NULL where only sizes are asked for. Fails as build_parameters_copy() does. */
VkResult nv_info_copy(struct readable_cache *cache, const VkAccelerationStructureInfoNV *info,
                      const struct nv_data *data, struct build_parameters *copy);

#endif
