/* SPDX-License-Identifier: Apache-2.0 */
/* Intercepts that record accesses and barriers, for setting `hazards`. Each then calls the plain
 * intercept or, if there is none, the next layer. Without the setting the application's calls go to
 * the plain intercepts, so the recording costs nothing. */
#ifndef ASSAY_LAYER_HAZARDS_COMMANDS_H
#define ASSAY_LAYER_HAZARDS_COMMANDS_H

#include "layer/layer.h"

#define HAZARDS_COMMANDS(INTERCEPT)                                                                \
    INTERCEPT(CmdPipelineBarrier)                                                                  \
    INTERCEPT(CmdPipelineBarrier2)                                                                 \
    INTERCEPT(CmdPipelineBarrier2KHR)                                                              \
    INTERCEPT(CmdSetEvent)                                                                         \
    INTERCEPT(CmdSetEvent2)                                                                        \
    INTERCEPT(CmdSetEvent2KHR)                                                                     \
    INTERCEPT(CmdWaitEvents)                                                                       \
    INTERCEPT(CmdWaitEvents2)                                                                      \
    INTERCEPT(CmdWaitEvents2KHR)                                                                   \
    INTERCEPT(CmdCopyBuffer)                                                                       \
    INTERCEPT(CmdCopyBuffer2)                                                                      \
    INTERCEPT(CmdCopyBuffer2KHR)                                                                   \
    INTERCEPT(CmdCopyImageToBuffer)                                                                \
    INTERCEPT(CmdCopyImageToBuffer2)                                                               \
    INTERCEPT(CmdCopyImageToBuffer2KHR)                                                            \
    INTERCEPT(CmdCopyBufferToImage)                                                                \
    INTERCEPT(CmdCopyBufferToImage2)                                                               \
    INTERCEPT(CmdCopyBufferToImage2KHR)                                                            \
    INTERCEPT(CmdFillBuffer)                                                                       \
    INTERCEPT(CmdUpdateBuffer)                                                                     \
    INTERCEPT(CmdWriteBufferMarkerAMD)                                                             \
    INTERCEPT(CmdWriteBufferMarker2AMD)                                                            \
    INTERCEPT(CmdCopyMemoryKHR)                                                                    \
    INTERCEPT(CmdFillMemoryKHR)                                                                    \
    INTERCEPT(CmdUpdateMemoryKHR)                                                                  \
    INTERCEPT(CmdWriteMarkerToMemoryAMD)                                                           \
    INTERCEPT(CmdCopyQueryPoolResults)                                                             \
    INTERCEPT(CreateImage)                                                                         \
    INTERCEPT(DestroyImage)                                                                        \
    INTERCEPT(CreateRenderPass)                                                                    \
    INTERCEPT(CreateRenderPass2)                                                                   \
    INTERCEPT(CreateRenderPass2KHR)                                                                \
    INTERCEPT(DestroyRenderPass)                                                                   \
    INTERCEPT(CmdBeginRenderPass)                                                                  \
    INTERCEPT(CmdBeginRenderPass2)                                                                 \
    INTERCEPT(CmdBeginRenderPass2KHR)                                                              \
    INTERCEPT(CmdNextSubpass)                                                                      \
    INTERCEPT(CmdNextSubpass2)                                                                     \
    INTERCEPT(CmdNextSubpass2KHR)                                                                  \
    INTERCEPT(CmdEndRenderPass)                                                                    \
    INTERCEPT(CmdEndRenderPass2)                                                                   \
    INTERCEPT(CmdEndRenderPass2KHR)                                                                \
    INTERCEPT(CmdCopyAccelerationStructureKHR)                                                     \
    INTERCEPT(CmdCopyAccelerationStructureNV)                                                      \
    INTERCEPT(CmdCopyAccelerationStructureToMemoryKHR)                                             \
    INTERCEPT(CmdCopyMemoryToAccelerationStructureKHR)                                             \
    INTERCEPT(CmdWriteAccelerationStructuresPropertiesKHR)                                         \
    INTERCEPT(CmdWriteAccelerationStructuresPropertiesNV)                                          \
    INTERCEPT(CopyAccelerationStructureKHR)                                                        \
    INTERCEPT(CopyAccelerationStructureToMemoryKHR)                                                \
    INTERCEPT(CopyMemoryToAccelerationStructureKHR)                                                \
    INTERCEPT(WriteAccelerationStructuresPropertiesKHR)                                            \
    INTERCEPT(CmdBuildMicromapsEXT)                                                                \
    INTERCEPT(CmdCopyMicromapEXT)                                                                  \
    INTERCEPT(CmdCopyMemoryToMicromapEXT)                                                          \
    INTERCEPT(CmdCopyMicromapToMemoryEXT)                                                          \
    INTERCEPT(CmdWriteMicromapsPropertiesEXT)                                                      \
    INTERCEPT(BuildMicromapsEXT)                                                                   \
    INTERCEPT(CopyMicromapEXT)

/* typeof declares the prototypes, because a PFN type yields no parameter list. */
#define HAZARDS_DECLARE_COMMAND(name) extern __typeof__(*(PFN_vk##name)0) hazards_##name;
HAZARDS_COMMANDS(HAZARDS_DECLARE_COMMAND)
#undef HAZARDS_DECLARE_COMMAND

/* Returns the intercept that records the command, or `own` if the setting is off or the command is
 * not recorded. `own` may be NULL. */
PFN_vkVoidFunction hazards_command(const struct layer_instance *instance, const char *name,
                                   PFN_vkVoidFunction own);

#endif
