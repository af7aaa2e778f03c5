/* SPDX-License-Identifier: Apache-2.0 */
/* The commands that the overlay of snapshots replaces, each by a function snapshots_NAME, which
 * calls the command below. */
#ifndef ASSAY_LAYER_SNAPSHOTS_COMMANDS_H
#define ASSAY_LAYER_SNAPSHOTS_COMMANDS_H

#include <vulkan/vulkan.h>

#define SNAPSHOTS_COMMANDS(COMMAND)                                                                \
    COMMAND(CmdBuildAccelerationStructuresKHR)                                                     \
    COMMAND(CmdBuildAccelerationStructuresIndirectKHR)                                             \
    COMMAND(CmdBuildAccelerationStructureNV)                                                       \
    COMMAND(CmdBindPipeline)                                                                       \
    COMMAND(CmdBindShadersEXT)                                                                     \
    COMMAND(CmdPushConstants)                                                                      \
    COMMAND(CmdPushConstants2)                                                                     \
    COMMAND(CmdPushConstants2KHR)                                                                  \
    COMMAND(CmdExecuteCommands)                                                                    \
    COMMAND(CmdPushDataEXT)                                                                        \
    COMMAND(CmdBindResourceHeapEXT)                                                                \
    COMMAND(CmdBindSamplerHeapEXT)                                                                 \
    COMMAND(CmdBeginQuery)                                                                         \
    COMMAND(CmdEndQuery)                                                                           \
    COMMAND(CmdBeginQueryIndexedEXT)                                                               \
    COMMAND(CmdEndQueryIndexedEXT)                                                                 \
    COMMAND(CmdBeginConditionalRenderingEXT)                                                       \
    COMMAND(CmdBeginConditionalRendering2EXT)                                                      \
    COMMAND(CmdEndConditionalRenderingEXT)                                                         \
    COMMAND(CreateQueryPool)                                                                       \
    COMMAND(DestroyQueryPool)                                                                      \
    COMMAND(CreateBuffer)                                                                          \
    COMMAND(DestroyBuffer)                                                                         \
    COMMAND(GetDeviceBufferMemoryRequirements)                                                     \
    COMMAND(GetDeviceBufferMemoryRequirementsKHR)                                                  \
    COMMAND(GetDeviceQueue)                                                                        \
    COMMAND(GetDeviceQueue2)                                                                       \
    COMMAND(QueueSubmit)                                                                           \
    COMMAND(QueueSubmit2)                                                                          \
    COMMAND(QueueSubmit2KHR)                                                                       \
    COMMAND(QueueBindSparse)                                                                       \
    COMMAND(QueuePresentKHR)

#define DECLARE_COMMAND(name) __typeof__(*(PFN_vk##name)0) snapshots_##name;
SNAPSHOTS_COMMANDS(DECLARE_COMMAND)
#undef DECLARE_COMMAND

#endif
