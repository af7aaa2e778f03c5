/* SPDX-License-Identifier: Apache-2.0 */
/* Commands of backend cpu: deferred operations. */
#include "src/cpu/deferred.h"
#include "observers.h"

#include "layer/cpu/overlay.h"

static struct cpu_deferred_operations *operations_of(VkDevice device)
{
    return cpu_overlay_of(device)->device->deferred;
}

VKAPI_ATTR VkResult VKAPI_CALL
cpu_CreateDeferredOperationKHR(VkDevice device, const VkAllocationCallbacks *pAllocator,
                               VkDeferredOperationKHR *pDeferredOperation)
{
    uint64_t handle;
    (void)pAllocator;
    VkResult result = cpu_deferred_add(operations_of(device), &handle);
    *pDeferredOperation = result == VK_SUCCESS ? (VkDeferredOperationKHR)handle : VK_NULL_HANDLE;
    return result;
}

VKAPI_ATTR void VKAPI_CALL cpu_DestroyDeferredOperationKHR(VkDevice device,
                                                           VkDeferredOperationKHR operation,
                                                           const VkAllocationCallbacks *pAllocator)
{
    struct cpu_device *backend = cpu_overlay_of(device)->device;
    (void)pAllocator;
    cpu_private_data_forget_object(&backend->private_data, (uint64_t)operation);
    cpu_deferred_remove(backend->deferred, (uint64_t)operation);
}

VKAPI_ATTR uint32_t VKAPI_CALL
cpu_GetDeferredOperationMaxConcurrencyKHR(VkDevice device, VkDeferredOperationKHR operation)
{
    return cpu_deferred_concurrency(operations_of(device), (uint64_t)operation);
}

VKAPI_ATTR VkResult VKAPI_CALL cpu_GetDeferredOperationResultKHR(VkDevice device,
                                                                 VkDeferredOperationKHR operation)
{
    return cpu_deferred_result(operations_of(device), (uint64_t)operation);
}

VKAPI_ATTR VkResult VKAPI_CALL cpu_DeferredOperationJoinKHR(VkDevice device,
                                                            VkDeferredOperationKHR operation)
{
    return cpu_deferred_join(operations_of(device), (uint64_t)operation);
}
