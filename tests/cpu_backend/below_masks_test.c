/* SPDX-License-Identifier: Apache-2.0 */
/* What the driver sees of stages and accesses: those of ray tracing are translated, also in arrays
 * and chains, and the application's structures stay as they are. */
#include <string.h>

#include "backend.h"
#include "below.h"
#include "tests/fixture/scarce_memory.h"
#include "tests/unit/unit_test.h"

enum {
    BUILD = VK_PIPELINE_STAGE_ACCELERATION_STRUCTURE_BUILD_BIT_KHR,
    TRACE = VK_PIPELINE_STAGE_RAY_TRACING_SHADER_BIT_KHR,
    COPY = VK_PIPELINE_STAGE_TRANSFER_BIT,
    ALL = VK_PIPELINE_STAGE_ALL_COMMANDS_BIT,
    READ_TREE = VK_ACCESS_ACCELERATION_STRUCTURE_READ_BIT_KHR,
    WRITE_TREE = VK_ACCESS_ACCELERATION_STRUCTURE_WRITE_BIT_KHR,
    READ = VK_ACCESS_MEMORY_READ_BIT,
    WRITE = VK_ACCESS_MEMORY_WRITE_BIT,
    COPY_WRITE = VK_ACCESS_TRANSFER_WRITE_BIT,
};

/* ---- the driver */

#define ASSERT_MASKS(masks, src_stages, src_accesses, dst_stages, dst_accesses)                    \
    do {                                                                                           \
        assert_int_equal((masks)->srcStageMask, src_stages);                                       \
        assert_int_equal((masks)->srcAccessMask, src_accesses);                                    \
        assert_int_equal((masks)->dstStageMask, dst_stages);                                       \
        assert_int_equal((masks)->dstAccessMask, dst_accesses);                                    \
    } while (0)

/* Copies of the first structures, which end with the call. */
static struct {
    const void *pointer; /* only to compare */
    VkPipelineStageFlags2 stages[2];
    VkAccessFlags2 accesses[3][2];
    VkMemoryBarrier2 memory, chained;
    VkBufferMemoryBarrier2 buffer;
    VkImageMemoryBarrier2 image;
    VkMemoryRangeBarrierKHR range;
    VkSubpassDependency2 dependency;
    VkSemaphoreSubmitInfo wait, signal;
} seen;

PLAYED(CmdPipelineBarrier)
{
    calls++;
    seen.pointer = pBufferMemoryBarriers;
    seen.stages[0] = srcStageMask;
    seen.stages[1] = dstStageMask;
    for (int i = 0; i < 2; i++) {
        seen.accesses[0][i] = i ? pMemoryBarriers->dstAccessMask : pMemoryBarriers->srcAccessMask;
        seen.accesses[1][i] =
            i ? pBufferMemoryBarriers->dstAccessMask : pBufferMemoryBarriers->srcAccessMask;
        seen.accesses[2][i] =
            i ? pImageMemoryBarriers->dstAccessMask : pImageMemoryBarriers->srcAccessMask;
    }
}

static void see_info(const VkDependencyInfo *info)
{
    calls++;
    seen.pointer = info;
    if (info->memoryBarrierCount)
        seen.memory = info->pMemoryBarriers[0];
    if (info->bufferMemoryBarrierCount)
        seen.buffer = info->pBufferMemoryBarriers[info->bufferMemoryBarrierCount - 1];
    if (info->imageMemoryBarrierCount)
        seen.image = info->pImageMemoryBarriers[0];
    const VkMemoryRangeBarriersInfoKHR *ranges =
        chain_find(info->pNext, VK_STRUCTURE_TYPE_MEMORY_RANGE_BARRIERS_INFO_KHR);
    if (ranges)
        seen.range = ranges->pMemoryRangeBarriers[0];
}

PLAYED(CmdPipelineBarrier2)
{
    see_info(pDependencyInfo);
}

PLAYED(CmdSetEvent)
{
    seen.stages[0] = stageMask;
}

PLAYED(CmdWaitEvents2)
{
    for (uint32_t i = 0; i < eventCount; i++)
        see_info(&pDependencyInfos[i]);
}

PLAYED(CreateRenderPass2)
{
    calls++;
    seen.dependency = pCreateInfo->pDependencies[0];
    seen.chained = *(const VkMemoryBarrier2 *)chain_find(seen.dependency.pNext,
                                                         VK_STRUCTURE_TYPE_MEMORY_BARRIER_2);
    return VK_SUCCESS;
}

PLAYED(QueueSubmit)
{
    calls++;
    seen.pointer = pSubmits;
    seen.stages[0] = pSubmits[submitCount - 1].pWaitDstStageMask[0];
    seen.stages[1] = pSubmits[submitCount - 1].pWaitDstStageMask[1];
    return VK_SUCCESS;
}

PLAYED(QueueSubmit2)
{
    calls++;
    seen.wait = pSubmits->pWaitSemaphoreInfos[0];
    seen.signal = pSubmits->pSignalSemaphoreInfos[0];
    return VK_SUCCESS;
}

static void clear(void)
{
    memset(&seen, 0, sizeof(seen));
    below_clear();
}

/* ---- barriers */

static void add_barriers(VkPipelineStageFlags src, const VkBufferMemoryBarrier *buffers,
                         uint32_t count)
{
    const STRUCT(VkMemoryBarrier, memory, .srcAccessMask = COPY_WRITE, .dstAccessMask = READ_TREE);
    const STRUCT(VkImageMemoryBarrier, image, .dstAccessMask = COPY_WRITE);
    cpu_CmdPipelineBarrier(COMMAND_BUFFER, src, TRACE, 0, 1, &memory, count, buffers, 1, &image);
    assert_int_equal(memory.dstAccessMask, READ_TREE);
}

/* The stages of a first version are those of all its accesses. */
TEST_OPENED(barriers_of_the_first_version, clear)
{
    static VkBufferMemoryBarrier buffers[MANY];
    buffers[0].srcAccessMask = WRITE_TREE;
    add_barriers(COPY | BUILD, buffers, 1);
    assert_int_equal(seen.stages[0], COPY | ALL);
    assert_int_equal(seen.stages[1], ALL);
    assert_int_equal(seen.accesses[0][0], COPY_WRITE | READ);
    assert_int_equal(seen.accesses[0][1], READ);
    assert_int_equal(seen.accesses[1][0], READ | WRITE);
    assert_int_equal(seen.accesses[2][1], COPY_WRITE | READ);
    assert_int_equal(buffers[0].srcAccessMask, WRITE_TREE);

    WITHOUT_MEMORY(add_barriers(COPY, buffers, MANY));
    assert_int_equal(seen.stages[1], TRACE);
    assert_ptr_equal(seen.pointer, buffers);
}

TEST_OPENED(barriers_of_the_second_version, clear)
{
    const STRUCT(VkMemoryBarrier2, memory, NULL, BUILD, WRITE_TREE, COPY, COPY_WRITE);
    const STRUCT(VkImageMemoryBarrier2, image, NULL, COPY, COPY_WRITE, TRACE, READ_TREE);
    static VkBufferMemoryBarrier2 buffers[MANY];
    const STRUCT(VkMemoryRangeBarrierKHR, range, NULL, COPY, COPY_WRITE, BUILD, READ_TREE);
    const STRUCT(VkMemoryRangeBarriersInfoKHR, ranges, .memoryRangeBarrierCount = 1,
                 .pMemoryRangeBarriers = &range);
    const STRUCT(VkMemoryBarrierAccessFlags3KHR, first, .pNext = &ranges);
    STRUCT(VkDependencyInfo, info, .pNext = &first, .memoryBarrierCount = 1,
           .pMemoryBarriers = &memory, .bufferMemoryBarrierCount = 1,
           .pBufferMemoryBarriers = buffers, .imageMemoryBarrierCount = 1,
           .pImageMemoryBarriers = &image);
    buffers[0] = MAKE(VkBufferMemoryBarrier2, NULL, TRACE, READ_TREE, COPY, 0, .size = 7);
    cpu_CmdPipelineBarrier2(COMMAND_BUFFER, &info);
    ASSERT_MASKS(&seen.memory, ALL, READ | WRITE, COPY, COPY_WRITE);
    ASSERT_MASKS(&seen.buffer, ALL, READ, COPY, 0);
    ASSERT_MASKS(&seen.image, COPY, COPY_WRITE, ALL, READ);
    ASSERT_MASKS(&seen.range, COPY, COPY_WRITE, ALL, READ);
    assert_int_equal(seen.buffer.size, 7);
    ASSERT_MASKS(&range, COPY, COPY_WRITE, BUILD, READ_TREE);

    info.bufferMemoryBarrierCount = MANY;
    WITHOUT_MEMORY(cpu_CmdPipelineBarrier2(COMMAND_BUFFER, &info));
    assert_ptr_equal(seen.pointer, &info);
    cpu_CmdPipelineBarrier2(COMMAND_BUFFER, &info);
    assert_ptr_not_equal(seen.pointer, &info);
}

TEST_OPENED(a_barrier_without_ray_tracing, clear)
{
    const STRUCT(VkMemoryBarrier2, memory, NULL, COPY, COPY_WRITE, ALL, READ);
    const STRUCT(VkDependencyInfo, info, .memoryBarrierCount = 1, .pMemoryBarriers = &memory);
    cpu_CmdPipelineBarrier2(COMMAND_BUFFER, &info);
    assert_ptr_equal(seen.pointer, &info);
}

TEST_OPENED(events, clear)
{
    const STRUCT(VkMemoryBarrier2, memory, NULL, BUILD, 0, COPY, COPY_WRITE);
    const STRUCT(VkBufferMemoryBarrier2, buffer, NULL, COPY, COPY_WRITE, BUILD, WRITE_TREE);
    const VkDependencyInfo infos[] = {
        MAKE(VkDependencyInfo, .memoryBarrierCount = 1, .pMemoryBarriers = &memory),
        MAKE(VkDependencyInfo, .bufferMemoryBarrierCount = 1, .pBufferMemoryBarriers = &buffer)};
    cpu_CmdWaitEvents2(COMMAND_BUFFER, 2, NULL, infos);
    ASSERT_MASKS(&seen.memory, ALL, 0, COPY, COPY_WRITE);
    ASSERT_MASKS(&seen.buffer, COPY, COPY_WRITE, ALL, READ | WRITE);
    cpu_CmdSetEvent(COMMAND_BUFFER, VK_NULL_HANDLE, BUILD | COPY);
    assert_int_equal(seen.stages[0], ALL | COPY);
}

/* ---- render passes and submissions */

TEST_OPENED(render_passes, clear)
{
    const STRUCT(VkMemoryBarrier2, barrier, NULL, BUILD, WRITE_TREE, COPY, 0);
    const STRUCT(VkSubpassDependency2, dependency, .pNext = &barrier, .srcStageMask = TRACE);
    const STRUCT(VkRenderPassCreateInfo2, info, .dependencyCount = 1, .pDependencies = &dependency);
    VkRenderPass pass;
    assert_int_equal(cpu_CreateRenderPass2(DEVICE, &info, NULL, &pass), VK_SUCCESS);
    ASSERT_MASKS(&seen.dependency, ALL, 0, 0, 0);
    ASSERT_MASKS(&seen.chained, ALL, READ | WRITE, COPY, 0);
    assert_int_equal(barrier.srcStageMask, BUILD);
}

TEST_OPENED(submissions, clear)
{
    const VkPipelineStageFlags stages[] = {BUILD | COPY, COPY};
    static VkSubmitInfo submits[MANY];
    for (uint32_t i = 0; i < MANY; i++)
        submits[i] = MAKE(VkSubmitInfo, .waitSemaphoreCount = 2, .pWaitDstStageMask = &stages[0]);
    assert_int_equal(cpu_QueueSubmit((VkQueue)DEVICE, MANY, submits, VK_NULL_HANDLE), VK_SUCCESS);
    assert_int_equal(seen.stages[0], ALL | COPY);
    assert_int_equal(seen.stages[1], COPY);
    VkResult result;
    WITHOUT_MEMORY(result = cpu_QueueSubmit((VkQueue)DEVICE, MANY, submits, VK_NULL_HANDLE));
    assert_int_equal(result, VK_ERROR_OUT_OF_HOST_MEMORY);
    assert_int_equal(calls, 1);

    const STRUCT(VkSemaphoreSubmitInfo, wait, .value = 5, .stageMask = TRACE);
    const STRUCT(VkSemaphoreSubmitInfo, signal, .stageMask = BUILD);
    const STRUCT(VkSubmitInfo2, submit, .waitSemaphoreInfoCount = 1, .pWaitSemaphoreInfos = &wait,
                 .signalSemaphoreInfoCount = 1, .pSignalSemaphoreInfos = &signal);
    assert_int_equal(cpu_QueueSubmit2((VkQueue)DEVICE, 1, &submit, VK_NULL_HANDLE), VK_SUCCESS);
    assert_int_equal(seen.wait.value, 5);
    assert_int_equal(seen.wait.stageMask, ALL);
    assert_int_equal(seen.signal.stageMask, ALL);
}
