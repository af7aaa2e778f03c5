/* SPDX-License-Identifier: Apache-2.0 */
/* What the driver sees of stages and accesses of ray tracing: barriers, events and timestamps. */
#include <string.h>

#include "backend.h"
#include "below.h"
#include "tests/fixture/objects.h"
#include "tests/fixture/scarce_memory.h"
#include "tests/state/unit_test.h"

/* ---- the driver */

static struct {
    uint64_t src, dst, stage;
    uint32_t count, buffer_count, image_count;
    const void *array; /* only to compare */
    VkMemoryBarrier memory[MANY];
    VkBufferMemoryBarrier buffer;
    VkImageMemoryBarrier image;
    VkMemoryBarrier2 memory2[MANY];
    VkBufferMemoryBarrier2 buffer2;
    VkImageMemoryBarrier2 image2;
    VkMemoryRangeBarrierKHR range;
} seen;

static void see_barriers(VkPipelineStageFlags src, VkPipelineStageFlags dst, uint32_t count,
                         const VkMemoryBarrier *memory, uint32_t buffer_count,
                         const VkBufferMemoryBarrier *buffers, uint32_t image_count,
                         const VkImageMemoryBarrier *images)
{
    calls++;
    seen.src = src;
    seen.dst = dst;
    seen.count = count;
    seen.array = memory;
    if (count)
        memcpy(seen.memory, memory, count * sizeof(*memory));
    if (buffer_count)
        seen.buffer = *buffers;
    if (image_count)
        seen.image = *images;
    seen.buffer_count = buffer_count;
    seen.image_count = image_count;
}

PLAYED(CmdPipelineBarrier)
{
    assert_int_equal(dependencyFlags, VK_DEPENDENCY_BY_REGION_BIT);
    see_barriers(srcStageMask, dstStageMask, memoryBarrierCount, pMemoryBarriers,
                 bufferMemoryBarrierCount, pBufferMemoryBarriers, imageMemoryBarrierCount,
                 pImageMemoryBarriers);
}

PLAYED(CmdWaitEvents)
{
    assert_int_equal(eventCount, 1);
    see_barriers(srcStageMask, dstStageMask, memoryBarrierCount, pMemoryBarriers,
                 bufferMemoryBarrierCount, pBufferMemoryBarriers, imageMemoryBarrierCount,
                 pImageMemoryBarriers);
}

/* A command with a mask of stages, its parameter of that name. */
#define STAGE_SEEN(name, parameter)                                                                \
    PLAYED(name)                                                                                   \
    {                                                                                              \
        calls++;                                                                                   \
        seen.stage = parameter;                                                                    \
    }
STAGE_SEEN(CmdSetEvent, stageMask)
STAGE_SEEN(CmdResetEvent, stageMask)
STAGE_SEEN(CmdResetEvent2, stageMask)
STAGE_SEEN(CmdWriteTimestamp, pipelineStage)
STAGE_SEEN(CmdWriteTimestamp2, stage)

static void see_info(const VkDependencyInfo *info)
{
    calls++;
    seen.count = info->memoryBarrierCount;
    if (seen.count)
        memcpy(seen.memory2, info->pMemoryBarriers, seen.count * sizeof(seen.memory2[0]));
    if (info->bufferMemoryBarrierCount)
        seen.buffer2 = *info->pBufferMemoryBarriers;
    if (info->imageMemoryBarrierCount)
        seen.image2 = *info->pImageMemoryBarriers;
    const VkMemoryRangeBarriersInfoKHR *ranges = info->pNext;
    if (ranges && ranges->memoryRangeBarrierCount)
        seen.range = *ranges->pMemoryRangeBarriers;
}

PLAYED(CmdPipelineBarrier2)
{
    seen.array = pDependencyInfo;
    see_info(pDependencyInfo);
}

PLAYED(CmdWaitEvents2)
{
    seen.array = pDependencyInfos;
    for (uint32_t i = 0; i < eventCount; i++)
        see_info(&pDependencyInfos[i]);
}

static void clear(void)
{
    memset(&seen, 0, sizeof(seen));
    below_clear();
}

/* ---- Vulkan 1.0 */

static void barrier(VkPipelineStageFlags src, VkPipelineStageFlags dst, uint32_t count,
                    const VkMemoryBarrier *memory)
{
    cpu_CmdPipelineBarrier(COMMAND_BUFFER, src, dst, VK_DEPENDENCY_BY_REGION_BIT, count, memory, 0,
                           NULL, 0, NULL);
}

static void expect_masks(VkPipelineStageFlags src, VkPipelineStageFlags dst,
                         VkAccessFlags src_access, VkAccessFlags dst_access)
{
    assert_int_equal(seen.src, src);
    assert_int_equal(seen.dst, dst);
    assert_int_equal(seen.memory[0].srcAccessMask, src_access);
    assert_int_equal(seen.memory[0].dstAccessMask, dst_access);
}

/* What has no bit of ray tracing is not even copied. */
TEST_OPENED(test_other_barriers_pass, clear)
{
    const VkMemoryBarrier memory = {.srcAccessMask = SHADER_WRITE, .dstAccessMask = SHADER_READ};
    barrier(COMPUTE, ALL, 1, &memory);
    assert_int_equal(calls, 1);
    assert_ptr_equal(seen.array, &memory);
    expect_masks(COMPUTE, ALL, SHADER_WRITE, SHADER_READ);
}

/* What builds read, they read with any access: the copies that stand for it read memory. */
TEST_OPENED(test_barrier_before_a_build, clear)
{
    const VkMemoryBarrier memory = {.srcAccessMask = SHADER_WRITE, .dstAccessMask = SHADER_READ};
    barrier(COMPUTE, BUILD, 1, &memory);
    expect_masks(COMPUTE, ALL, SHADER_WRITE, SHADER_READ | MEMORY_READ);
    assert_int_equal(memory.dstAccessMask, SHADER_READ);
}

TEST_OPENED(test_barrier_between_builds, clear)
{
    const VkMemoryBarrier memory = {.srcAccessMask = WRITE, .dstAccessMask = READ | WRITE};
    barrier(BUILD, BUILD | COMPUTE, 1, &memory);
    expect_masks(ALL, ALL | COMPUTE, MEMORY_READ | MEMORY_WRITE, MEMORY_READ | MEMORY_WRITE);
}

/* An access of ray tracing at a stage that isn't. */
TEST_OPENED(test_access_alone, clear)
{
    const VkMemoryBarrier memory = {.srcAccessMask = WRITE, .dstAccessMask = READ};
    barrier(ALL, ALL, 1, &memory);
    expect_masks(ALL, ALL, MEMORY_WRITE, MEMORY_READ);
    barrier(BUILD, BUILD, 0, NULL);
    assert_int_equal(seen.count, 0);
    assert_int_equal(seen.src, ALL);
}

TEST_OPENED(test_all_kinds_of_barriers, clear)
{
    const VkBufferMemoryBarrier buffer = {.srcAccessMask = WRITE,
                                          .dstAccessMask = READ,
                                          .buffer = (VkBuffer)(uintptr_t)7,
                                          .offset = 5,
                                          .size = 6};
    const VkImageMemoryBarrier image = {.srcAccessMask = SHADER_WRITE,
                                        .dstAccessMask = SHADER_READ,
                                        .newLayout = VK_IMAGE_LAYOUT_GENERAL};
    const VkEvent event = VK_NULL_HANDLE;
    cpu_CmdWaitEvents(COMMAND_BUFFER, 1, &event, BUILD, COMPUTE, 0, NULL, 1, &buffer, 1, &image);
    assert_int_equal(seen.src, ALL);
    assert_int_equal(seen.dst, COMPUTE);
    assert_int_equal(seen.buffer_count, 1);
    assert_int_equal(seen.buffer.srcAccessMask, MEMORY_READ | MEMORY_WRITE);
    assert_int_equal(seen.buffer.dstAccessMask, MEMORY_READ);
    assert_int_equal(seen.buffer.size, 6);
    assert_int_equal(seen.image_count, 1);
    assert_int_equal(seen.image.srcAccessMask, SHADER_WRITE | MEMORY_READ);
    assert_int_equal(seen.image.dstAccessMask, SHADER_READ);
    assert_int_equal(seen.image.newLayout, VK_IMAGE_LAYOUT_GENERAL);
}

/* More than the stack takes; without memory the call goes down as it is. */
TEST_OPENED(test_many_barriers, clear)
{
    static VkMemoryBarrier memory[MANY];
    for (unsigned i = 0; i < MANY; i++)
        memory[i].dstAccessMask = i == MANY - 1 ? READ : SHADER_READ;
    memory_fail_after(100);
    barrier(COMPUTE, COMPUTE, 2, memory);
    assert_false(memory_fail_no_more());
    barrier(COMPUTE, COMPUTE, MANY, memory);
    assert_int_equal(seen.count, MANY);
    assert_int_equal(seen.memory[0].dstAccessMask, SHADER_READ);
    assert_int_equal(seen.memory[MANY - 1].dstAccessMask, MEMORY_READ);

    memory_fail_after(0);
    barrier(COMPUTE, COMPUTE, MANY, memory);
    assert_true(memory_fail_no_more());
    assert_int_equal(calls, 3);
    assert_ptr_equal(seen.array, memory);
}

TEST_OPENED(test_stages_alone, clear)
{
    cpu_CmdSetEvent(COMMAND_BUFFER, VK_NULL_HANDLE, BUILD | COMPUTE);
    assert_int_equal(seen.stage, ALL | COMPUTE);
    cpu_CmdResetEvent(COMMAND_BUFFER, VK_NULL_HANDLE, COMPUTE);
    assert_int_equal(seen.stage, COMPUTE);
    cpu_CmdWriteTimestamp(COMMAND_BUFFER, VK_PIPELINE_STAGE_ACCELERATION_STRUCTURE_BUILD_BIT_KHR,
                          VK_NULL_HANDLE, 0);
    assert_int_equal(seen.stage, ALL);
    cpu_CmdResetEvent2(COMMAND_BUFFER, VK_NULL_HANDLE,
                       VK_PIPELINE_STAGE_2_ACCELERATION_STRUCTURE_COPY_BIT_KHR);
    assert_int_equal(seen.stage, ALL);
    cpu_CmdWriteTimestamp2(COMMAND_BUFFER, VK_PIPELINE_STAGE_2_COPY_BIT, VK_NULL_HANDLE, 0);
    assert_int_equal(seen.stage, VK_PIPELINE_STAGE_2_COPY_BIT);
    assert_int_equal(calls, 5);
}

/* ---- VK_KHR_synchronization2 */

TEST_OPENED(test_other_dependencies_pass, clear)
{
    const VkMemoryBarrier2 memory = {.srcStageMask = COMPUTE,
                                     .srcAccessMask = VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT,
                                     .dstStageMask = ALL,
                                     .dstAccessMask = SHADER_READ};
    const VkDependencyInfo info = {.memoryBarrierCount = 1, .pMemoryBarriers = &memory};
    cpu_CmdPipelineBarrier2(COMMAND_BUFFER, &info);
    assert_ptr_equal(seen.array, &info);
    assert_int_equal(calls, 1);
}

TEST_OPENED(test_dependency, clear)
{
    const VkMemoryBarrier2 memory[] = {
        {.srcStageMask = VK_PIPELINE_STAGE_2_COPY_BIT,
         .srcAccessMask = VK_ACCESS_2_TRANSFER_WRITE_BIT,
         .dstStageMask = BUILD,
         .dstAccessMask = VK_ACCESS_2_SHADER_STORAGE_READ_BIT},
        {.srcStageMask = BUILD, .dstStageMask = COMPUTE, .dstAccessMask = SHADER_READ},
    };
    const VkBufferMemoryBarrier2 buffer = {
        .srcStageMask = COMPUTE, .dstStageMask = COMPUTE, .dstAccessMask = READ, .size = 6};
    const VkImageMemoryBarrier2 image = {.srcStageMask = BUILD, .dstStageMask = COMPUTE};
    const VkMemoryRangeBarrierKHR range = {
        .srcStageMask = BUILD, .srcAccessMask = WRITE, .dstStageMask = BUILD};
    const STRUCT(VkMemoryRangeBarriersInfoKHR, ranges, .memoryRangeBarrierCount = 1,
                 .pMemoryRangeBarriers = &range);
    const VkDependencyInfo info = {.pNext = &ranges,
                                   .memoryBarrierCount = 2,
                                   .pMemoryBarriers = memory,
                                   .bufferMemoryBarrierCount = 1,
                                   .pBufferMemoryBarriers = &buffer,
                                   .imageMemoryBarrierCount = 1,
                                   .pImageMemoryBarriers = &image};
    cpu_CmdPipelineBarrier2(COMMAND_BUFFER, &info);
    assert_int_equal(seen.count, 2);
    assert_int_equal(seen.memory2[0].srcStageMask, VK_PIPELINE_STAGE_2_COPY_BIT);
    assert_int_equal(seen.memory2[0].srcAccessMask, VK_ACCESS_2_TRANSFER_WRITE_BIT);
    assert_int_equal(seen.memory2[0].dstStageMask, ALL);
    assert_int_equal(seen.memory2[0].dstAccessMask,
                     VK_ACCESS_2_SHADER_STORAGE_READ_BIT | MEMORY_READ);
    assert_int_equal(seen.memory2[1].srcStageMask, ALL);
    assert_int_equal(seen.memory2[1].srcAccessMask, 0);
    assert_int_equal(seen.memory2[1].dstAccessMask, SHADER_READ);
    assert_int_equal(seen.buffer2.dstAccessMask, MEMORY_READ);
    assert_int_equal(seen.buffer2.size, 6);
    assert_int_equal(seen.image2.srcStageMask, ALL);
    assert_int_equal(seen.range.srcStageMask, ALL);
    assert_int_equal(seen.range.srcAccessMask, MEMORY_READ | MEMORY_WRITE);
}

TEST_OPENED(test_waits_for_events, clear)
{
    const VkMemoryBarrier2 plain = {.srcStageMask = COMPUTE, .dstStageMask = COMPUTE};
    const VkMemoryBarrier2 traced = {.srcStageMask = BUILD, .dstStageMask = COMPUTE};
    const VkDependencyInfo infos[] = {
        {.memoryBarrierCount = 1, .pMemoryBarriers = &plain},
        {0},
        {.memoryBarrierCount = 1, .pMemoryBarriers = &traced},
    };
    const VkEvent events[3] = {VK_NULL_HANDLE};
    cpu_CmdWaitEvents2(COMMAND_BUFFER, 2, events, infos);
    assert_ptr_equal(seen.array, infos);
    cpu_CmdWaitEvents2(COMMAND_BUFFER, 3, events, infos);
    assert_ptr_not_equal(seen.array, infos);
    assert_int_equal(seen.memory2[0].srcStageMask, ALL);
    assert_int_equal(seen.memory2[0].dstStageMask, COMPUTE);
}

/* Every allocation fails in turn; the last life has all. */
TEST_OPENED(test_dependencies_without_memory, clear)
{
    static const VkMemoryRangeBarrierKHR range[MANY] = {{.srcStageMask = BUILD}};
    const STRUCT(VkMemoryRangeBarriersInfoKHR, ranges, .memoryRangeBarrierCount = MANY,
                 .pMemoryRangeBarriers = range);
    const VkDependencyInfo info = {.pNext = &ranges};
    for (int i = 0; i < 3; i++) {
        memory_fail_after(i);
        cpu_CmdPipelineBarrier2(COMMAND_BUFFER, &info);
        assert_int_equal(memory_fail_no_more(), i < 2);
        assert_int_equal(seen.array == &info, i < 2);
    }
    assert_int_equal(seen.range.srcStageMask, ALL);
}
