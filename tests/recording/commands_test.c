/* SPDX-License-Identifier: Apache-2.0 */
/* What journals have, with setting hazards, of commands other than builds. */
#include "tests/recording/device.h"

#include "layer/hazards/recording.h"

/* A command that is recorded also goes on, once. */
#define CALL(...)                                                                                  \
    do {                                                                                           \
        forwarded = 0;                                                                             \
        entry_##__VA_ARGS__;                                                                       \
        assert_int_equal(forwarded, 1);                                                            \
    } while (0)

#define IMAGE ((VkImage)(uintptr_t)0x501)
#define LAYERS(aspect, count)                                                                      \
    {                                                                                              \
        .aspectMask = VK_IMAGE_ASPECT_##aspect##_BIT, .layerCount = count                          \
    }

static void copy_region(VkImageAspectFlags aspect, uint32_t row_length, uint32_t height,
                        uint32_t layers)
{
    const VkBufferImageCopy region = {.bufferOffset = 0x10,
                                      .bufferRowLength = row_length,
                                      .bufferImageHeight = height,
                                      .imageSubresource = {aspect, 0, 0, layers},
                                      .imageExtent = {4, 2, 1}};
    CALL(CmdCopyImageToBuffer_hazards(handle(1), IMAGE, VK_IMAGE_LAYOUT_GENERAL, buffer(2), 1,
                                      &region));
}

RECORDING_TEST(copies_of_images)
{
    static const VkImageCreateInfo image = {.format = VK_FORMAT_R8G8B8A8_UNORM};
    VkImage created = IMAGE;
    CALL(CreateImage_hazards(NULL, &image, NULL, &created));
    copy_region(VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 2);
    expect("vkCmdCopyImageToBuffer\n C> dst buffer2 1010:1050\n anywhere\n");
    copy_region(VK_IMAGE_ASPECT_COLOR_BIT, 5, 0, 1);
    expect(
        "vkCmdCopyImageToBuffer\n C> dst buffer2 1010:1020\n C> dst buffer2 1024:1034\n "
        "anywhere\n");
    copy_region(VK_IMAGE_ASPECT_COLOR_BIT, 0, 3, 2);
    expect(
        "vkCmdCopyImageToBuffer\n C> dst buffer2 1010:1020\n C> dst buffer2 1050:1060\n "
        "anywhere\n");
    copy_region(VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, VK_REMAINING_ARRAY_LAYERS);
    copy_region(VK_IMAGE_ASPECT_DEPTH_BIT, 0, 0, 1);
    CALL(DestroyImage_hazards(NULL, IMAGE, NULL));
    copy_region(VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1);
    expect(
        "vkCmdCopyImageToBuffer\n anywhere\nvkCmdCopyImageToBuffer\n "
        "anywhere\nvkCmdCopyImageToBuffer\n anywhere\n");
}

RECORDING_TEST(other_copies_of_images)
{
    const VkBufferImageCopy region = {.imageSubresource = LAYERS(COLOR, 1),
                                      .imageExtent = {4, 4, 1}};
    const STRUCT(VkBufferImageCopy2, region2, .imageSubresource = LAYERS(COLOR, 1),
                 .imageExtent = {4, 4, 1});
    const STRUCT(VkCopyImageToBufferInfo2, to_buffer, .srcImage = IMAGE, .dstBuffer = buffer(2),
                 .regionCount = 1, .pRegions = &region2);
    const STRUCT(VkCopyBufferToImageInfo2, to_image, .srcBuffer = buffer(1), .dstImage = IMAGE,
                 .regionCount = 1, .pRegions = &region2);
    hazard_objects_add_image(device.hazard_objects, IMAGE, VK_FORMAT_BC1_RGB_UNORM_BLOCK);
    CALL(CmdCopyBufferToImage_hazards(handle(1), buffer(1), IMAGE, VK_IMAGE_LAYOUT_GENERAL, 1,
                                      &region));
    CALL(CmdCopyImageToBuffer2_hazards(handle(1), &to_buffer));
    CALL(CmdCopyImageToBuffer2KHR_hazards(handle(1), &to_buffer));
    CALL(CmdCopyBufferToImage2_hazards(handle(1), &to_image));
    CALL(CmdCopyBufferToImage2KHR_hazards(handle(1), &to_image));
    expect(
        "vkCmdCopyBufferToImage\n C< src buffer1 0:8\n"
        "vkCmdCopyImageToBuffer2\n C> dst buffer2 1000:1008\n anywhere\n"
        "vkCmdCopyImageToBuffer2KHR\n C> dst buffer2 1000:1008\n anywhere\n"
        "vkCmdCopyBufferToImage2\n C< src buffer1 0:8\n"
        "vkCmdCopyBufferToImage2KHR\n C< src buffer1 0:8\n");
}

RECORDING_TEST(fills_and_updates)
{
    CALL(CmdFillBuffer_hazards(handle(1), buffer(1), 4, 8, 0));
    CALL(CmdUpdateBuffer_hazards(handle(1), buffer(1), 8, 12, ""));
    have_bound_buffer(device.resources, 4, 0x13, 0, 1, 0x5000);
    CALL(CmdFillBuffer_hazards(handle(1), buffer(4), 4, VK_WHOLE_SIZE, 0));
    CALL(CmdFillBuffer_hazards(handle(1), buffer(3), 4, VK_WHOLE_SIZE, 0));
    expect(
        "vkCmdFillBuffer\n F> dst buffer1 4:c\nvkCmdUpdateBuffer\n F> dst buffer1 8:14\n"
        "vkCmdFillBuffer\n F> dst buffer4 5004:5010\nvkCmdFillBuffer\n anywhere\n");
}

RECORDING_TEST(markers)
{
    const STRUCT(VkMemoryMarkerInfoAMD, info, .dstRange = {BUFFERS + 0x1000, 8});
    CALL(CmdWriteBufferMarkerAMD_hazards(handle(1), VK_PIPELINE_STAGE_TRANSFER_BIT, buffer(1), 4,
                                         1));
    CALL(
        CmdWriteBufferMarker2AMD_hazards(handle(1), VK_PIPELINE_STAGE_2_COPY_BIT, buffer(1), 8, 1));
    CALL(CmdWriteMarkerToMemoryAMD_hazards(handle(1), &info));
    expect(
        "vkCmdWriteBufferMarkerAMD\n marker> dst buffer1 4:8\n"
        "vkCmdWriteBufferMarker2AMD\n marker> dst buffer1 8:c\n"
        "vkCmdWriteMarkerToMemoryAMD\n marker> dst buffer2 1000:1004\n");
}

RECORDING_TEST(commands_with_addresses)
{
    const VkDeviceAddressRangeKHR range = {BUFFERS + 0x1000, 8};
    const STRUCT(VkDeviceMemoryCopyKHR, copy, .srcRange = {BUFFERS, 4},
                 .dstRange = {BUFFERS + 0x1004, 4});
    const STRUCT(VkCopyDeviceMemoryInfoKHR, info, .regionCount = 1, .pRegions = &copy);
    CALL(CmdCopyMemoryKHR_hazards(handle(1), &info));
    CALL(CmdFillMemoryKHR_hazards(handle(1), &range, 0, 0));
    CALL(CmdUpdateMemoryKHR_hazards(handle(1), &range, 0, 4, ""));
    expect(
        "vkCmdCopyMemoryKHR\n C< src buffer1 0:4\n C> dst buffer2 1004:1008\n"
        "vkCmdFillMemoryKHR\n F> dst buffer2 1000:1008\n"
        "vkCmdUpdateMemoryKHR\n F> dst buffer2 1000:1004\n");
}

RECORDING_TEST(copies_of_images_by_address)
{
    static const VkImageCreateInfo image = {.format = VK_FORMAT_R8G8B8A8_UNORM};
    const STRUCT(VkDeviceMemoryImageCopyKHR, region, .addressRange = {BUFFERS + 0x1010, 0x100},
                 .addressRowLength = 5, .imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1},
                 .imageExtent = {4, 2, 1});
    const STRUCT(VkCopyDeviceMemoryImageInfoKHR, info, .image = IMAGE, .regionCount = 1,
                 .pRegions = &region);
    VkImage created = IMAGE;
    CALL(CreateImage_hazards(NULL, &image, NULL, &created));
    CALL(CmdCopyImageToMemoryKHR_hazards(handle(1), &info));
    CALL(CmdCopyMemoryToImageKHR_hazards(handle(1), &info));
    expect(
        "vkCmdCopyImageToMemoryKHR\n C> dst buffer2 1010:1020\n C> dst buffer2 1024:1034\n "
        "anywhere\n"
        "vkCmdCopyMemoryToImageKHR\n C< src buffer2 1010:1020\n C< src buffer2 1024:1034\n");
}

static void copy_results(VkQueryPool pool, uint32_t count, VkDeviceSize stride,
                         VkQueryResultFlags flags)
{
    CALL(
        CmdCopyQueryPoolResults_hazards(handle(1), pool, 0, count, buffer(1), 0x10, stride, flags));
}

RECORDING_TEST(results_of_queries)
{
    const VkQueryPool known = (VkQueryPool)(uintptr_t)0x601, other = (VkQueryPool)(uintptr_t)0x602;
    const VkQueryResultFlags wait = VK_QUERY_RESULT_WAIT_BIT, wide = VK_QUERY_RESULT_64_BIT,
                             available = VK_QUERY_RESULT_WITH_AVAILABILITY_BIT;
    const VkQueryPoolCreateInfo info = {
        .queryType = VK_QUERY_TYPE_ACCELERATION_STRUCTURE_COMPACTED_SIZE_KHR, .queryCount = 2};
    query_pools_add(device.query_pools, known, &info, true);
    copy_results(other, 2, 4, wait);
    expect("vkCmdCopyQueryPoolResults\n anywhere\n C> dst buffer1 10:18\n");
    copy_results(other, 2, 32, wait | wide | available);
    expect("vkCmdCopyQueryPoolResults\n anywhere\n C> dst buffer1 10:20\n C> dst buffer1 30:40\n");
    copy_results(known, 1, 0, wide | available);
    expect("vkCmdCopyQueryPoolResults\n anywhere\n C> dst buffer1 18:20\n");
    copy_results(other, 1, 0, available);
    copy_results(known, 1, 0, 0);
    copy_results(known, 0, 0, wait);
    expect(
        "vkCmdCopyQueryPoolResults\n anywhere\nvkCmdCopyQueryPoolResults\n "
        "anywhere\nvkCmdCopyQueryPoolResults\n anywhere\n");
}

RECORDING_TEST(results_of_queries_by_address)
{
    const VkQueryPool pool = (VkQueryPool)(uintptr_t)0x602;
    const VkStridedDeviceAddressRangeKHR range = {BUFFERS + 0x1010, 0x100, 0x20};
    CALL(CmdCopyQueryPoolResultsToMemoryKHR_hazards(handle(1), pool, 0, 2, &range, 0,
                                                    VK_QUERY_RESULT_WAIT_BIT));
    expect(
        "vkCmdCopyQueryPoolResultsToMemoryKHR\n anywhere\n C> dst buffer2 1010:1014\n"
        " C> dst buffer2 1030:1034\n");
}

/* ---- structures and micromaps */

RECORDING_TEST(copies_of_nv_structures)
{
    const VkAccelerationStructureNV nv[] = {(VkAccelerationStructureNV)(uintptr_t)0x401,
                                            (VkAccelerationStructureNV)(uintptr_t)0x402};
    for (unsigned i = 0; i < 2; i++) {
        resources_add_nv_accel(device.resources, nv[i], NULL,
                               &(struct nv_size_facts){true, 0x100, 0, 0});
        resources_bind_nv_accel(device.resources, nv[i], memory(1), i * 0x100, false);
    }
    CALL(CmdCopyAccelerationStructureNV_hazards(handle(1), nv[0], nv[1],
                                                VK_COPY_ACCELERATION_STRUCTURE_MODE_CLONE_KHR));
    CALL(CmdWriteAccelerationStructuresPropertiesNV_hazards(
        handle(1), 1, nv, VK_QUERY_TYPE_ACCELERATION_STRUCTURE_COMPACTED_SIZE_NV, VK_NULL_HANDLE,
        0));
    expect(
        "vkCmdCopyAccelerationStructureNV\n A< src nv2 100:200\n A> dst nv1 0:100\n"
        "vkCmdWriteAccelerationStructuresPropertiesNV\n A< src nv1 0:100\n");
}

RECORDING_TEST(host_copies_of_structures)
{
    static char mapped[0x1000];
    const VkAccelerationStructureKHR structure = accel(1);
    resources_map_memory(device.resources, memory(1), 0x4000, VK_WHOLE_SIZE, mapped);
    CALL(CopyAccelerationStructureKHR_hazards(
        NULL, VK_NULL_HANDLE,
        &MAKE(VkCopyAccelerationStructureInfoKHR, .src = accel(1), .dst = accel(2))));
    expect_host("vkCopyAccelerationStructureKHR\n H< src accel1 0:1\n H> dst accel2 200:201\n");
    CALL(CopyAccelerationStructureToMemoryKHR_hazards(
        NULL, VK_NULL_HANDLE,
        &MAKE(VkCopyAccelerationStructureToMemoryInfoKHR, .src = accel(1),
              .dst.hostAddress = mapped)));
    expect_host(
        "vkCopyAccelerationStructureToMemoryKHR\n H< src accel1 0:1\n"
        " H> memory memory0 4000:4038\n");
    CALL(CopyMemoryToAccelerationStructureKHR_hazards(
        NULL, VK_NULL_HANDLE,
        &MAKE(VkCopyMemoryToAccelerationStructureInfoKHR, .dst = accel(1),
              .src.hostAddress = mapped)));
    expect_host(
        "vkCopyMemoryToAccelerationStructureKHR\n H< memory memory0 4000:4038\n"
        " H> dst accel1 0:1\n");
    CALL(WriteAccelerationStructuresPropertiesKHR_hazards(
        NULL, 1, &structure, VK_QUERY_TYPE_ACCELERATION_STRUCTURE_COMPACTED_SIZE_KHR, 8, mapped,
        8));
    expect_host("vkWriteAccelerationStructuresPropertiesKHR\n H< src accel1 0:1\n");
}

static void micromap_sizes(VkDevice of, VkAccelerationStructureBuildTypeKHR type,
                           const VkMicromapBuildInfoEXT *info, VkMicromapBuildSizesInfoEXT *sizes)
{
    sizes->micromapSize = 0x40;
    sizes->buildScratchSize = 0x10;
}

RECORDING_TEST(micromaps)
{
    const VkMicromapEXT one = (VkMicromapEXT)(uintptr_t)0x701;
    const VkMicromapUsageEXT usage = {.count = 2};
    const STRUCT(VkMicromapBuildInfoEXT, build, .dstMicromap = one, .usageCountsCount = 1,
                 .pUsageCounts = &usage, .scratchData.deviceAddress = BUFFERS + 0x1000,
                 .triangleArray.deviceAddress = BUFFERS, .triangleArrayStride = 8);
    resources_add_micromap(
        device.resources, one,
        &MAKE(VkMicromapCreateInfoEXT, .buffer = buffer(2), .offset = 0x100, .size = 0x80));
    device.vk.GetMicromapBuildSizesEXT = micromap_sizes;
    device.facts.micromap.ext = true;
    CALL(CmdBuildMicromapsEXT_hazards(handle(1), 1, &build));
    CALL(CmdCopyMicromapEXT_hazards(
        handle(1), &MAKE(VkCopyMicromapInfoEXT, .src = one, .dst = VK_NULL_HANDLE)));
    CALL(CmdCopyMemoryToMicromapEXT_hazards(
        handle(1), &MAKE(VkCopyMemoryToMicromapInfoEXT, .dst = one, .src.deviceAddress = BUFFERS)));
    CALL(CmdCopyMicromapToMemoryEXT_hazards(
        handle(1), &MAKE(VkCopyMicromapToMemoryInfoEXT, .src = one, .dst.deviceAddress = BUFFERS)));
    CALL(CmdWriteMicromapsPropertiesEXT_hazards(
        handle(1), 1, &one, VK_QUERY_TYPE_MICROMAP_COMPACTED_SIZE_EXT, VK_NULL_HANDLE, 0));
    expect(
        "vkCmdBuildMicromapsEXT\n M> dst micromap1 1100:1140\n M> scratch buffer2 1000:1010\n"
        " M<shader other buffer1 0:10\nvkCmdCopyMicromapEXT\n M< src micromap1 1100:1101\n"
        "vkCmdCopyMemoryToMicromapEXT\n M<transfer memory buffer1 0:20\n"
        " M> dst micromap1 1100:1101\nvkCmdCopyMicromapToMemoryEXT\n"
        " M< src micromap1 1100:1101\n M>transfer memory buffer1 0:20\n anywhere\n"
        "vkCmdWriteMicromapsPropertiesEXT\n M< src micromap1 1100:1101\n");
    CALL(BuildMicromapsEXT_hazards(NULL, VK_NULL_HANDLE, 1, &build));
    expect_host("vkBuildMicromapsEXT\n H> dst micromap1 1100:1140\n");
    CALL(CopyMicromapEXT_hazards(NULL, VK_NULL_HANDLE, &MAKE(VkCopyMicromapInfoEXT, .dst = one)));
    expect_host("vkCopyMicromapEXT\n H> dst micromap1 1100:1101\n");
}

/* VUID-vkGetMicromapBuildSizesEXT-micromap-11618 */
RECORDING_TEST(sizes_of_micromaps_are_not_queried_without_the_feature)
{
    const VkMicromapUsageEXT usage = {.count = 2};
    const STRUCT(VkMicromapBuildInfoEXT, build, .usageCountsCount = 1, .pUsageCounts = &usage,
                 .scratchData.deviceAddress = BUFFERS + 0x1000,
                 .triangleArray.deviceAddress = BUFFERS, .triangleArrayStride = 8);
    device.vk.GetMicromapBuildSizesEXT = micromap_sizes;
    CALL(CmdBuildMicromapsEXT_hazards(handle(1), 1, &build));
    expect("vkCmdBuildMicromapsEXT\n M<shader other buffer1 0:10\n");
}
