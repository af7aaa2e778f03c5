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
    COMMAND(BuildAccelerationStructuresKHR)                                                        \
    COMMAND(CmdBeginDebugUtilsLabelEXT)                                                            \
    COMMAND(CmdBuildAccelerationStructureNV)                                                       \
    COMMAND(CmdBuildAccelerationStructuresKHR)                                                     \
    COMMAND(BuildMicromapsEXT)                                                                     \
    COMMAND(CmdBuildMicromapsEXT)                                                                  \
    COMMAND(CmdCopyAccelerationStructureKHR)                                                       \
    COMMAND(CmdCopyAccelerationStructureNV)                                                        \
    COMMAND(CmdCopyAccelerationStructureToMemoryKHR)                                               \
    COMMAND(CmdCopyMemoryToAccelerationStructureKHR)                                               \
    COMMAND(CmdCopyQueryPoolResults)                                                               \
    COMMAND(CmdEndDebugUtilsLabelEXT)                                                              \
    COMMAND(CmdExecuteCommands)                                                                    \
    COMMAND(CmdInsertDebugUtilsLabelEXT)                                                           \
    COMMAND(CmdResetQueryPool)                                                                     \
    COMMAND(CmdWriteAccelerationStructuresPropertiesKHR)                                           \
    COMMAND(CmdWriteAccelerationStructuresPropertiesNV)                                            \
    COMMAND(CopyAccelerationStructureKHR)                                                          \
    COMMAND(CopyAccelerationStructureToMemoryKHR)                                                  \
    COMMAND(CopyMemoryToAccelerationStructureKHR)                                                  \
    COMMAND(CreateAccelerationStructureKHR)                                                        \
    COMMAND(CreateAccelerationStructureNV)                                                         \
    COMMAND(CreateBuffer)                                                                          \
    COMMAND(CreateCommandPool)                                                                     \
    COMMAND(CreateDeferredOperationKHR)                                                            \
    COMMAND(CreateFence)                                                                           \
    COMMAND(CreateMicromapEXT)                                                                     \
    COMMAND(CreatePrivateDataSlot)                                                                 \
    COMMAND(CreateQueryPool)                                                                       \
    COMMAND(CreateSemaphore)                                                                       \
    COMMAND(DeferredOperationJoinKHR)                                                              \
    COMMAND(DestroyAccelerationStructureKHR)                                                       \
    COMMAND(DestroyAccelerationStructureNV)                                                        \
    COMMAND(DestroyBuffer)                                                                         \
    COMMAND(DestroyCommandPool)                                                                    \
    COMMAND(DestroyDeferredOperationKHR)                                                           \
    COMMAND(DestroyDevice)                                                                         \
    COMMAND(DestroyFence)                                                                          \
    COMMAND(DestroyMicromapEXT)                                                                    \
    COMMAND(DestroyPrivateDataSlot)                                                                \
    COMMAND(DestroyQueryPool)                                                                      \
    COMMAND(DestroySemaphore)                                                                      \
    COMMAND(DeviceWaitIdle)                                                                        \
    COMMAND(EndCommandBuffer)                                                                      \
    COMMAND(FreeCommandBuffers)                                                                    \
    COMMAND(FreeMemory)                                                                            \
    COMMAND(GetAccelerationStructureBuildSizesKHR)                                                 \
    COMMAND(GetBufferDeviceAddress)                                                                \
    COMMAND(GetDeferredOperationResultKHR)                                                         \
    COMMAND(GetDeviceQueue)                                                                        \
    COMMAND(GetPrivateData)                                                                        \
    COMMAND(GetQueryPoolResults)                                                                   \
    COMMAND(MapMemory)                                                                             \
    COMMAND(QueueBindSparse)                                                                       \
    COMMAND(QueueSubmit)                                                                           \
    COMMAND(QueueWaitIdle)                                                                         \
    COMMAND(ResetCommandPool)                                                                      \
    COMMAND(ResetFences)                                                                           \
    COMMAND(ResetQueryPool)                                                                        \
    COMMAND(SetDebugUtilsObjectNameEXT)                                                            \
    COMMAND(SetPrivateData)                                                                        \
    COMMAND(UnmapMemory)                                                                           \
    COMMAND(WaitForFences)                                                                         \
    COMMAND(WriteAccelerationStructuresPropertiesKHR)

struct commands {
#define MEMBER(name) PFN_vk##name name;
    INSTANCE_COMMANDS(MEMBER)
    DEVICE_COMMANDS(MEMBER)
#undef MEMBER
};

#endif
