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
    hazards_CmdPipelineBarrier2(handle(1), info);
    assert_int_equal(forwarded, 1);
}

static void record_1(uint32_t memory_count, const VkMemoryBarrier *memory_barriers,
                     uint32_t buffer_count, const VkBufferMemoryBarrier *buffers)
{
    hazards_CmdPipelineBarrier(handle(1), BUILD_STAGE_1, BUILD_STAGE_1, 0, memory_count,
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

RECORDING_TEST(barriers_of_synchronization2)
{
    const STRUCT(VkMemoryBarrier2, of_memory, MASKS);
    const STRUCT(VkBufferMemoryBarrier2, of_buffer, MASKS, .buffer = buffer(1), .size = 4);
    const STRUCT(VkImageMemoryBarrier2, of_image, MASKS);
    const STRUCT(VkDependencyInfo, info, .memoryBarrierCount = 1, .pMemoryBarriers = &of_memory,
                 .bufferMemoryBarrierCount = 1, .pBufferMemoryBarriers = &of_buffer,
                 .imageMemoryBarrierCount = 1, .pImageMemoryBarriers = &of_image);
    record(&info);
    expect("barrier 3 " MASKED " all\nbarrier " MASKED "\nbarrier " MASKED " 0:4\n");
    hazards_CmdPipelineBarrier2KHR(handle(1), &MAKE(VkDependencyInfo, .pNext = NULL));
    expect("");
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
    hazards_CmdSetEvent(handle(1), EVENT, VK_PIPELINE_STAGE_TRANSFER_BIT);
    hazards_CmdWaitEvents(handle(1), 2, both, BUILD_STAGE_1, BUILD_STAGE_1, 1, &barrier, 0, NULL, 0,
                          NULL);
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
    hazards_CmdSetEvent2(handle(1), EVENT, &info);
    hazards_CmdSetEvent2KHR(handle(1), EVENT, &extended);
    hazards_CmdWaitEvents2(handle(1), 1, &event, &info);
    hazards_CmdWaitEvents2KHR(handle(1), 1, &event, &none);
    expect("set 7 BACFH\nset 7 *\nwait 7*3\nbarrier " MASKED
           " all\nbarrier H:>:\n"
           "barrier CF:>: 0:4\nwait 7*0\n");
}

#define PASS ((VkRenderPass)(uintptr_t)0x901)

static void record_pass(void)
{
    const STRUCT(VkRenderPassBeginInfo, info, .renderPass = PASS);
    forwarded = 0;
    hazards_CmdBeginRenderPass(handle(1), &info, VK_SUBPASS_CONTENTS_INLINE);
    hazards_CmdNextSubpass(handle(1), VK_SUBPASS_CONTENTS_INLINE);
    hazards_CmdEndRenderPass(handle(1));
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
    hazards_CreateRenderPass(NULL, &info, NULL, &pass);
    record_pass();
    expect(
        "barrier 1 BA:bg>H: all\nbarrier 1 H:>H: all\nbarrier 1 H:>H: all\n"
        "barrier 1 H:>BA: all\n");
    hazards_DestroyRenderPass(NULL, PASS, NULL);
    record_pass();
    expect("barrier 1 *:*>*:* all\nbarrier 1 *:*>*:* all\nbarrier 1 *:*>*:* all\n");
    hazards_CreateRenderPass(NULL, &MAKE(VkRenderPassCreateInfo, .pNext = NULL), NULL, &pass);
    record_pass();
    expect("");
    WITHOUT_MEMORY(hazards_CreateRenderPass(NULL, &info, NULL, &pass));
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
    VkRenderPass pass = PASS;
    forwarded = 0;
    hazards_CreateRenderPass2(NULL, &info, NULL, &pass);
    hazards_CreateRenderPass2KHR(NULL, &info, NULL, &pass);
    hazards_CmdBeginRenderPass2(handle(1), &pass_info, NULL);
    hazards_CmdNextSubpass2(handle(1), NULL, NULL);
    hazards_CmdEndRenderPass2(handle(1), NULL);
    hazards_CmdBeginRenderPass2KHR(handle(1), &pass_info, NULL);
    hazards_CmdNextSubpass2KHR(handle(1), NULL, NULL);
    hazards_CmdEndRenderPass2KHR(handle(1), NULL);
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
    WITHOUT_MEMORY(hazards_CmdFillBuffer(handle(1), buffer(1), 0, 4, 0));
    assert_true(journal->lacks_hazards);
    begin(device.command_buffers, 1);
    hazards_CmdFillBuffer(handle(1), buffer(1), 0, 4, 0);
    assert_false(journal->incomplete || journal->lacks_hazards);
    WITHOUT_MEMORY(record(&info));
    assert_true(journal->lacks_hazards);
    expect("vkCmdFillBuffer\n F> dst buffer1 0:4\n");
    record(&info);
    assert_false(journal->lacks_hazards);
}
