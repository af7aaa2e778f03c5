/* SPDX-License-Identifier: Apache-2.0 */
/* Records barriers and events. */
#include "layer/hazards/barriers.h"
#include "layer/hazards/commands.h"

#include "layer/intercepts/intercepts.h"

/* ---- barriers */

VKAPI_ATTR void VKAPI_CALL hazards_CmdPipelineBarrier(
    VkCommandBuffer commandBuffer, VkPipelineStageFlags srcStageMask,
    VkPipelineStageFlags dstStageMask, VkDependencyFlags dependencyFlags,
    uint32_t memoryBarrierCount, const VkMemoryBarrier *pMemoryBarriers,
    uint32_t bufferMemoryBarrierCount, const VkBufferMemoryBarrier *pBufferMemoryBarriers,
    uint32_t imageMemoryBarrierCount, const VkImageMemoryBarrier *pImageMemoryBarriers)
{
    struct layer_device *device = layer_find_recording_device(commandBuffer);
    struct hazard_recording recording;
    const struct barrier_parameters parameters = {srcStageMask,
                                                  dstStageMask,
                                                  memoryBarrierCount,
                                                  pMemoryBarriers,
                                                  bufferMemoryBarrierCount,
                                                  pBufferMemoryBarriers};
    if (!device)
        return;
    if (hazard_recording_start(&recording, commandBuffer))
        barriers_add(&recording, &parameters);
    device->vk.CmdPipelineBarrier(commandBuffer, srcStageMask, dstStageMask, dependencyFlags,
                                  memoryBarrierCount, pMemoryBarriers, bufferMemoryBarrierCount,
                                  pBufferMemoryBarriers, imageMemoryBarrierCount,
                                  pImageMemoryBarriers);
}

/* A command and its alias differ only in which command they call. */
#define DEFINE_PIPELINE_BARRIER_2(name)                                                            \
    VKAPI_ATTR void VKAPI_CALL hazards_##name(VkCommandBuffer commandBuffer,                       \
                                              const VkDependencyInfo *pDependencyInfo)             \
    {                                                                                              \
        struct layer_device *device = layer_find_recording_device(commandBuffer);                  \
        struct hazard_recording recording;                                                         \
        if (!device)                                                                               \
            return;                                                                                \
        if (hazard_recording_start(&recording, commandBuffer))                                     \
            barriers_add_2(&recording, pDependencyInfo);                                           \
        device->vk.name(commandBuffer, pDependencyInfo);                                           \
    }

DEFINE_PIPELINE_BARRIER_2(CmdPipelineBarrier2)
DEFINE_PIPELINE_BARRIER_2(CmdPipelineBarrier2KHR)

/* ---- events. The plain intercepts record that an event is reset. */

VKAPI_ATTR void VKAPI_CALL hazards_CmdSetEvent(VkCommandBuffer commandBuffer, VkEvent event,
                                               VkPipelineStageFlags stageMask)
{
    struct hazard_recording recording;
    if (hazard_recording_start(&recording, commandBuffer))
        barriers_add_set(&recording, event, stageMask);
    assay_CmdSetEvent(commandBuffer, event, stageMask);
}

VKAPI_ATTR void VKAPI_CALL hazards_CmdWaitEvents(
    VkCommandBuffer commandBuffer, uint32_t eventCount, const VkEvent *pEvents,
    VkPipelineStageFlags srcStageMask, VkPipelineStageFlags dstStageMask,
    uint32_t memoryBarrierCount, const VkMemoryBarrier *pMemoryBarriers,
    uint32_t bufferMemoryBarrierCount, const VkBufferMemoryBarrier *pBufferMemoryBarriers,
    uint32_t imageMemoryBarrierCount, const VkImageMemoryBarrier *pImageMemoryBarriers)
{
    struct hazard_recording recording;
    const struct barrier_parameters parameters = {srcStageMask,
                                                  dstStageMask,
                                                  memoryBarrierCount,
                                                  pMemoryBarriers,
                                                  bufferMemoryBarrierCount,
                                                  pBufferMemoryBarriers};
    if (hazard_recording_start(&recording, commandBuffer))
        for (uint32_t i = 0; i < eventCount; i++)
            barriers_add_wait(&recording, pEvents[i], &parameters);
    assay_CmdWaitEvents(commandBuffer, eventCount, pEvents, srcStageMask, dstStageMask,
                        memoryBarrierCount, pMemoryBarriers, bufferMemoryBarrierCount,
                        pBufferMemoryBarriers, imageMemoryBarrierCount, pImageMemoryBarriers);
}

#define DEFINE_SET_EVENT_2(name)                                                                   \
    VKAPI_ATTR void VKAPI_CALL hazards_##name(VkCommandBuffer commandBuffer, VkEvent event,        \
                                              const VkDependencyInfo *pDependencyInfo)             \
    {                                                                                              \
        struct hazard_recording recording;                                                         \
        if (hazard_recording_start(&recording, commandBuffer))                                     \
            barriers_add_set_2(&recording, event, pDependencyInfo);                                \
        assay_##name(commandBuffer, event, pDependencyInfo);                                       \
    }

#define DEFINE_WAIT_EVENTS_2(name)                                                                 \
    VKAPI_ATTR void VKAPI_CALL hazards_##name(VkCommandBuffer commandBuffer, uint32_t eventCount,  \
                                              const VkEvent *pEvents,                              \
                                              const VkDependencyInfo *pDependencyInfos)            \
    {                                                                                              \
        struct hazard_recording recording;                                                         \
        if (hazard_recording_start(&recording, commandBuffer))                                     \
            for (uint32_t i = 0; i < eventCount; i++)                                              \
                barriers_add_wait_2(&recording, pEvents[i], &pDependencyInfos[i]);                 \
        assay_##name(commandBuffer, eventCount, pEvents, pDependencyInfos);                        \
    }

DEFINE_SET_EVENT_2(CmdSetEvent2)
DEFINE_SET_EVENT_2(CmdSetEvent2KHR)
DEFINE_WAIT_EVENTS_2(CmdWaitEvents2)
DEFINE_WAIT_EVENTS_2(CmdWaitEvents2KHR)
