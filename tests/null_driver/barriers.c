/* SPDX-License-Identifier: Apache-2.0 */
/* The stages and accesses that commands named, for tests. */
#include "internal.h"

enum { BARRIERS_MAX = 256 };

static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER; /* guards the members below */
static struct null_driver_barrier barriers[BARRIERS_MAX];
static uint32_t barrier_count;

uint32_t null_driver_take_barriers(struct null_driver_barrier *taken, uint32_t capacity)
{
    pthread_mutex_lock(&lock);
    const uint32_t count = barrier_count < capacity ? barrier_count : capacity;
    if (count > 0)
        memcpy(taken, barriers, count * sizeof(*taken));
    barrier_count = 0;
    pthread_mutex_unlock(&lock);
    return count;
}

static void add(struct null_driver_barrier barrier)
{
    barrier.builds = null_driver_calls("vkCmdBuildAccelerationStructuresKHR") +
                     null_driver_calls("vkCmdBuildAccelerationStructureNV");
    pthread_mutex_lock(&lock);
    if (barrier_count < BARRIERS_MAX)
        barriers[barrier_count++] = barrier;
    pthread_mutex_unlock(&lock);
}

/* ---- Vulkan 1.0: one pair of stages for all barriers */

#define ADD_OLD(barrier, ...)                                                                      \
    add((struct null_driver_barrier){.src = srcStageMask,                                          \
                                     .dst = dstStageMask,                                          \
                                     .src_access = (barrier)->srcAccessMask,                       \
                                     .dst_access = (barrier)->dstAccessMask,                       \
                                     .masks = (barrier),                                           \
                                     __VA_ARGS__})
#define ADD_ALL_OLD()                                                                              \
    do {                                                                                           \
        if (memoryBarrierCount + bufferMemoryBarrierCount + imageMemoryBarrierCount == 0)          \
            add((struct null_driver_barrier){.src = srcStageMask, .dst = dstStageMask});           \
        for (uint32_t i = 0; i < memoryBarrierCount; i++)                                          \
            ADD_OLD(&pMemoryBarriers[i], .detail = 0);                                             \
        for (uint32_t i = 0; i < bufferMemoryBarrierCount; i++)                                    \
            ADD_OLD(&pBufferMemoryBarriers[i], .buffer = pBufferMemoryBarriers[i].buffer,          \
                    .detail = pBufferMemoryBarriers[i].size);                                      \
        for (uint32_t i = 0; i < imageMemoryBarrierCount; i++)                                     \
            ADD_OLD(&pImageMemoryBarriers[i], .detail = pImageMemoryBarriers[i].newLayout);        \
    } while (0)

COMMAND(CmdPipelineBarrier)
{
    ADD_ALL_OLD();
}

COMMAND(CmdWaitEvents)
{
    ADD_ALL_OLD();
}

/* ---- masks of one structure each */

#define ADD(barrier, ...)                                                                          \
    add((struct null_driver_barrier){.src = (barrier)->srcStageMask,                               \
                                     .dst = (barrier)->dstStageMask,                               \
                                     .src_access = (barrier)->srcAccessMask,                       \
                                     .dst_access = (barrier)->dstAccessMask,                       \
                                     .masks = (barrier),                                           \
                                     __VA_ARGS__})

static void add_info(const VkDependencyInfo *info)
{
    const VkMemoryRangeBarriersInfoKHR *ranges =
        chain_find(info->pNext, VK_STRUCTURE_TYPE_MEMORY_RANGE_BARRIERS_INFO_KHR);
    for (uint32_t i = 0; i < info->memoryBarrierCount; i++)
        ADD(&info->pMemoryBarriers[i], .detail = 0);
    for (uint32_t i = 0; i < info->bufferMemoryBarrierCount; i++)
        ADD(&info->pBufferMemoryBarriers[i], .buffer = info->pBufferMemoryBarriers[i].buffer,
            .detail = info->pBufferMemoryBarriers[i].size);
    for (uint32_t i = 0; i < info->imageMemoryBarrierCount; i++)
        ADD(&info->pImageMemoryBarriers[i], .detail = info->pImageMemoryBarriers[i].newLayout);
    for (uint32_t i = 0; ranges != NULL && i < ranges->memoryRangeBarrierCount; i++)
        ADD(&ranges->pMemoryRangeBarriers[i],
            .detail = ranges->pMemoryRangeBarriers[i].addressRange.size);
}

COMMAND(CmdPipelineBarrier2)
{
    add_info(pDependencyInfo);
}

COMMAND(CmdSetEvent2)
{
    add_info(pDependencyInfo);
}

COMMAND(CmdWaitEvents2)
{
    for (uint32_t i = 0; i < eventCount; i++)
        add_info(&pDependencyInfos[i]);
}

ON_CREATION(CreateRenderPass)
{
    for (uint32_t i = 0; i < pCreateInfo->dependencyCount; i++)
        ADD(&pCreateInfo->pDependencies[i], .detail = pCreateInfo->pDependencies[i].dstSubpass);
}

ON_CREATION(CreateRenderPass2)
{
    for (uint32_t i = 0; i < pCreateInfo->dependencyCount; i++) {
        const VkSubpassDependency2 *dependency = &pCreateInfo->pDependencies[i];
        const VkMemoryBarrier2 *barrier =
            chain_find(dependency->pNext, VK_STRUCTURE_TYPE_MEMORY_BARRIER_2);
        if (barrier != NULL)
            ADD(barrier, .detail = dependency->dstSubpass);
        else
            ADD(dependency, .detail = dependency->dstSubpass);
    }
}

/* ---- one mask of stages */

#define STAGE(name, mask)                                                                          \
    COMMAND(name)                                                                                  \
    {                                                                                              \
        add((struct null_driver_barrier){.src = (mask)});                                          \
    }
STAGE(CmdSetEvent, stageMask)
STAGE(CmdResetEvent, stageMask)
STAGE(CmdResetEvent2, stageMask)
STAGE(CmdWriteTimestamp, pipelineStage)
STAGE(CmdWriteTimestamp2, stage)

static void add_semaphores(uint32_t count, const VkSemaphoreSubmitInfo *semaphores, bool waits)
{
    for (uint32_t i = 0; i < count; i++) {
        const VkPipelineStageFlags2 stages = semaphores[i].stageMask;
        if (stages != 0)
            add((struct null_driver_barrier){
                .src = waits ? 0 : stages, .dst = waits ? stages : 0, .masks = &semaphores[i]});
    }
}

void barriers_note_submission(const VkSubmitInfo2 *info)
{
    add_semaphores(info->waitSemaphoreInfoCount, info->pWaitSemaphoreInfos, true);
    add_semaphores(info->signalSemaphoreInfoCount, info->pSignalSemaphoreInfos, false);
}

void barriers_note_old_submission(const VkSubmitInfo *info)
{
    for (uint32_t i = 0; i < info->waitSemaphoreCount; i++)
        add((struct null_driver_barrier){.dst = info->pWaitDstStageMask[i],
                                         .masks = &info->pWaitDstStageMask[i]});
}
