/* SPDX-License-Identifier: Apache-2.0 */
/* The commands that the layer intercepts, each by a function assay_NAME.
 *
 * An intercept validates builds, forwards the call to device->vk, and updates the state: after
 * success, or before a destruction. */
#ifndef ASSAY_LAYER_INTERCEPTS_INTERCEPTS_H
#define ASSAY_LAYER_INTERCEPTS_INTERCEPTS_H

#include <vulkan/vulkan.h>

/* vkGetInstanceProcAddr returns these without an instance. */
#define ASSAY_GLOBAL_INTERCEPTS(INTERCEPT)                                                         \
    INTERCEPT(CreateInstance)                                                                      \
    INTERCEPT(EnumerateInstanceLayerProperties)                                                    \
    INTERCEPT(EnumerateInstanceExtensionProperties)                                                \
    INTERCEPT(GetInstanceProcAddr)

#define ASSAY_INSTANCE_INTERCEPTS(INTERCEPT)                                                       \
    INTERCEPT(DestroyInstance)                                                                     \
    INTERCEPT(EnumerateDeviceLayerProperties)                                                      \
    INTERCEPT(EnumerateDeviceExtensionProperties)                                                  \
    INTERCEPT(GetPhysicalDeviceToolProperties)                                                     \
    INTERCEPT(GetPhysicalDeviceToolPropertiesEXT)                                                  \
    INTERCEPT(CreateDevice)                                                                        \
    INTERCEPT(CreateDebugUtilsMessengerEXT)                                                        \
    INTERCEPT(DestroyDebugUtilsMessengerEXT)                                                       \
    INTERCEPT(CreateDebugReportCallbackEXT)                                                        \
    INTERCEPT(DestroyDebugReportCallbackEXT)

#define ASSAY_DEVICE_INTERCEPTS(INTERCEPT)                                                         \
    INTERCEPT(GetDeviceProcAddr)                                                                   \
    INTERCEPT(DestroyDevice)                                                                       \
    INTERCEPT(AllocateMemory)                                                                      \
    INTERCEPT(FreeMemory)                                                                          \
    INTERCEPT(MapMemory)                                                                           \
    INTERCEPT(MapMemory2)                                                                          \
    INTERCEPT(MapMemory2KHR)                                                                       \
    INTERCEPT(UnmapMemory)                                                                         \
    INTERCEPT(UnmapMemory2)                                                                        \
    INTERCEPT(UnmapMemory2KHR)                                                                     \
    INTERCEPT(CreateBuffer)                                                                        \
    INTERCEPT(DestroyBuffer)                                                                       \
    INTERCEPT(BindBufferMemory)                                                                    \
    INTERCEPT(GetAccelerationStructureDeviceAddressKHR)                                            \
    INTERCEPT(BindBufferMemory2)                                                                   \
    INTERCEPT(BindBufferMemory2KHR)                                                                \
    INTERCEPT(QueueSubmit)                                                                         \
    INTERCEPT(QueueSubmit2)                                                                        \
    INTERCEPT(QueueSubmit2KHR)                                                                     \
    INTERCEPT(QueuePresentKHR)                                                                     \
    INTERCEPT(CreateSwapchainKHR)                                                                  \
    INTERCEPT(CreateSharedSwapchainsKHR)                                                           \
    INTERCEPT(GetSwapchainStatusKHR)                                                               \
    INTERCEPT(GetSwapchainCounterEXT)                                                              \
    INTERCEPT(WaitForPresentKHR)                                                                   \
    INTERCEPT(WaitForPresent2KHR)                                                                  \
    INTERCEPT(GetPastPresentationTimingEXT)                                                        \
    INTERCEPT(GetRefreshCycleDurationGOOGLE)                                                       \
    INTERCEPT(GetPastPresentationTimingGOOGLE)                                                     \
    INTERCEPT(QueueSetPerfHintQCOM)                                                                \
    INTERCEPT(AcquireNextImageKHR)                                                                 \
    INTERCEPT(AcquireNextImage2KHR)                                                                \
    INTERCEPT(CreateSemaphore)                                                                     \
    INTERCEPT(DestroySemaphore)                                                                    \
    INTERCEPT(ImportSemaphoreFdKHR)                                                                \
    INTERCEPT(SignalSemaphore)                                                                     \
    INTERCEPT(SignalSemaphoreKHR)                                                                  \
    INTERCEPT(WaitSemaphores)                                                                      \
    INTERCEPT(WaitSemaphoresKHR)                                                                   \
    INTERCEPT(GetSemaphoreCounterValue)                                                            \
    INTERCEPT(GetSemaphoreCounterValueKHR)                                                         \
    INTERCEPT(CreateFence)                                                                         \
    INTERCEPT(DestroyFence)                                                                        \
    INTERCEPT(ImportFenceFdKHR)                                                                    \
    INTERCEPT(ResetFences)                                                                         \
    INTERCEPT(GetFenceStatus)                                                                      \
    INTERCEPT(WaitForFences)                                                                       \
    INTERCEPT(QueueWaitIdle)                                                                       \
    INTERCEPT(DeviceWaitIdle)                                                                      \
    INTERCEPT(CreateEvent)                                                                         \
    INTERCEPT(DestroyEvent)                                                                        \
    INTERCEPT(GetEventStatus)                                                                      \
    INTERCEPT(SetEvent)                                                                            \
    INTERCEPT(ResetEvent)                                                                          \
    INTERCEPT(CmdSetEvent)                                                                         \
    INTERCEPT(CmdSetEvent2)                                                                        \
    INTERCEPT(CmdSetEvent2KHR)                                                                     \
    INTERCEPT(CmdResetEvent)                                                                       \
    INTERCEPT(CmdResetEvent2)                                                                      \
    INTERCEPT(CmdResetEvent2KHR)                                                                   \
    INTERCEPT(CmdWaitEvents)                                                                       \
    INTERCEPT(CmdWaitEvents2)                                                                      \
    INTERCEPT(CmdWaitEvents2KHR)                                                                   \
    INTERCEPT(CreateDeferredOperationKHR)                                                          \
    INTERCEPT(DestroyDeferredOperationKHR)                                                         \
    INTERCEPT(GetDeferredOperationResultKHR)                                                       \
    INTERCEPT(DeferredOperationJoinKHR)                                                            \
    INTERCEPT(CopyAccelerationStructureKHR)                                                        \
    INTERCEPT(CopyMemoryToAccelerationStructureKHR)                                                \
    INTERCEPT(QueueBindSparse)                                                                     \
    INTERCEPT(GetBufferDeviceAddress)                                                              \
    INTERCEPT(GetBufferDeviceAddressKHR)                                                           \
    INTERCEPT(GetBufferDeviceAddressEXT)                                                           \
    INTERCEPT(CreateAccelerationStructureKHR)                                                      \
    INTERCEPT(CreateAccelerationStructure2KHR)                                                     \
    INTERCEPT(DestroyAccelerationStructureKHR)                                                     \
    INTERCEPT(CreateMicromapEXT)                                                                   \
    INTERCEPT(DestroyMicromapEXT)                                                                  \
    INTERCEPT(CmdBuildMicromapsEXT)                                                                \
    INTERCEPT(CmdCopyMicromapEXT)                                                                  \
    INTERCEPT(CmdCopyMemoryToMicromapEXT)                                                          \
    INTERCEPT(BuildMicromapsEXT)                                                                   \
    INTERCEPT(CopyMicromapEXT)                                                                     \
    INTERCEPT(CopyMemoryToMicromapEXT)                                                             \
    INTERCEPT(CreateCommandPool)                                                                   \
    INTERCEPT(DestroyCommandPool)                                                                  \
    INTERCEPT(ResetCommandPool)                                                                    \
    INTERCEPT(AllocateCommandBuffers)                                                              \
    INTERCEPT(FreeCommandBuffers)                                                                  \
    INTERCEPT(BeginCommandBuffer)                                                                  \
    INTERCEPT(EndCommandBuffer)                                                                    \
    INTERCEPT(ResetCommandBuffer)                                                                  \
    INTERCEPT(CmdBeginRenderPass)                                                                  \
    INTERCEPT(CmdBeginRenderPass2)                                                                 \
    INTERCEPT(CmdBeginRenderPass2KHR)                                                              \
    INTERCEPT(CmdEndRenderPass)                                                                    \
    INTERCEPT(CmdEndRenderPass2)                                                                   \
    INTERCEPT(CmdEndRenderPass2KHR)                                                                \
    INTERCEPT(CmdBeginRendering)                                                                   \
    INTERCEPT(CmdBeginRenderingKHR)                                                                \
    INTERCEPT(CmdEndRendering)                                                                     \
    INTERCEPT(CmdEndRenderingKHR)                                                                  \
    INTERCEPT(CmdEndRendering2KHR)                                                                 \
    INTERCEPT(CmdEndRendering2EXT)                                                                 \
    INTERCEPT(CmdBeginVideoCodingKHR)                                                              \
    INTERCEPT(CmdEndVideoCodingKHR)                                                                \
    INTERCEPT(CmdExecuteCommands)                                                                  \
    INTERCEPT(CreateQueryPool)                                                                     \
    INTERCEPT(DestroyQueryPool)                                                                    \
    INTERCEPT(ResetQueryPool)                                                                      \
    INTERCEPT(ResetQueryPoolEXT)                                                                   \
    INTERCEPT(GetQueryPoolResults)                                                                 \
    INTERCEPT(CmdWriteAccelerationStructuresPropertiesKHR)                                         \
    INTERCEPT(WriteAccelerationStructuresPropertiesKHR)                                            \
    INTERCEPT(SetDebugUtilsObjectNameEXT)                                                          \
    INTERCEPT(DebugMarkerSetObjectNameEXT)                                                         \
    INTERCEPT(CmdBeginDebugUtilsLabelEXT)                                                          \
    INTERCEPT(CmdEndDebugUtilsLabelEXT)                                                            \
    INTERCEPT(CmdInsertDebugUtilsLabelEXT)                                                         \
    INTERCEPT(QueueBeginDebugUtilsLabelEXT)                                                        \
    INTERCEPT(QueueEndDebugUtilsLabelEXT)                                                          \
    INTERCEPT(QueueInsertDebugUtilsLabelEXT)                                                       \
    INTERCEPT(CmdDebugMarkerBeginEXT)                                                              \
    INTERCEPT(CmdDebugMarkerEndEXT)                                                                \
    INTERCEPT(CmdDebugMarkerInsertEXT)                                                             \
    INTERCEPT(CmdCopyAccelerationStructureKHR)                                                     \
    INTERCEPT(CmdCopyMemoryToAccelerationStructureKHR)                                             \
    INTERCEPT(CmdBuildAccelerationStructuresKHR)                                                   \
    INTERCEPT(CmdBuildAccelerationStructuresIndirectKHR)                                           \
    INTERCEPT(BuildAccelerationStructuresKHR)                                                      \
    INTERCEPT(CreateAccelerationStructureNV)                                                       \
    INTERCEPT(DestroyAccelerationStructureNV)                                                      \
    INTERCEPT(BindAccelerationStructureMemoryNV)                                                   \
    INTERCEPT(GetAccelerationStructureHandleNV)                                                    \
    INTERCEPT(CmdCopyAccelerationStructureNV)                                                      \
    INTERCEPT(CmdBuildAccelerationStructureNV)

/* typeof declares the prototypes, because a PFN type yields no parameter list. */
#define ASSAY_DECLARE_INTERCEPT(name) extern __typeof__(*(PFN_vk##name)0) assay_##name;
ASSAY_GLOBAL_INTERCEPTS(ASSAY_DECLARE_INTERCEPT)
ASSAY_INSTANCE_INTERCEPTS(ASSAY_DECLARE_INTERCEPT)
ASSAY_DEVICE_INTERCEPTS(ASSAY_DECLARE_INTERCEPT)
#undef ASSAY_DECLARE_INTERCEPT

/* The layer's vk_layerGetPhysicalDeviceProcAddr. */
PFN_vkVoidFunction VKAPI_CALL assay_GetPhysicalDeviceProcAddr(VkInstance instance,
                                                              const char *pName);

#endif
