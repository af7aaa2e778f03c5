/* SPDX-License-Identifier: Apache-2.0 */
/* Intercepts of commands that matter only because they can return VK_ERROR_DEVICE_LOST. */
#include "layer/intercepts/intercepts.h"
#include "layer/layer.h"
#include "layer/postmortem/loss.h"

/* A command whose first parameter is a VkDevice or VkQueue. */
#define DEFINE(name, dispatchable, parameters, arguments)                                          \
    VKAPI_ATTR VkResult VKAPI_CALL assay_##name parameters                                         \
    {                                                                                              \
        struct layer_device *state = layer_find_device(dispatchable);                              \
        return postmortem_see(state, state->vk.name arguments);                                    \
    }

DEFINE(CreateSwapchainKHR, device,
       (VkDevice device, const VkSwapchainCreateInfoKHR *pCreateInfo,
        const VkAllocationCallbacks *pAllocator, VkSwapchainKHR *pSwapchain),
       (device, pCreateInfo, pAllocator, pSwapchain))
DEFINE(CreateSharedSwapchainsKHR, device,
       (VkDevice device, uint32_t swapchainCount, const VkSwapchainCreateInfoKHR *pCreateInfos,
        const VkAllocationCallbacks *pAllocator, VkSwapchainKHR *pSwapchains),
       (device, swapchainCount, pCreateInfos, pAllocator, pSwapchains))
DEFINE(GetSwapchainStatusKHR, device, (VkDevice device, VkSwapchainKHR swapchain),
       (device, swapchain))
DEFINE(GetSwapchainCounterEXT, device,
       (VkDevice device, VkSwapchainKHR swapchain, VkSurfaceCounterFlagBitsEXT counter,
        uint64_t *pCounterValue),
       (device, swapchain, counter, pCounterValue))
DEFINE(GetPastPresentationTimingEXT, device,
       (VkDevice device, const VkPastPresentationTimingInfoEXT *pPastPresentationTimingInfo,
        VkPastPresentationTimingPropertiesEXT *pPastPresentationTimingProperties),
       (device, pPastPresentationTimingInfo, pPastPresentationTimingProperties))
DEFINE(GetRefreshCycleDurationGOOGLE, device,
       (VkDevice device, VkSwapchainKHR swapchain,
        VkRefreshCycleDurationGOOGLE *pDisplayTimingProperties),
       (device, swapchain, pDisplayTimingProperties))
DEFINE(GetPastPresentationTimingGOOGLE, device,
       (VkDevice device, VkSwapchainKHR swapchain, uint32_t *pPresentationTimingCount,
        VkPastPresentationTimingGOOGLE *pPresentationTimings),
       (device, swapchain, pPresentationTimingCount, pPresentationTimings))
DEFINE(QueueSetPerfHintQCOM, queue, (VkQueue queue, const VkPerfHintInfoQCOM *pPerfHintInfo),
       (queue, pPerfHintInfo))
