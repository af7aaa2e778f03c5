/* SPDX-License-Identifier: Apache-2.0 */
/* Intercepts of semaphores and fences: creation, signals by the host, and completions that the host
 * observes. */
#include "layer/intercepts/intercepts.h"
#include "layer/layer.h"
#include "layer/postmortem/hang.h"
#include "layer/postmortem/loss.h"
#include "layer/snapshots/snapshots.h"
#include "src/base/chain.h"

/* Called when the host may have observed a completion. */
static void end_observation(const struct layer_device *state)
{
    execution_order_deliver(state->order);
}

/* ---- semaphores */

VKAPI_ATTR VkResult VKAPI_CALL assay_CreateSemaphore(VkDevice device,
                                                     const VkSemaphoreCreateInfo *pCreateInfo,
                                                     const VkAllocationCallbacks *pAllocator,
                                                     VkSemaphore *pSemaphore)
{
    struct layer_device *state = layer_find_device(device);
    VkResult result = state->vk.CreateSemaphore(device, pCreateInfo, pAllocator, pSemaphore);
    if (result != VK_SUCCESS)
        return result;
    const VkSemaphoreTypeCreateInfo *type =
        chain_find(pCreateInfo->pNext, VK_STRUCTURE_TYPE_SEMAPHORE_TYPE_CREATE_INFO);
    const VkExportSemaphoreCreateInfo *export =
        chain_find(pCreateInfo->pNext, VK_STRUCTURE_TYPE_EXPORT_SEMAPHORE_CREATE_INFO);
    execution_order_add_semaphore(state->order, *pSemaphore,
                                  type ? type->semaphoreType : VK_SEMAPHORE_TYPE_BINARY,
                                  type ? type->initialValue : 0, export && export->handleTypes);
    return result;
}

VKAPI_ATTR void VKAPI_CALL assay_DestroySemaphore(VkDevice device, VkSemaphore semaphore,
                                                  const VkAllocationCallbacks *pAllocator)
{
    struct layer_device *state = layer_find_device(device);
    if (semaphore)
        execution_order_remove_semaphore(state->order, semaphore);
    state->vk.DestroySemaphore(device, semaphore, pAllocator);
}

VKAPI_ATTR VkResult VKAPI_CALL assay_ImportSemaphoreFdKHR(
    VkDevice device, const VkImportSemaphoreFdInfoKHR *pImportSemaphoreFdInfo)
{
    struct layer_device *state = layer_find_device(device);
    execution_order_set_semaphore_foreign(state->order, pImportSemaphoreFdInfo->semaphore);
    return state->vk.ImportSemaphoreFdKHR(device, pImportSemaphoreFdInfo);
}

static VkResult signal_semaphore(struct layer_device *state, PFN_vkSignalSemaphore signal,
                                 VkDevice device, const VkSemaphoreSignalInfo *info)
{
    struct submission *submission =
        submission_begin(state->order, SUBMIT_HOST_SIGNAL, VK_NULL_HANDLE);
    submission_add_batch(submission);
    submission_add_signal(submission, info->semaphore, info->value, SCOPE_ALL);
    submission_prepare(submission);
    VkResult result = signal(device, info);
    submission_finish(submission, result);
    return result;
}

VKAPI_ATTR VkResult VKAPI_CALL assay_SignalSemaphore(VkDevice device,
                                                     const VkSemaphoreSignalInfo *pSignalInfo)
{
    struct layer_device *state = layer_find_device(device);
    return signal_semaphore(state, state->vk.SignalSemaphore, device, pSignalInfo);
}

VKAPI_ATTR VkResult VKAPI_CALL assay_SignalSemaphoreKHR(VkDevice device,
                                                        const VkSemaphoreSignalInfo *pSignalInfo)
{
    struct layer_device *state = layer_find_device(device);
    return signal_semaphore(state, state->vk.SignalSemaphoreKHR, device, pSignalInfo);
}

/* A wait for any of several semaphores does not tell which one has reached its value. */
static VkResult observe_wait(struct layer_device *state, const VkSemaphoreWaitInfo *info,
                             VkResult result)
{
    bool any = (info->flags & VK_SEMAPHORE_WAIT_ANY_BIT) && info->semaphoreCount > 1;
    postmortem_see(state, result);
    for (uint32_t i = 0; result == VK_SUCCESS && !any && i < info->semaphoreCount; i++)
        execution_order_observe_semaphore(state->order, info->pSemaphores[i], info->pValues[i],
                                          false);
    if (result == VK_SUCCESS && any)
        execution_order_observe_unknown(state->order);
    end_observation(state);
    return result;
}

VKAPI_ATTR VkResult VKAPI_CALL assay_WaitSemaphores(VkDevice device,
                                                    const VkSemaphoreWaitInfo *pWaitInfo,
                                                    uint64_t timeout)
{
    struct layer_device *state = layer_find_device(device);
    return observe_wait(state, pWaitInfo,
                        hang_wait_semaphores(state, state->vk.WaitSemaphores, pWaitInfo, timeout));
}

VKAPI_ATTR VkResult VKAPI_CALL assay_WaitSemaphoresKHR(VkDevice device,
                                                       const VkSemaphoreWaitInfo *pWaitInfo,
                                                       uint64_t timeout)
{
    struct layer_device *state = layer_find_device(device);
    return observe_wait(
        state, pWaitInfo,
        hang_wait_semaphores(state, state->vk.WaitSemaphoresKHR, pWaitInfo, timeout));
}

static VkResult observe_value(struct layer_device *state, VkSemaphore semaphore,
                              const uint64_t *value, VkResult result)
{
    if (result == VK_SUCCESS)
        execution_order_observe_semaphore(state->order, semaphore, *value, true);
    postmortem_see(state, result);
    end_observation(state);
    return result;
}

VKAPI_ATTR VkResult VKAPI_CALL assay_GetSemaphoreCounterValue(VkDevice device,
                                                              VkSemaphore semaphore,
                                                              uint64_t *pValue)
{
    struct layer_device *state = layer_find_device(device);
    return observe_value(state, semaphore, pValue,
                         state->vk.GetSemaphoreCounterValue(device, semaphore, pValue));
}

VKAPI_ATTR VkResult VKAPI_CALL assay_GetSemaphoreCounterValueKHR(VkDevice device,
                                                                 VkSemaphore semaphore,
                                                                 uint64_t *pValue)
{
    struct layer_device *state = layer_find_device(device);
    return observe_value(state, semaphore, pValue,
                         state->vk.GetSemaphoreCounterValueKHR(device, semaphore, pValue));
}

/* ---- fences */

VKAPI_ATTR VkResult VKAPI_CALL assay_CreateFence(VkDevice device,
                                                 const VkFenceCreateInfo *pCreateInfo,
                                                 const VkAllocationCallbacks *pAllocator,
                                                 VkFence *pFence)
{
    struct layer_device *state = layer_find_device(device);
    VkResult result = state->vk.CreateFence(device, pCreateInfo, pAllocator, pFence);
    const VkExportFenceCreateInfo *export =
        chain_find(pCreateInfo->pNext, VK_STRUCTURE_TYPE_EXPORT_FENCE_CREATE_INFO);
    if (result == VK_SUCCESS)
        execution_order_add_fence(state->order, *pFence, export && export->handleTypes,
                                  pCreateInfo->flags & VK_FENCE_CREATE_SIGNALED_BIT);
    return result;
}

VKAPI_ATTR void VKAPI_CALL assay_DestroyFence(VkDevice device, VkFence fence,
                                              const VkAllocationCallbacks *pAllocator)
{
    struct layer_device *state = layer_find_device(device);
    if (fence)
        execution_order_remove_fence(state->order, fence);
    state->vk.DestroyFence(device, fence, pAllocator);
}

VKAPI_ATTR VkResult VKAPI_CALL
assay_ImportFenceFdKHR(VkDevice device, const VkImportFenceFdInfoKHR *pImportFenceFdInfo)
{
    struct layer_device *state = layer_find_device(device);
    execution_order_set_fence_foreign(state->order, pImportFenceFdInfo->fence);
    return state->vk.ImportFenceFdKHR(device, pImportFenceFdInfo);
}

VKAPI_ATTR VkResult VKAPI_CALL assay_ResetFences(VkDevice device, uint32_t fenceCount,
                                                 const VkFence *pFences)
{
    struct layer_device *state = layer_find_device(device);
    VkResult result = state->vk.ResetFences(device, fenceCount, pFences);
    for (uint32_t i = 0; result == VK_SUCCESS && i < fenceCount; i++)
        execution_order_reset_fence(state->order, pFences[i]);
    return result;
}

VKAPI_ATTR VkResult VKAPI_CALL assay_GetFenceStatus(VkDevice device, VkFence fence)
{
    struct layer_device *state = layer_find_device(device);
    VkResult result = state->vk.GetFenceStatus(device, fence);
    if (result == VK_SUCCESS)
        execution_order_observe_fence(state->order, fence);
    postmortem_see(state, result);
    end_observation(state);
    return result;
}

VKAPI_ATTR VkResult VKAPI_CALL assay_WaitForFences(VkDevice device, uint32_t fenceCount,
                                                   const VkFence *pFences, VkBool32 waitAll,
                                                   uint64_t timeout)
{
    struct layer_device *state = layer_find_device(device);
    VkResult result = hang_wait_for_fences(state, fenceCount, pFences, waitAll, timeout);
    bool knows_all = waitAll || fenceCount == 1;
    for (uint32_t i = 0; result == VK_SUCCESS && knows_all && i < fenceCount; i++)
        execution_order_observe_fence(state->order, pFences[i]);
    if (result == VK_SUCCESS && !knows_all)
        execution_order_observe_unknown(state->order);
    postmortem_see(state, result);
    end_observation(state);
    return result;
}

/* ---- waiting for idle */

static void observe_idle(struct layer_device *state, const struct idle_wait *wait, VkResult result)
{
    if (result == VK_SUCCESS)
        execution_order_observe_idle(state->order, wait);
    postmortem_see(state, result);
    end_observation(state);
}

VKAPI_ATTR VkResult VKAPI_CALL assay_QueueWaitIdle(VkQueue queue)
{
    struct layer_device *state = layer_find_device(queue);
    struct idle_wait wait;
    execution_order_start_idle(state->order, queue, &wait);
    hang_wait_before_idle(state, queue);
    VkResult result = state->vk.QueueWaitIdle(queue);
    observe_idle(state, &wait, result);
    return result;
}

VKAPI_ATTR VkResult VKAPI_CALL assay_DeviceWaitIdle(VkDevice device)
{
    struct layer_device *state = layer_find_device(device);
    struct idle_wait wait;
    execution_order_start_idle(state->order, VK_NULL_HANDLE, &wait);
    hang_wait_before_idle(state, VK_NULL_HANDLE);
    VkResult result = state->vk.DeviceWaitIdle(device);
    observe_idle(state, &wait, result);
    return result;
}
