/* SPDX-License-Identifier: Apache-2.0 */
/* The commands that backend cpu implements, each by a function cpu_NAME. */
#ifndef ASSAY_LAYER_CPU_COMMANDS_H
#define ASSAY_LAYER_CPU_COMMANDS_H

#include <vulkan/vulkan.h>

#include "layer/assay.h"

/* These replace the next layer's commands on all physical devices of the instance, and call them.
 */
#define CPU_INSTANCE_COMMANDS(COMMAND)                                                             \
    COMMAND(EnumerateDeviceExtensionProperties)                                                    \
    COMMAND(GetPhysicalDeviceFeatures2)                                                            \
    COMMAND(GetPhysicalDeviceFeatures2KHR)                                                         \
    COMMAND(GetPhysicalDeviceProperties2)                                                          \
    COMMAND(GetPhysicalDeviceProperties2KHR)                                                       \
    COMMAND(GetPhysicalDeviceFormatProperties)                                                     \
    COMMAND(GetPhysicalDeviceFormatProperties2)                                                    \
    COMMAND(GetPhysicalDeviceFormatProperties2KHR)                                                 \
    COMMAND(GetPhysicalDeviceExternalBufferProperties)                                             \
    COMMAND(GetPhysicalDeviceExternalBufferPropertiesKHR)

/* COMMAND(extension, name): the overlay has the command if the application has enabled the
 * extension (a member of struct cpu_overlay). */
#define CPU_COMMANDS(COMMAND)                                                                      \
    COMMAND(acceleration_structure, CreateAccelerationStructureKHR)                                \
    COMMAND(acceleration_structure, CreateAccelerationStructure2KHR)                               \
    COMMAND(acceleration_structure, DestroyAccelerationStructureKHR)                               \
    COMMAND(acceleration_structure, GetAccelerationStructureDeviceAddressKHR)                      \
    COMMAND(acceleration_structure, GetAccelerationStructureBuildSizesKHR)                         \
    COMMAND(acceleration_structure, BuildAccelerationStructuresKHR)                                \
    COMMAND(acceleration_structure, CopyAccelerationStructureKHR)                                  \
    COMMAND(acceleration_structure, CopyAccelerationStructureToMemoryKHR)                          \
    COMMAND(acceleration_structure, CopyMemoryToAccelerationStructureKHR)                          \
    COMMAND(acceleration_structure, WriteAccelerationStructuresPropertiesKHR)                      \
    COMMAND(acceleration_structure, GetDeviceAccelerationStructureCompatibilityKHR)                \
    COMMAND(acceleration_structure, CmdBuildAccelerationStructuresKHR)                             \
    COMMAND(acceleration_structure, CmdBuildAccelerationStructuresIndirectKHR)                     \
    COMMAND(acceleration_structure, CmdCopyAccelerationStructureKHR)                               \
    COMMAND(acceleration_structure, CmdCopyAccelerationStructureToMemoryKHR)                       \
    COMMAND(acceleration_structure, CmdCopyMemoryToAccelerationStructureKHR)                       \
    COMMAND(acceleration_structure, CmdWriteAccelerationStructuresPropertiesKHR)                   \
    COMMAND(ray_tracing_nv, CreateAccelerationStructureNV)                                         \
    COMMAND(ray_tracing_nv, DestroyAccelerationStructureNV)                                        \
    COMMAND(ray_tracing_nv, GetAccelerationStructureMemoryRequirementsNV)                          \
    COMMAND(ray_tracing_nv, BindAccelerationStructureMemoryNV)                                     \
    COMMAND(ray_tracing_nv, GetAccelerationStructureHandleNV)                                      \
    COMMAND(ray_tracing_nv, CmdBuildAccelerationStructureNV)                                       \
    COMMAND(ray_tracing_nv, CmdCopyAccelerationStructureNV)                                        \
    COMMAND(ray_tracing_nv, CmdWriteAccelerationStructuresPropertiesNV)                            \
    COMMAND(ray_tracing_nv, CreateRayTracingPipelinesNV)                                           \
    COMMAND(ray_tracing_nv, CompileDeferredNV)                                                     \
    COMMAND(ray_tracing_nv, GetRayTracingShaderGroupHandlesNV)                                     \
    COMMAND(ray_tracing_nv, CmdTraceRaysNV)                                                        \
    COMMAND(opacity_micromap_ext, CreateMicromapEXT)                                               \
    COMMAND(opacity_micromap_ext, DestroyMicromapEXT)                                              \
    COMMAND(opacity_micromap_ext, GetMicromapBuildSizesEXT)                                        \
    COMMAND(opacity_micromap_ext, BuildMicromapsEXT)                                               \
    COMMAND(opacity_micromap_ext, CopyMicromapEXT)                                                 \
    COMMAND(opacity_micromap_ext, CopyMicromapToMemoryEXT)                                         \
    COMMAND(opacity_micromap_ext, CopyMemoryToMicromapEXT)                                         \
    COMMAND(opacity_micromap_ext, WriteMicromapsPropertiesEXT)                                     \
    COMMAND(opacity_micromap_ext, GetDeviceMicromapCompatibilityEXT)                               \
    COMMAND(opacity_micromap_ext, CmdBuildMicromapsEXT)                                            \
    COMMAND(opacity_micromap_ext, CmdCopyMicromapEXT)                                              \
    COMMAND(opacity_micromap_ext, CmdCopyMicromapToMemoryEXT)                                      \
    COMMAND(opacity_micromap_ext, CmdCopyMemoryToMicromapEXT)                                      \
    COMMAND(opacity_micromap_ext, CmdWriteMicromapsPropertiesEXT)                                  \
    COMMAND(deferred_host_operations, CreateDeferredOperationKHR)                                  \
    COMMAND(deferred_host_operations, DestroyDeferredOperationKHR)                                 \
    COMMAND(deferred_host_operations, GetDeferredOperationMaxConcurrencyKHR)                       \
    COMMAND(deferred_host_operations, GetDeferredOperationResultKHR)                               \
    COMMAND(deferred_host_operations, DeferredOperationJoinKHR)

/* These replace the next layer's commands if the next layer has them, and call them. */
#define CPU_REPLACED_COMMANDS(COMMAND)                                                             \
    COMMAND(SetDebugUtilsObjectNameEXT)                                                            \
    COMMAND(SetDebugUtilsObjectTagEXT)                                                             \
    COMMAND(DebugMarkerSetObjectNameEXT)                                                           \
    COMMAND(DebugMarkerSetObjectTagEXT)                                                            \
    COMMAND(SetPrivateData)                                                                        \
    COMMAND(SetPrivateDataEXT)                                                                     \
    COMMAND(GetPrivateData)                                                                        \
    COMMAND(GetPrivateDataEXT)                                                                     \
    COMMAND(DestroyPrivateDataSlot)                                                                \
    COMMAND(DestroyPrivateDataSlotEXT)                                                             \
    COMMAND(CreateQueryPool)                                                                       \
    COMMAND(DestroyQueryPool)                                                                      \
    COMMAND(GetQueryPoolResults)                                                                   \
    COMMAND(ResetQueryPool)                                                                        \
    COMMAND(ResetQueryPoolEXT)                                                                     \
    COMMAND(CmdResetQueryPool)                                                                     \
    COMMAND(CmdCopyQueryPoolResults)                                                               \
    COMMAND(DestroyBuffer)                                                                         \
    COMMAND(EndCommandBuffer)                                                                      \
    COMMAND(QueueSubmit)                                                                           \
    COMMAND(QueueSubmit2)                                                                          \
    COMMAND(QueueSubmit2KHR)                                                                       \
    COMMAND(CreateBuffer)                                                                          \
    COMMAND(GetDeviceBufferMemoryRequirements)                                                     \
    COMMAND(GetDeviceBufferMemoryRequirementsKHR)                                                  \
    COMMAND(CmdBindDescriptorBuffersEXT)                                                           \
    COMMAND(CmdPipelineBarrier)                                                                    \
    COMMAND(CmdWaitEvents)                                                                         \
    COMMAND(CmdSetEvent)                                                                           \
    COMMAND(CmdResetEvent)                                                                         \
    COMMAND(CmdWriteTimestamp)                                                                     \
    COMMAND(CmdWriteBufferMarkerAMD)                                                               \
    COMMAND(CmdPipelineBarrier2)                                                                   \
    COMMAND(CmdPipelineBarrier2KHR)                                                                \
    COMMAND(CmdSetEvent2)                                                                          \
    COMMAND(CmdSetEvent2KHR)                                                                       \
    COMMAND(CmdWaitEvents2)                                                                        \
    COMMAND(CmdWaitEvents2KHR)                                                                     \
    COMMAND(CmdResetEvent2)                                                                        \
    COMMAND(CmdResetEvent2KHR)                                                                     \
    COMMAND(CmdWriteTimestamp2)                                                                    \
    COMMAND(CmdWriteTimestamp2KHR)                                                                 \
    COMMAND(CmdWriteBufferMarker2AMD)                                                              \
    COMMAND(CreateRenderPass)                                                                      \
    COMMAND(CreateRenderPass2)                                                                     \
    COMMAND(CreateRenderPass2KHR)                                                                  \
    COMMAND(CreateDescriptorSetLayout)                                                             \
    COMMAND(GetDescriptorSetLayoutSupport)                                                         \
    COMMAND(GetDescriptorSetLayoutSupportKHR)                                                      \
    COMMAND(CreateDescriptorPool)                                                                  \
    COMMAND(CreateDescriptorUpdateTemplate)                                                        \
    COMMAND(CreateDescriptorUpdateTemplateKHR)                                                     \
    COMMAND(UpdateDescriptorSets)                                                                  \
    COMMAND(CmdPushDescriptorSet)                                                                  \
    COMMAND(CmdPushDescriptorSetKHR)                                                               \
    COMMAND(CmdPushDescriptorSet2)                                                                 \
    COMMAND(CmdPushDescriptorSet2KHR)                                                              \
    COMMAND(GetDescriptorEXT)                                                                      \
    COMMAND(GetAccelerationStructureOpaqueCaptureDescriptorDataEXT)                                \
    COMMAND(WriteResourceDescriptorsEXT)                                                           \
    COMMAND(CreateShaderModule)                                                                    \
    COMMAND(CreateShadersEXT)                                                                      \
    COMMAND(CreateComputePipelines)                                                                \
    COMMAND(CreateGraphicsPipelines)

/* Commands of assay.h. No dispatch table has them; vkGetDeviceProcAddr finds them. */
#define CPU_OWN_COMMANDS(COMMAND)                                                                  \
    COMMAND(structures, TraceRaysASSAY)                                                            \
    COMMAND(structures, GetCountersASSAY)

#define DECLARE_COMMAND(name) __typeof__(*(PFN_vk##name)0) cpu_##name;
#define DECLARE_SUPPLIED(extension, name) DECLARE_COMMAND(name)
CPU_INSTANCE_COMMANDS(DECLARE_COMMAND)
CPU_COMMANDS(DECLARE_SUPPLIED)
CPU_REPLACED_COMMANDS(DECLARE_COMMAND)
CPU_OWN_COMMANDS(DECLARE_SUPPLIED)
#undef DECLARE_COMMAND
#undef DECLARE_SUPPLIED

#endif
