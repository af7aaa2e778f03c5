/* SPDX-License-Identifier: Apache-2.0 */
/* What journals have, with setting hazards, of barriers, events and render passes. */
#include "tests/recording/device.h"

#include "tests/fixture/scarce_memory.h"

#define BUILD_STAGE VK_PIPELINE_STAGE_2_ACCELERATION_STRUCTURE_BUILD_BIT_KHR
#define BUILD_STAGE_1 VK_PIPELINE_STAGE_ACCELERATION_STRUCTURE_BUILD_BIT_KHR
#define COPY_STAGE VK_PIPELINE_STAGE_2_COPY_BIT
#define WRITE_ACCEL VK_ACCESS_2_ACCELERATION_STRUCTURE_WRITE_BIT_KHR
#define READ_ACCEL VK_ACCESS_2_ACCELERATION_STRUCTURE_READ_BIT_KHR
#define WRITE_ACCEL_1 VK_ACCESS_ACCELERATION_STRUCTURE_WRITE_BIT_KHR
#define READ_ACCEL_1 VK_ACCESS_ACCELERATION_STRUCTURE_READ_BIT_KHR

/* Masks of barriers from writes to reads of builds, and how they look. The build stage has copies
 * of structures, too. */
#define MASKS                                                                                      \
    .srcStageMask = BUILD_STAGE, .srcAccessMask = WRITE_ACCEL, .dstStageMask = BUILD_STAGE,        \
    .dstAccessMask = READ_ACCEL
#define MASKED "BA:bg>BA:af"

static void record(const VkDependencyInfo *info)
{
    forwarded = 0;
    entry_CmdPipelineBarrier2_hazards(handle(1), info);
    assert_int_equal(forwarded, 1);
}

static void record_1(uint32_t memory_count, const VkMemoryBarrier *memory_barriers,
                     uint32_t buffer_count, const VkBufferMemoryBarrier *buffers)
{
    entry_CmdPipelineBarrier_hazards(handle(1), BUILD_STAGE_1, BUILD_STAGE_1, 0, memory_count,
                                     memory_barriers, buffer_count, buffers, 0, NULL);
}

RECORDING_TEST(barriers)
{
    const VkMemoryBarrier memories[] = {
        MAKE(VkMemoryBarrier, .srcAccessMask = WRITE_ACCEL_1, .dstAccessMask = READ_ACCEL_1),
        MAKE(VkMemoryBarrier, .srcAccessMask = 0)};
    const VkBufferMemoryBarrier buffers[] = {
        MAKE(VkBufferMemoryBarrier, .srcAccessMask = WRITE_ACCEL_1, .dstAccessMask = READ_ACCEL_1,
             .buffer = buffer(2), .offset = 0x10, .size = 0x20),
        MAKE(VkBufferMemoryBarrier, .buffer = buffer(2), .offset = 0x10, .size = VK_WHOLE_SIZE),
        MAKE(VkBufferMemoryBarrier, .buffer = buffer(3), .size = VK_WHOLE_SIZE)};
    record_1(0, NULL, 0, NULL);
    expect("barrier 1 BA:>BA: all\n");
    record_1(2, memories, 0, NULL);
    expect("barrier 1 " MASKED " all\n");
    record_1(0, NULL, 3, buffers);
    expect("barrier 4 BA:>BA: all\nbarrier " MASKED
           " 1010:1030\nbarrier BA:>BA: 1010:2000\n"
           "barrier BA:>BA: all\n");
}

/* Structures of extensions; one that is unknown may be any barrier. */
RECORDING_TEST(barriers_of_extensions)
{
    STRUCT(VkMemoryBarrierAccessFlags3KHR, flags, .srcAccessMask3 = 0);
    const VkMemoryRangeBarrierKHR ranges[] = {
        MAKE(VkMemoryRangeBarrierKHR, MASKS, .addressRange = {BUFFERS + 0x1004, 8}),
        MAKE(VkMemoryRangeBarrierKHR, MASKS, .addressRange = {1, 8})};
    const STRUCT(VkMemoryRangeBarriersInfoKHR, of_ranges, .memoryRangeBarrierCount = 2,
                 .pMemoryRangeBarriers = ranges);
    const STRUCT(VkTensorMemoryBarrierARM, tensor, MASKS);
    const STRUCT(VkTensorDependencyInfoARM, tensors, .tensorMemoryBarrierCount = 1,
                 .pTensorMemoryBarriers = &tensor);
    const VkBaseInStructure unknown = {.sType = (VkStructureType)0x7ffffff0};
    const STRUCT(VkBufferMemoryBarrier2, of_buffer, MASKS, .pNext = &flags, .buffer = buffer(1),
                 .size = 4);
    record(&MAKE(VkDependencyInfo, .pNext = &of_ranges));
    expect("barrier 2 " MASKED " 1004:100c\nbarrier " MASKED " all\n");
    record(&MAKE(VkDependencyInfo, .pNext = &tensor));
    record(&MAKE(VkDependencyInfo, .pNext = &tensors));
    record(&MAKE(VkDependencyInfo, .pNext = &unknown));
    expect("barrier 1 " MASKED "\nbarrier 1 " MASKED "\nbarrier 1 *:*>*:* all\n");
    const STRUCT(VkDependencyInfo, info, .bufferMemoryBarrierCount = 1,
                 .pBufferMemoryBarriers = &of_buffer);
    record(&info);
    flags.srcAccessMask3 = 1;
    record(&info);
    flags.srcAccessMask3 = 0;
    flags.dstAccessMask3 = 1;
    record(&info);
    expect("barrier 1 " MASKED " 0:4\nbarrier 1 BA:*>BA:af 0:4\nbarrier 1 BA:bg>BA:* 0:4\n");
}

static void transfer(uint32_t src, uint32_t dst, unsigned buffer_n)
{
    const STRUCT(VkBufferMemoryBarrier2, of_buffer, MASKS, .srcQueueFamilyIndex = src,
                 .dstQueueFamilyIndex = dst, .buffer = buffer(buffer_n), .size = 4);
    record(&MAKE(VkDependencyInfo, .bufferMemoryBarrierCount = 1,
                 .pBufferMemoryBarriers = &of_buffer));
}

/* The command buffer's pool is of family 0. */
RECORDING_TEST(transfers_between_queue_families)
{
    transfer(1, 1, 1);
    transfer(0, 1, 1);
    transfer(1, 0, 1);
    expect("barrier 1 " MASKED " 0:4\nbarrier 1 BA:bg>BA: 0:4\nbarrier 1 " MASKED " 0:4 acquire\n");
    transfer(0, VK_QUEUE_FAMILY_EXTERNAL, 1);
    transfer(1, 0, 3);
    command_buffers_find(device.command_buffers, handle(1))->pool->queue_family = 2;
    device.queue_family_count = 3;
    transfer(0, 1, 1);
    expect("barrier 1 *:*>*:* all\nbarrier 1 *:*>*:* all\nbarrier 1 *:*>*:* all\n");
}

#define EVENT ((VkEvent)(uintptr_t)0x807)

RECORDING_TEST(events)
{
    const VkEvent both[] = {EVENT, (VkEvent)(uintptr_t)0x808};
    const STRUCT(VkMemoryBarrier, barrier, .srcAccessMask = WRITE_ACCEL_1,
                 .dstAccessMask = READ_ACCEL_1);
    entry_CmdSetEvent_hazards(handle(1), EVENT, VK_PIPELINE_STAGE_TRANSFER_BIT);
    entry_CmdWaitEvents_hazards(handle(1), 2, both, BUILD_STAGE_1, BUILD_STAGE_1, 1, &barrier, 0,
                                NULL, 0, NULL);
    expect("set 7 ACF\nwait 7*1\nbarrier " MASKED " all\nwait 8*1\nbarrier " MASKED " all\n");
}

RECORDING_TEST(events_of_synchronization2)
{
    const STRUCT(VkMemoryBarrier2, of_memory, MASKS);
    const STRUCT(VkBufferMemoryBarrier2, of_buffer, .srcStageMask = COPY_STAGE, .buffer = buffer(1),
                 .size = 4);
    const STRUCT(VkImageMemoryBarrier2, of_image, .srcStageMask = VK_PIPELINE_STAGE_2_HOST_BIT);
    const STRUCT(VkDependencyInfo, info, .memoryBarrierCount = 1, .pMemoryBarriers = &of_memory,
                 .bufferMemoryBarrierCount = 1, .pBufferMemoryBarriers = &of_buffer,
                 .imageMemoryBarrierCount = 1, .pImageMemoryBarriers = &of_image);
    const VkDependencyInfo none = MAKE(VkDependencyInfo, .pNext = NULL),
                           extended = MAKE(VkDependencyInfo, .pNext = &none);
    const VkEvent event = EVENT;
    entry_CmdSetEvent2_hazards(handle(1), EVENT, &info);
    entry_CmdSetEvent2KHR_hazards(handle(1), EVENT, &extended);
    entry_CmdWaitEvents2_hazards(handle(1), 1, &event, &info);
    entry_CmdWaitEvents2KHR_hazards(handle(1), 1, &event, &none);
    expect("set 7 BACFH\nset 7 *\nwait 7*3\nbarrier " MASKED
           " all\nbarrier H:>:\n"
           "barrier CF:>: 0:4\nwait 7*0\n");
}

#define PASS ((VkRenderPass)(uintptr_t)0x901)

static void record_pass(void)
{
    const STRUCT(VkRenderPassBeginInfo, info, .renderPass = PASS);
    forwarded = 0;
    entry_CmdBeginRenderPass_hazards(handle(1), &info, VK_SUBPASS_CONTENTS_INLINE);
    entry_CmdNextSubpass_hazards(handle(1), VK_SUBPASS_CONTENTS_INLINE);
    entry_CmdEndRenderPass_hazards(handle(1));
    assert_int_equal(forwarded, 3);
}

/* Dependencies from outside count at the begin, inner ones at each change, all others at the end.
 */
RECORDING_TEST(render_passes)
{
    const VkSubpassDependency dependencies[] = {
        {1, VK_SUBPASS_EXTERNAL, VK_PIPELINE_STAGE_HOST_BIT, BUILD_STAGE_1},
        {0, 1, VK_PIPELINE_STAGE_HOST_BIT, VK_PIPELINE_STAGE_HOST_BIT},
        {VK_SUBPASS_EXTERNAL, 0, BUILD_STAGE_1, VK_PIPELINE_STAGE_HOST_BIT, WRITE_ACCEL_1, 0}};
    const STRUCT(VkRenderPassCreateInfo, info, .dependencyCount = 3, .pDependencies = dependencies);
    VkRenderPass pass = PASS;
    entry_CreateRenderPass_hazards(NULL, &info, NULL, &pass);
    record_pass();
    expect(
        "barrier 1 BA:bg>H: all\nbarrier 1 H:>H: all\nbarrier 1 H:>H: all\n"
        "barrier 1 H:>BA: all\n");
    entry_DestroyRenderPass_hazards(NULL, PASS, NULL);
    record_pass();
    expect("barrier 1 *:*>*:* all\nbarrier 1 *:*>*:* all\nbarrier 1 *:*>*:* all\n");
    entry_CreateRenderPass_hazards(NULL, &MAKE(VkRenderPassCreateInfo, .pNext = NULL), NULL, &pass);
    record_pass();
    expect("");
    WITHOUT_MEMORY(entry_CreateRenderPass_hazards(NULL, &info, NULL, &pass));
    record_pass();
    expect("barrier 1 *:*>*:* all\nbarrier 1 *:*>*:* all\nbarrier 1 *:*>*:* all\n");
}

RECORDING_TEST(render_passes_2)
{
    const STRUCT(VkMemoryBarrier2, masks, MASKS);
    const VkSubpassDependency2 dependencies[] = {
        MAKE(VkSubpassDependency2, .srcSubpass = VK_SUBPASS_EXTERNAL, .pNext = &masks),
        MAKE(VkSubpassDependency2, .srcSubpass = VK_SUBPASS_EXTERNAL, .dstSubpass = 1,
             .srcStageMask = VK_PIPELINE_STAGE_HOST_BIT)};
    const STRUCT(VkRenderPassCreateInfo2, info, .dependencyCount = 2,
                 .pDependencies = dependencies);
    const STRUCT(VkRenderPassBeginInfo, pass_info, .renderPass = PASS);
    const STRUCT(VkSubpassBeginInfo, begin_info, .pNext = NULL);
    const STRUCT(VkSubpassEndInfo, end_info, .pNext = NULL);
    VkRenderPass pass = PASS;
    forwarded = 0;
    entry_CreateRenderPass2_hazards(NULL, &info, NULL, &pass);
    entry_CreateRenderPass2KHR_hazards(NULL, &info, NULL, &pass);
    entry_CmdBeginRenderPass2_hazards(handle(1), &pass_info, &begin_info);
    entry_CmdNextSubpass2_hazards(handle(1), &begin_info, &end_info);
    entry_CmdEndRenderPass2_hazards(handle(1), &end_info);
    entry_CmdBeginRenderPass2KHR_hazards(handle(1), &pass_info, &begin_info);
    entry_CmdNextSubpass2KHR_hazards(handle(1), &begin_info, &end_info);
    entry_CmdEndRenderPass2KHR_hazards(handle(1), &end_info);
    assert_int_equal(forwarded, 8);
    expect("barrier 1 " MASKED
           " all\nbarrier 1 H:>: all\n"
           "barrier 1 " MASKED " all\nbarrier 1 H:>: all\n");
}

/* What was recorded before stays, and a group of barriers is recorded whole or not at all. */
RECORDING_TEST(without_memory)
{
    struct journal *journal = command_buffers_find(device.command_buffers, handle(1))->journal;
    const VkMemoryBarrier2 memories[200] = {MAKE(VkMemoryBarrier2, MASKS)};
    const STRUCT(VkDependencyInfo, info, .memoryBarrierCount = 200, .pMemoryBarriers = memories);
    WITHOUT_MEMORY(entry_CmdFillBuffer_hazards(handle(1), buffer(1), 0, 4, 0));
    assert_true(journal->lacks_hazards);
    begin(device.command_buffers, 1);
    entry_CmdFillBuffer_hazards(handle(1), buffer(1), 0, 4, 0);
    assert_false(journal->incomplete || journal->lacks_hazards);
    WITHOUT_MEMORY(record(&info));
    assert_true(journal->lacks_hazards);
    expect("vkCmdFillBuffer\n F> dst buffer1 0:4\n");
    record(&info);
    assert_false(journal->lacks_hazards);
}
