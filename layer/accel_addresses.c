/* SPDX-License-Identifier: Apache-2.0 */
/* Device addresses of acceleration structures that the application did not query. */
#include "layer/accel_addresses.h"

static VkDeviceAddress query(void *user, VkAccelerationStructureKHR structure)
{
    const struct layer_device *device = user;
    const VkAccelerationStructureDeviceAddressInfoKHR info = {
        .sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_DEVICE_ADDRESS_INFO_KHR,
        .accelerationStructure = structure,
    };
    return device->vk.GetAccelerationStructureDeviceAddressKHR(device->handle, &info);
}

void layer_query_accel_address(struct layer_device *device, VkAccelerationStructureKHR structure)
{
    if (device->may_query_structures && device->vk.GetAccelerationStructureDeviceAddressKHR)
        resources_query_addresses(device->resources, structure, query, device);
}
