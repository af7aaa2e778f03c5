/* SPDX-License-Identifier: Apache-2.0 */
/* Backend cpu: creation of acceleration structures and deferred operations, and addresses of
 * structures. */
#include "src/cpu/structures.h"

#include <string.h>

#include "layer/cpu/overlay.h"
#include "observers.h"

static struct buffer_facts find_buffer(struct resources *resources, VkBuffer handle)
{
    struct buffer_facts facts;
    resources_ask_buffer(resources, handle, &facts);
    return facts;
}

VkResult cpu_create_structure(struct layer_device *device,
                              const VkAccelerationStructureCreateInfoKHR *create_info,
                              VkAccelerationStructureKHR *structure)
{
    const struct buffer_facts buffer = find_buffer(device->resources, create_info->buffer);
    const struct cpu_structure_info info = {
        .type = create_info->type,
        .size = create_info->size,
        .buffer_id = buffer.id,
        .buffer_size = buffer.size,
        .offset = create_info->offset,
    };
    uint64_t handle;
    VkResult result = cpu_structures_add(device->cpu->device->structures, &info, &handle);
    *structure = result == VK_SUCCESS ? (VkAccelerationStructureKHR)handle : VK_NULL_HANDLE;
    return result;
}

/* A structure or micromap whose buffer the backend need not know. `structure`: receives its handle.
 */
VkResult cpu_create_structure_of_size(struct cpu_structures *structures,
                                      VkAccelerationStructureTypeKHR type, VkDeviceSize size,
                                      void *structure)
{
    const struct cpu_structure_info info = {.type = type, .size = size};
    uint64_t handle = 0;
    VkResult result = cpu_structures_add(structures, &info, &handle);
    handle = result == VK_SUCCESS ? handle : 0;
    memcpy(structure, &handle, sizeof(handle));
    return result;
}

VkDeviceAddress cpu_get_address(struct cpu_structures *structures, uint64_t handle)
{
    struct cpu_structure_info info;
    return cpu_structures_find(structures, handle, &info) ? handle : 0;
}

VkResult cpu_create_operation(struct cpu_deferred_operations *deferred,
                              VkDeferredOperationKHR *operation)
{
    uint64_t handle;
    VkResult result = cpu_deferred_add(deferred, &handle);
    *operation = result == VK_SUCCESS ? (VkDeferredOperationKHR)handle : VK_NULL_HANDLE;
    return result;
}
