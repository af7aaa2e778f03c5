/* SPDX-License-Identifier: Apache-2.0 */
/* Calls of older commands in the structures of newer ones: no member is forgotten, and memory may
 * run out. Every member of the older structures has another value. */
#include "layer/intercepts/lower.h"

#include "tests/fixture/scarce_memory.h"
#include "tests/unit/unit_test.h"

#define HANDLE(type, number) ((type)(uintptr_t)(number))

static const VkExternalMemoryAcquireUnmodifiedEXT chained = {
    .sType = VK_STRUCTURE_TYPE_EXTERNAL_MEMORY_ACQUIRE_UNMODIFIED_EXT};
static const VkPipelineStageFlags src = VK_PIPELINE_STAGE_TRANSFER_BIT;
static const VkPipelineStageFlags dst = VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT;
static const VkMemoryBarrier memory[] = {
    {.srcAccessMask = VK_ACCESS_TRANSFER_WRITE_BIT, .dstAccessMask = VK_ACCESS_SHADER_READ_BIT},
    {.srcAccessMask = VK_ACCESS_TRANSFER_READ_BIT, .dstAccessMask = VK_ACCESS_SHADER_WRITE_BIT},
};
static const VkBufferMemoryBarrier buffer = {.pNext = &chained,
                                             .srcAccessMask = VK_ACCESS_MEMORY_WRITE_BIT,
                                             .dstAccessMask = VK_ACCESS_UNIFORM_READ_BIT,
                                             .srcQueueFamilyIndex = 3,
                                             .dstQueueFamilyIndex = 4,
                                             .buffer = HANDLE(VkBuffer, 5),
                                             .offset = 6,
                                             .size = 7};

static void check_buffer(const VkBufferMemoryBarrier2 *lowered)
{
    assert_int_equal(lowered->sType, VK_STRUCTURE_TYPE_BUFFER_MEMORY_BARRIER_2);
    assert_ptr_equal(lowered->pNext, &chained);
    assert_int_equal(lowered->srcStageMask, src);
    assert_int_equal(lowered->srcAccessMask, buffer.srcAccessMask);
    assert_int_equal(lowered->dstStageMask, dst);
    assert_int_equal(lowered->dstAccessMask, buffer.dstAccessMask);
    assert_int_equal(lowered->srcQueueFamilyIndex, 3);
    assert_int_equal(lowered->dstQueueFamilyIndex, 4);
    assert_ptr_equal(lowered->buffer, HANDLE(void *, 5));
    assert_int_equal(lowered->offset, 6);
    assert_int_equal(lowered->size, 7);
}

static void check_info(const VkDependencyInfo *info, VkAccessFlags2 src_access,
                       VkAccessFlags2 dst_access)
{
    assert_int_equal(info->sType, VK_STRUCTURE_TYPE_DEPENDENCY_INFO);
    assert_null(info->pNext);
    assert_int_equal(info->imageMemoryBarrierCount, 0);
    assert_int_equal(info->memoryBarrierCount, 1);
    assert_int_equal(info->pMemoryBarriers->sType, VK_STRUCTURE_TYPE_MEMORY_BARRIER_2);
    assert_null(info->pMemoryBarriers->pNext);
    assert_int_equal(info->pMemoryBarriers->srcStageMask, src);
    assert_int_equal(info->pMemoryBarriers->srcAccessMask, src_access);
    assert_int_equal(info->pMemoryBarriers->dstStageMask, dst);
    assert_int_equal(info->pMemoryBarriers->dstAccessMask, dst_access);
}

/* Two waits have the same barriers, and all memory barriers are one. */
TEST(all_barriers)
{
    struct block block;
    const VkDependencyInfo *infos = lower_dependencies(&block, 2, src, dst, 2, memory, 1, &buffer);
    for (uint32_t i = 0; i < 2; i++) {
        check_info(&infos[i], VK_ACCESS_TRANSFER_WRITE_BIT | VK_ACCESS_TRANSFER_READ_BIT,
                   VK_ACCESS_SHADER_READ_BIT | VK_ACCESS_SHADER_WRITE_BIT);
        assert_int_equal(infos[i].bufferMemoryBarrierCount, 1);
        check_buffer(infos[i].pBufferMemoryBarriers);
    }
    block_end(&block);
}

/* A command without barriers is an execution dependency. */
TEST(no_barriers)
{
    struct block block;
    const VkDependencyInfo *info = lower_dependencies(&block, 1, src, dst, 0, NULL, 0, NULL);
    check_info(info, 0, 0);
    assert_int_equal(info->bufferMemoryBarrierCount, 0);
    block_end(&block);
}

enum { MANY = 1000 };

TEST(many_barriers)
{
    static VkBufferMemoryBarrier many[MANY];
    struct block block;
    for (uint32_t i = 0; i < MANY; i++)
        many[i] = buffer;
    const VkDependencyInfo *info = lower_dependencies(&block, 1, src, dst, 0, NULL, MANY, many);
    assert_int_equal(info->bufferMemoryBarrierCount, MANY);
    for (uint32_t i = 0; i < MANY; i++)
        check_buffer(&info->pBufferMemoryBarriers[i]);
    block_end(&block);
    WITHOUT_MEMORY(assert_null(lower_dependencies(&block, 1, src, dst, 0, NULL, MANY, many)));
    block_end(&block);
}

/* ---- submissions */

static const VkSemaphore waits[] = {HANDLE(VkSemaphore, 0x10), HANDLE(VkSemaphore, 0x11)};
static const VkSemaphore signals[] = {HANDLE(VkSemaphore, 0x20), HANDLE(VkSemaphore, 0x21),
                                      HANDLE(VkSemaphore, 0x22)};
static const VkCommandBuffer commands[] = {HANDLE(VkCommandBuffer, 0x30)};
static const VkPipelineStageFlags wait_stages[] = {VK_PIPELINE_STAGE_TRANSFER_BIT,
                                                   VK_PIPELINE_STAGE_HOST_BIT};
static const VkSubmitInfo submit = {.waitSemaphoreCount = 2,
                                    .pWaitSemaphores = waits,
                                    .pWaitDstStageMask = wait_stages,
                                    .commandBufferCount = 1,
                                    .pCommandBuffers = commands,
                                    .signalSemaphoreCount = 3,
                                    .pSignalSemaphores = signals};

static void check_semaphore(const VkSemaphoreSubmitInfo *lowered, VkSemaphore semaphore,
                            uint64_t value, VkPipelineStageFlags2 stages, uint32_t device)
{
    assert_int_equal(lowered->sType, VK_STRUCTURE_TYPE_SEMAPHORE_SUBMIT_INFO);
    assert_null(lowered->pNext);
    assert_ptr_equal(lowered->semaphore, semaphore);
    assert_int_equal(lowered->value, value);
    assert_int_equal(lowered->stageMask, stages);
    assert_int_equal(lowered->deviceIndex, device);
}

/* `values` and `devices`: of the waits and signals in their order. */
static void check_submit(const VkSubmitInfo2 *lowered, const void *chain, const uint64_t *values,
                         const uint32_t *devices, uint32_t mask)
{
    assert_int_equal(lowered->sType, VK_STRUCTURE_TYPE_SUBMIT_INFO_2);
    assert_ptr_equal(lowered->pNext, chain);
    assert_int_equal(lowered->waitSemaphoreInfoCount, 2);
    for (uint32_t i = 0; i < 2; i++)
        check_semaphore(&lowered->pWaitSemaphoreInfos[i], waits[i], values[i], wait_stages[i],
                        devices[i]);
    assert_int_equal(lowered->commandBufferInfoCount, 1);
    assert_int_equal(lowered->pCommandBufferInfos->sType,
                     VK_STRUCTURE_TYPE_COMMAND_BUFFER_SUBMIT_INFO);
    assert_null(lowered->pCommandBufferInfos->pNext);
    assert_ptr_equal(lowered->pCommandBufferInfos->commandBuffer, commands[0]);
    assert_int_equal(lowered->pCommandBufferInfos->deviceMask, mask);
    assert_int_equal(lowered->signalSemaphoreInfoCount, 3);
    for (uint32_t i = 0; i < 3; i++)
        check_semaphore(&lowered->pSignalSemaphoreInfos[i], signals[i], values[2 + i],
                        VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, devices[2 + i]);
}

TEST(plain_submit)
{
    const uint64_t values[5] = {0};
    const uint32_t devices[5] = {0};
    struct block block;
    const VkSubmitInfo2 *lowered = lower_submits(&block, 1, &submit);
    check_submit(lowered, NULL, values, devices, 1);
    block_end(&block);
}

/* The last signal has no value, and there are two batches. */
TEST(chained_submits)
{
    const uint64_t values[5] = {1, 2, 3, 4, 0}, none[5] = {0};
    const uint32_t devices[5] = {5, 6, 7, 8, 9}, first[5] = {0}, mask = 6;
    const VkDeviceGroupSubmitInfo group = {.sType = VK_STRUCTURE_TYPE_DEVICE_GROUP_SUBMIT_INFO,
                                           .waitSemaphoreCount = 2,
                                           .pWaitSemaphoreDeviceIndices = devices,
                                           .commandBufferCount = 1,
                                           .pCommandBufferDeviceMasks = &mask,
                                           .signalSemaphoreCount = 3,
                                           .pSignalSemaphoreDeviceIndices = &devices[2]};
    const VkTimelineSemaphoreSubmitInfo timeline = {
        .sType = VK_STRUCTURE_TYPE_TIMELINE_SEMAPHORE_SUBMIT_INFO,
        .pNext = &group,
        .waitSemaphoreValueCount = 2,
        .pWaitSemaphoreValues = values,
        .signalSemaphoreValueCount = 2,
        .pSignalSemaphoreValues = &values[2]};
    VkSubmitInfo submits[2] = {submit, submit};
    submits[0].pNext = &timeline;
    struct block block;
    const VkSubmitInfo2 *lowered = lower_submits(&block, 2, submits);
    check_submit(&lowered[0], &timeline, values, devices, mask);
    check_submit(&lowered[1], NULL, none, first, 1);
    block_end(&block);
}

/* Values that are missing as a whole belong to binary semaphores, too. */
TEST(missing_values)
{
    const VkTimelineSemaphoreSubmitInfo timeline = {
        .sType = VK_STRUCTURE_TYPE_TIMELINE_SEMAPHORE_SUBMIT_INFO,
        .waitSemaphoreValueCount = 1,
        .signalSemaphoreValueCount = 1};
    assert_int_equal(lower_value(&timeline, WAIT_OF_BATCH, 0), 0);
    assert_int_equal(lower_value(&timeline, SIGNAL_OF_BATCH, 0), 0);
}

TEST(many_submits)
{
    static VkSubmitInfo many[MANY];
    const uint64_t values[5] = {0};
    const uint32_t devices[5] = {0};
    struct block block;
    for (uint32_t i = 0; i < MANY; i++)
        many[i] = submit;
    const VkSubmitInfo2 *lowered = lower_submits(&block, MANY, many);
    for (uint32_t i = 0; i < MANY; i++)
        check_submit(&lowered[i], NULL, values, devices, 1);
    block_end(&block);
    WITHOUT_MEMORY(assert_null(lower_submits(&block, MANY, many)));
    block_end(&block);
}
