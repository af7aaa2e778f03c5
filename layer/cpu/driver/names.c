/* SPDX-License-Identifier: Apache-2.0 */
/* Commands that name objects of any kind. Names of the backend's objects are not passed to the next
 * layer, which would take their handles for its own. */
#include "layer/cpu/overlay.h"
#include "observers.h"

/* `type`: a VkObjectType. VkDebugReportObjectTypeEXT has the same values. */
static bool is_own(const struct cpu_overlay *overlay, uint32_t type)
{
    return (type == VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR && overlay->acceleration_structure) ||
           (type == VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_NV && overlay->ray_tracing_nv) ||
           (type == VK_OBJECT_TYPE_MICROMAP_EXT && overlay->opacity_micromap_ext) ||
           (type == VK_OBJECT_TYPE_DEFERRED_OPERATION_KHR && overlay->deferred_host_operations);
}

/* ---- names and tags: the intercepts have recorded names */

/* The next layer's commands for objects of a type; NULL if the backend makes those objects. */
static const VkuDeviceDispatchTable *next_for(VkDevice device, uint32_t type)
{
    const struct cpu_overlay *overlay = cpu_overlay_of(device);
    return is_own(overlay, type) ? NULL : &overlay->next;
}

VKAPI_ATTR VkResult VKAPI_CALL
cpu_SetDebugUtilsObjectNameEXT(VkDevice device, const VkDebugUtilsObjectNameInfoEXT *pNameInfo)
{
    const VkuDeviceDispatchTable *next = next_for(device, pNameInfo->objectType);
    return next ? next->SetDebugUtilsObjectNameEXT(device, pNameInfo) : VK_SUCCESS;
}

VKAPI_ATTR VkResult VKAPI_CALL
cpu_SetDebugUtilsObjectTagEXT(VkDevice device, const VkDebugUtilsObjectTagInfoEXT *pTagInfo)
{
    const VkuDeviceDispatchTable *next = next_for(device, pTagInfo->objectType);
    return next ? next->SetDebugUtilsObjectTagEXT(device, pTagInfo) : VK_SUCCESS;
}

VKAPI_ATTR VkResult VKAPI_CALL
cpu_DebugMarkerSetObjectNameEXT(VkDevice device, const VkDebugMarkerObjectNameInfoEXT *pNameInfo)
{
    const VkuDeviceDispatchTable *next = next_for(device, pNameInfo->objectType);
    return next ? next->DebugMarkerSetObjectNameEXT(device, pNameInfo) : VK_SUCCESS;
}

VKAPI_ATTR VkResult VKAPI_CALL
cpu_DebugMarkerSetObjectTagEXT(VkDevice device, const VkDebugMarkerObjectTagInfoEXT *pTagInfo)
{
    const VkuDeviceDispatchTable *next = next_for(device, pTagInfo->objectType);
    return next ? next->DebugMarkerSetObjectTagEXT(device, pTagInfo) : VK_SUCCESS;
}

/* ---- private data */

static VkResult set_data(VkDevice device, PFN_vkSetPrivateData next, VkObjectType type,
                         uint64_t object, VkPrivateDataSlot slot, uint64_t data)
{
    const struct cpu_overlay *overlay = cpu_overlay_of(device);
    return is_own(overlay, type)
               ? cpu_private_data_set(&overlay->device->private_data, object, (uint64_t)slot, data)
               : next(device, type, object, slot, data);
}

static void get_data(VkDevice device, PFN_vkGetPrivateData next, VkObjectType type, uint64_t object,
                     VkPrivateDataSlot slot, uint64_t *data)
{
    const struct cpu_overlay *overlay = cpu_overlay_of(device);
    if (is_own(overlay, type))
        *data = cpu_private_data_get(&overlay->device->private_data, object, (uint64_t)slot);
    else
        next(device, type, object, slot, data);
}

VKAPI_ATTR VkResult VKAPI_CALL cpu_SetPrivateData(VkDevice device, VkObjectType objectType,
                                                  uint64_t objectHandle,
                                                  VkPrivateDataSlot privateDataSlot, uint64_t data)
{
    return set_data(device, cpu_overlay_of(device)->next.SetPrivateData, objectType, objectHandle,
                    privateDataSlot, data);
}

VKAPI_ATTR VkResult VKAPI_CALL cpu_SetPrivateDataEXT(VkDevice device, VkObjectType objectType,
                                                     uint64_t objectHandle,
                                                     VkPrivateDataSlot privateDataSlot,
                                                     uint64_t data)
{
    return set_data(device, cpu_overlay_of(device)->next.SetPrivateDataEXT, objectType,
                    objectHandle, privateDataSlot, data);
}

VKAPI_ATTR void VKAPI_CALL cpu_GetPrivateData(VkDevice device, VkObjectType objectType,
                                              uint64_t objectHandle,
                                              VkPrivateDataSlot privateDataSlot, uint64_t *pData)
{
    get_data(device, cpu_overlay_of(device)->next.GetPrivateData, objectType, objectHandle,
             privateDataSlot, pData);
}

VKAPI_ATTR void VKAPI_CALL cpu_GetPrivateDataEXT(VkDevice device, VkObjectType objectType,
                                                 uint64_t objectHandle,
                                                 VkPrivateDataSlot privateDataSlot, uint64_t *pData)
{
    get_data(device, cpu_overlay_of(device)->next.GetPrivateDataEXT, objectType, objectHandle,
             privateDataSlot, pData);
}

static void destroy_slot(VkDevice device, PFN_vkDestroyPrivateDataSlot next, VkPrivateDataSlot slot,
                         const VkAllocationCallbacks *allocator)
{
    if (slot)
        cpu_private_data_forget_slot(&cpu_overlay_of(device)->device->private_data, (uint64_t)slot);
    next(device, slot, allocator);
}

VKAPI_ATTR void VKAPI_CALL cpu_DestroyPrivateDataSlot(VkDevice device,
                                                      VkPrivateDataSlot privateDataSlot,
                                                      const VkAllocationCallbacks *pAllocator)
{
    destroy_slot(device, cpu_overlay_of(device)->next.DestroyPrivateDataSlot, privateDataSlot,
                 pAllocator);
}

VKAPI_ATTR void VKAPI_CALL cpu_DestroyPrivateDataSlotEXT(VkDevice device,
                                                         VkPrivateDataSlot privateDataSlot,
                                                         const VkAllocationCallbacks *pAllocator)
{
    destroy_slot(device, cpu_overlay_of(device)->next.DestroyPrivateDataSlotEXT, privateDataSlot,
                 pAllocator);
}
