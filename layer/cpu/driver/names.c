/* SPDX-License-Identifier: Apache-2.0 */
/* Backend cpu: names, tags and private data of objects of any kind. Those of the backend's objects
 * are not passed to the next layer, which would take their handles for its own. Observers have
 * recorded names. */
#include "layer/cpu/overlay.h"
#include "observers.h"

/* Whether the backend has made the object. `type`: a VkObjectType. VkDebugReportObjectTypeEXT has
 * the same values. */
bool cpu_makes(struct cpu_overlay *overlay, uint32_t type, uint64_t handle)
{
    return (type == VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR && overlay->acceleration_structure) ||
           (type == VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_NV && overlay->ray_tracing_nv) ||
           (type == VK_OBJECT_TYPE_QUERY_POOL &&
            cpu_query_pools_has(overlay->device->query_pools, handle)) ||
           (type == VK_OBJECT_TYPE_MICROMAP_EXT && overlay->opacity_micromap_ext) ||
           (type == VK_OBJECT_TYPE_DEFERRED_OPERATION_KHR && overlay->deferred_host_operations);
}

void cpu_get_private_data(struct cpu_private_data *private_data, uint64_t object,
                          VkPrivateDataSlot slot, uint64_t *data)
{
    *data = cpu_private_data_get(private_data, object, (uint64_t)slot);
}
