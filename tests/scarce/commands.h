/* SPDX-License-Identifier: Apache-2.0 */
/* The Vulkan commands that the test calls, got from the loader as applications get them. */
#ifndef SCARCE_COMMANDS_H
#define SCARCE_COMMANDS_H

#include <vulkan/vulkan.h>

#define INSTANCE_COMMANDS(COMMAND)                                                                 \
    COMMAND(CreateDebugReportCallbackEXT)                                                          \
    COMMAND(CreateDebugUtilsMessengerEXT)                                                          \
    COMMAND(CreateDevice)                                                                          \
    COMMAND(DestroyDebugReportCallbackEXT)                                                         \
    COMMAND(DestroyDebugUtilsMessengerEXT)                                                         \
    COMMAND(DestroyInstance)                                                                       \
    COMMAND(EnumeratePhysicalDevices)                                                              \
    COMMAND(GetDeviceProcAddr)

#define DEVICE_COMMANDS(COMMAND)                                                                   \
    COMMAND(AllocateCommandBuffers)                                                                \
    COMMAND(AllocateMemory)                                                                        \
    COMMAND(BeginCommandBuffer)                                                                    \
    COMMAND(BindAccelerationStructureMemoryNV)                                                     \
    COMMAND(BindBufferMemory)                                                                      \
    COMMAND(BindBufferMemory2)                                                                     \
    COMMAND(CmdBeginDebugUtilsLabelEXT)                                                            \
    COMMAND(CmdBuildAccelerationStructureNV)                                                       \
    COMMAND(CmdBuildAccelerationStructuresKHR)                                                     \
    COMMAND(CmdCopyAccelerationStructureKHR)                                                       \
    COMMAND(CmdCopyAccelerationStructureNV)                                                        \
    COMMAND(CmdEndDebugUtilsLabelEXT)                                                              \
    COMMAND(CmdExecuteCommands)                                                                    \
    COMMAND(CmdInsertDebugUtilsLabelEXT)                                                           \
    COMMAND(CmdWriteAccelerationStructuresPropertiesKHR)                                           \
    COMMAND(CreateAccelerationStructureKHR)                                                        \
    COMMAND(CreateAccelerationStructureNV)                                                         \
    COMMAND(CreateBuffer)                                                                          \
    COMMAND(CreateCommandPool)                                                                     \
    COMMAND(CreateQueryPool)                                                                       \
    COMMAND(CreateSemaphore)                                                                       \
    COMMAND(DestroyAccelerationStructureKHR)                                                       \
    COMMAND(DestroyAccelerationStructureNV)                                                        \
    COMMAND(DestroyBuffer)                                                                         \
    COMMAND(DestroyCommandPool)                                                                    \
    COMMAND(DestroyDevice)                                                                         \
    COMMAND(DestroyQueryPool)                                                                      \
    COMMAND(DestroySemaphore)                                                                      \
    COMMAND(DeviceWaitIdle)                                                                        \
    COMMAND(EndCommandBuffer)                                                                      \
    COMMAND(FreeCommandBuffers)                                                                    \
    COMMAND(FreeMemory)                                                                            \
    COMMAND(GetAccelerationStructureBuildSizesKHR)                                                 \
    COMMAND(GetBufferDeviceAddress)                                                                \
    COMMAND(GetDeviceQueue)                                                                        \
    COMMAND(GetQueryPoolResults)                                                                   \
    COMMAND(QueueBindSparse)                                                                       \
    COMMAND(QueueSubmit)                                                                           \
    COMMAND(ResetCommandPool)                                                                      \
    COMMAND(ResetQueryPool)                                                                        \
    COMMAND(SetDebugUtilsObjectNameEXT)

struct commands {
#define MEMBER(name) PFN_vk##name name;
    INSTANCE_COMMANDS(MEMBER)
    DEVICE_COMMANDS(MEMBER)
#undef MEMBER
};

#endif
