/* SPDX-License-Identifier: Apache-2.0 */
/* Creates and destroys backend cpu's part of a device. */
#include "src/cpu/device.h"

#include <stdlib.h>
#include <string.h>

/* Change this whenever the serialized format changes. */
static const uint8_t compatibility[VK_UUID_SIZE] = "Assay trees 1";

VkResult cpu_device_create(const uint8_t driver_uuid[VK_UUID_SIZE], struct cpu_device **device)
{
    struct cpu_device *state = calloc(1, sizeof(*state));
    *device = state;
    if (!state)
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    memcpy(state->uuids.driver, driver_uuid, VK_UUID_SIZE);
    memcpy(state->uuids.compatibility, compatibility, VK_UUID_SIZE);
    cpu_scratch_claims_init(&state->scratch_claims);
    cpu_private_data_init(&state->private_data);
    VkResult result = cpu_structures_create(&state->structures);
    if (result == VK_SUCCESS)
        result = cpu_deferred_operations_create(&state->deferred);
    if (result == VK_SUCCESS)
        result = cpu_query_pools_create(&state->query_pools);
    if (result == VK_SUCCESS)
        return VK_SUCCESS;
    cpu_device_destroy(state);
    *device = NULL;
    return result;
}

void cpu_device_destroy(struct cpu_device *device)
{
    if (!device)
        return;
    cpu_deferred_operations_destroy(device->deferred);
    cpu_query_pools_destroy(device->query_pools);
    cpu_structures_destroy(device->structures);
    cpu_private_data_release(&device->private_data);
    cpu_scratch_claims_release(&device->scratch_claims);
    free(device);
}
