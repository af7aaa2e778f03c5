/* SPDX-License-Identifier: Apache-2.0 */
/* Commands of backend cpu: creation and destruction of acceleration structures, and their
 * addresses. */
#include "src/cpu/structures.h"
#include "observers.h"

#include "layer/cpu/overlay.h"

static VkResult create(VkDevice device, const struct cpu_structure_info *info,
                       VkAccelerationStructureKHR *structure)
{
    uint64_t handle;
    VkResult result = cpu_structures_add(cpu_overlay_of(device)->device->structures, info, &handle);
    *structure = result == VK_SUCCESS ? (VkAccelerationStructureKHR)handle : VK_NULL_HANDLE;
    return result;
}

static struct buffer_facts find_buffer(struct resources *resources, VkBuffer handle)
{
    struct buffer_facts facts;
    resources_ask_buffer(resources, handle, &facts);
    return facts;
}

VKAPI_ATTR VkResult VKAPI_CALL cpu_CreateAccelerationStructureKHR(
    VkDevice device, const VkAccelerationStructureCreateInfoKHR *pCreateInfo,
    const VkAllocationCallbacks *pAllocator, VkAccelerationStructureKHR *pAccelerationStructure)
{
    const struct buffer_facts buffer =
        find_buffer(layer_find_device(device)->resources, pCreateInfo->buffer);
    (void)pAllocator;
    const struct cpu_structure_info info = {
        .type = pCreateInfo->type,
        .size = pCreateInfo->size,
        .buffer_id = buffer.id,
        .buffer_size = buffer.size,
        .offset = pCreateInfo->offset,
    };
    return create(device, &info, pAccelerationStructure);
}

VKAPI_ATTR VkResult VKAPI_CALL cpu_CreateAccelerationStructure2KHR(
    VkDevice device, const VkAccelerationStructureCreateInfo2KHR *pCreateInfo,
    const VkAllocationCallbacks *pAllocator, VkAccelerationStructureKHR *pAccelerationStructure)
{
    (void)pAllocator;
    const struct cpu_structure_info info = {.type = pCreateInfo->type,
                                            .size = pCreateInfo->addressRange.size};
    return create(device, &info, pAccelerationStructure);
}

VKAPI_ATTR void VKAPI_CALL cpu_DestroyAccelerationStructureKHR(
    VkDevice device, VkAccelerationStructureKHR accelerationStructure,
    const VkAllocationCallbacks *pAllocator)
{
    struct cpu_device *backend = cpu_overlay_of(device)->device;
    (void)pAllocator;
    cpu_private_data_forget_object(&backend->private_data, (uint64_t)accelerationStructure);
    cpu_structures_remove(backend->structures, (uint64_t)accelerationStructure);
}

VKAPI_ATTR VkDeviceAddress VKAPI_CALL cpu_GetAccelerationStructureDeviceAddressKHR(
    VkDevice device, const VkAccelerationStructureDeviceAddressInfoKHR *pInfo)
{
    struct cpu_structure_info info;
    uint64_t handle = (uint64_t)pInfo->accelerationStructure;
    bool is_known = cpu_structures_find(cpu_overlay_of(device)->device->structures, handle, &info);
    return is_known ? handle : 0;
}
