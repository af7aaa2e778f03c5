/* SPDX-License-Identifier: Apache-2.0 */
/* The Vulkan commands that the demo uses, as lists: CALL(name without vk). */
#ifndef DEMO_CALLS_H
#define DEMO_CALLS_H

#include <vulkan/vulkan.h>

#define CALLS_OF_INSTANCE(CALL)                                                                    \
    CALL(CreateDebugUtilsMessengerEXT)                                                             \
    CALL(CreateDevice)                                                                             \
    CALL(DestroyDebugUtilsMessengerEXT)                                                            \
    CALL(DestroyInstance)                                                                          \
    CALL(EnumerateDeviceExtensionProperties)                                                       \
    CALL(EnumeratePhysicalDevices)                                                                 \
    CALL(GetDeviceProcAddr)                                                                        \
    CALL(GetPhysicalDeviceFeatures2)                                                               \
    CALL(GetPhysicalDeviceFormatProperties)                                                        \
    CALL(GetPhysicalDeviceMemoryProperties)                                                        \
    CALL(GetPhysicalDeviceProperties)                                                              \
    CALL(GetPhysicalDeviceProperties2)                                                             \
    CALL(GetPhysicalDeviceQueueFamilyProperties)

#define CALLS_OF_DEVICE(CALL)                                                                      \
    CALL(AllocateCommandBuffers)                                                                   \
    CALL(AllocateDescriptorSets)                                                                   \
    CALL(AllocateMemory)                                                                           \
    CALL(BeginCommandBuffer)                                                                       \
    CALL(BindBufferMemory)                                                                         \
    CALL(CmdBeginRenderPass)                                                                       \
    CALL(CmdBindDescriptorSets)                                                                    \
    CALL(CmdBindPipeline)                                                                          \
    CALL(CmdBuildAccelerationStructuresKHR)                                                        \
    CALL(CmdCopyAccelerationStructureKHR)                                                          \
    CALL(CmdDispatch)                                                                              \
    CALL(CmdEndRenderPass)                                                                         \
    CALL(CmdPipelineBarrier)                                                                       \
    CALL(CmdPushConstants)                                                                         \
    CALL(CmdResetQueryPool)                                                                        \
    CALL(CmdWriteAccelerationStructuresPropertiesKHR)                                              \
    CALL(CreateAccelerationStructureKHR)                                                           \
    CALL(CreateBuffer)                                                                             \
    CALL(CreateCommandPool)                                                                        \
    CALL(CreateComputePipelines)                                                                   \
    CALL(CreateDescriptorPool)                                                                     \
    CALL(CreateDescriptorSetLayout)                                                                \
    CALL(CreateFramebuffer)                                                                        \
    CALL(CreatePipelineLayout)                                                                     \
    CALL(CreateQueryPool)                                                                          \
    CALL(CreateRenderPass)                                                                         \
    CALL(CreateShaderModule)                                                                       \
    CALL(DestroyAccelerationStructureKHR)                                                          \
    CALL(DestroyBuffer)                                                                            \
    CALL(DestroyCommandPool)                                                                       \
    CALL(DestroyDescriptorPool)                                                                    \
    CALL(DestroyDescriptorSetLayout)                                                               \
    CALL(DestroyDevice)                                                                            \
    CALL(DestroyFramebuffer)                                                                       \
    CALL(DestroyPipeline)                                                                          \
    CALL(DestroyPipelineLayout)                                                                    \
    CALL(DestroyQueryPool)                                                                         \
    CALL(DestroyRenderPass)                                                                        \
    CALL(DestroyShaderModule)                                                                      \
    CALL(EndCommandBuffer)                                                                         \
    CALL(FreeCommandBuffers)                                                                       \
    CALL(FreeMemory)                                                                               \
    CALL(GetAccelerationStructureBuildSizesKHR)                                                    \
    CALL(GetAccelerationStructureDeviceAddressKHR)                                                 \
    CALL(GetBufferDeviceAddress)                                                                   \
    CALL(GetBufferMemoryRequirements)                                                              \
    CALL(GetDeviceQueue)                                                                           \
    CALL(GetQueryPoolResults)                                                                      \
    CALL(MapMemory)                                                                                \
    CALL(QueueSubmit)                                                                              \
    CALL(QueueWaitIdle)                                                                            \
    CALL(SetDebugUtilsObjectNameEXT)                                                               \
    CALL(UpdateDescriptorSets)

#define CALLS_MEMBER(name) PFN_vk##name name;

struct instance_calls {
    CALLS_OF_INSTANCE(CALLS_MEMBER)
};

struct device_calls {
    CALLS_OF_DEVICE(CALLS_MEMBER)
};

/* Load them all; the process ends with one line on stderr where one is missing. */
void calls_load_instance(struct instance_calls *calls, PFN_vkGetInstanceProcAddr get,
                         VkInstance instance);
void calls_load_device(struct device_calls *calls, PFN_vkGetDeviceProcAddr get, VkDevice device);

#endif
