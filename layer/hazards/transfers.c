/* SPDX-License-Identifier: Apache-2.0 */
/* Records copies, fills and updates of buffers, and markers. */
#include "layer/hazards/commands.h"
#include "layer/hazards/objects.h"
#include "layer/hazards/recording.h"

/* ---- between buffers */

/* VkBufferCopy2 has the members of VkBufferCopy. */
#define ADD_BUFFER_COPIES(recording, src, dst, count, regions)                                     \
    do {                                                                                           \
        for (uint32_t i = 0; i < (count); i++) {                                                   \
            hazard_recording_add_buffer(recording, ACCESS_TRANSFER_READ, HAZARD_SRC, src,          \
                                        (regions)[i].srcOffset, (regions)[i].size);                \
            hazard_recording_add_buffer(recording, ACCESS_TRANSFER_WRITE, HAZARD_DST, dst,         \
                                        (regions)[i].dstOffset, (regions)[i].size);                \
        }                                                                                          \
    } while (0)

VKAPI_ATTR void VKAPI_CALL hazards_CmdCopyBuffer(VkCommandBuffer commandBuffer, VkBuffer srcBuffer,
                                                 VkBuffer dstBuffer, uint32_t regionCount,
                                                 const VkBufferCopy *pRegions)
{
    struct layer_device *device = layer_find_recording_device(commandBuffer);
    struct hazard_recording recording;
    if (!device)
        return;
    if (hazard_recording_begin(&recording, commandBuffer, "vkCmdCopyBuffer"))
        ADD_BUFFER_COPIES(&recording, srcBuffer, dstBuffer, regionCount, pRegions);
    device->vk.CmdCopyBuffer(commandBuffer, srcBuffer, dstBuffer, regionCount, pRegions);
}

/* A command and its alias differ only in which command they call. */
#define DEFINE_COPY_BUFFER_2(name)                                                                 \
    VKAPI_ATTR void VKAPI_CALL hazards_##name(VkCommandBuffer commandBuffer,                       \
                                              const VkCopyBufferInfo2 *pInfo)                      \
    {                                                                                              \
        struct layer_device *device = layer_find_recording_device(commandBuffer);                  \
        struct hazard_recording recording;                                                         \
        if (!device)                                                                               \
            return;                                                                                \
        if (hazard_recording_begin(&recording, commandBuffer, "vk" #name))                         \
            ADD_BUFFER_COPIES(&recording, pInfo->srcBuffer, pInfo->dstBuffer, pInfo->regionCount,  \
                              pInfo->pRegions);                                                    \
        device->vk.name(commandBuffer, pInfo);                                                     \
    }

DEFINE_COPY_BUFFER_2(CmdCopyBuffer2)
DEFINE_COPY_BUFFER_2(CmdCopyBuffer2KHR)

/* ---- between buffers and images */

/* One side of a copy: the buffer, and how the copy uses it. */
struct image_copy {
    VkImage image;
    VkBuffer buffer;
    enum access_kind kind;
    enum hazard_role role;
};

static uint64_t blocks(uint32_t texels, uint32_t block)
{
    return ((uint64_t)texels + block - 1) / block;
}

/* Adds the first and the last row if there are bytes between rows. The rest of the copy is then not
 * recorded. */
static void add_rows(struct hazard_recording *recording, const struct image_copy *copy,
                     const VkBufferImageCopy *region, const struct format_block *block)
{
    const VkExtent3D *extent = &region->imageExtent;
    uint32_t row_texels = region->bufferRowLength ? region->bufferRowLength : extent->width;
    uint32_t column_texels = region->bufferImageHeight ? region->bufferImageHeight : extent->height;
    uint64_t row = blocks(extent->width, block->width) * block->size;
    uint64_t rows = blocks(extent->height, block->height);
    uint64_t row_pitch = blocks(row_texels, block->width) * block->size;
    uint64_t slice_pitch = blocks(column_texels, block->height) * row_pitch;
    uint64_t slices = (uint64_t)extent->depth * region->imageSubresource.layerCount;
    if (!row || !rows || !slices)
        return;
    uint64_t last = (slices - 1) * slice_pitch + (rows - 1) * row_pitch;
    if (row == row_pitch && (slices == 1 || rows * row_pitch == slice_pitch)) {
        hazard_recording_add_buffer(recording, copy->kind, copy->role, copy->buffer,
                                    region->bufferOffset, last + row);
        return;
    }
    hazard_recording_add_buffer(recording, copy->kind, copy->role, copy->buffer,
                                region->bufferOffset, row);
    if (last)
        hazard_recording_add_buffer(recording, copy->kind, copy->role, copy->buffer,
                                    region->bufferOffset + last, row);
}

/* Other aspects, and planes, have blocks of other sizes. */
static void add_region(struct hazard_recording *recording, const struct image_copy *copy,
                       const VkBufferImageCopy *region)
{
    struct format_block block;
    if (region->imageSubresource.aspectMask == VK_IMAGE_ASPECT_COLOR_BIT &&
        region->imageSubresource.layerCount != VK_REMAINING_ARRAY_LAYERS &&
        format_color_block(hazard_objects_format(recording->device->hazard_objects, copy->image),
                           &block))
        add_rows(recording, copy, region, &block);
}

static void add_image_copy(VkCommandBuffer handle, const char *name, const struct image_copy *copy,
                           uint32_t count, const VkBufferImageCopy *regions)
{
    struct hazard_recording recording;
    if (!hazard_recording_begin(&recording, handle, name))
        return;
    for (uint32_t i = 0; i < count; i++)
        add_region(&recording, copy, &regions[i]);
}

static void add_image_copy_2(VkCommandBuffer handle, const char *name,
                             const struct image_copy *copy, uint32_t count,
                             const VkBufferImageCopy2 *regions)
{
    struct hazard_recording recording;
    if (!hazard_recording_begin(&recording, handle, name))
        return;
    for (uint32_t i = 0; i < count; i++)
        add_region(&recording, copy,
                   &(VkBufferImageCopy){regions[i].bufferOffset, regions[i].bufferRowLength,
                                        regions[i].bufferImageHeight, regions[i].imageSubresource,
                                        regions[i].imageOffset, regions[i].imageExtent});
}

VKAPI_ATTR void VKAPI_CALL hazards_CmdCopyImageToBuffer(VkCommandBuffer commandBuffer,
                                                        VkImage srcImage,
                                                        VkImageLayout srcImageLayout,
                                                        VkBuffer dstBuffer, uint32_t regionCount,
                                                        const VkBufferImageCopy *pRegions)
{
    struct layer_device *device = layer_find_recording_device(commandBuffer);
    const struct image_copy copy = {srcImage, dstBuffer, ACCESS_TRANSFER_WRITE, HAZARD_DST};
    if (!device)
        return;
    add_image_copy(commandBuffer, "vkCmdCopyImageToBuffer", &copy, regionCount, pRegions);
    device->vk.CmdCopyImageToBuffer(commandBuffer, srcImage, srcImageLayout, dstBuffer, regionCount,
                                    pRegions);
}

VKAPI_ATTR void VKAPI_CALL hazards_CmdCopyBufferToImage(VkCommandBuffer commandBuffer,
                                                        VkBuffer srcBuffer, VkImage dstImage,
                                                        VkImageLayout dstImageLayout,
                                                        uint32_t regionCount,
                                                        const VkBufferImageCopy *pRegions)
{
    struct layer_device *device = layer_find_recording_device(commandBuffer);
    const struct image_copy copy = {dstImage, srcBuffer, ACCESS_TRANSFER_READ, HAZARD_SRC};
    if (!device)
        return;
    add_image_copy(commandBuffer, "vkCmdCopyBufferToImage", &copy, regionCount, pRegions);
    device->vk.CmdCopyBufferToImage(commandBuffer, srcBuffer, dstImage, dstImageLayout, regionCount,
                                    pRegions);
}

#define DEFINE_IMAGE_COPY_2(name, info_type, image, buffer, kind, role)                            \
    VKAPI_ATTR void VKAPI_CALL hazards_##name(VkCommandBuffer commandBuffer,                       \
                                              const info_type *pInfo)                              \
    {                                                                                              \
        struct layer_device *device = layer_find_recording_device(commandBuffer);                  \
        if (!device)                                                                               \
            return;                                                                                \
        const struct image_copy copy = {pInfo->image, pInfo->buffer, kind, role};                  \
        add_image_copy_2(commandBuffer, "vk" #name, &copy, pInfo->regionCount, pInfo->pRegions);   \
        device->vk.name(commandBuffer, pInfo);                                                     \
    }

#define TO_BUFFER VkCopyImageToBufferInfo2, srcImage, dstBuffer, ACCESS_TRANSFER_WRITE, HAZARD_DST
#define TO_IMAGE VkCopyBufferToImageInfo2, dstImage, srcBuffer, ACCESS_TRANSFER_READ, HAZARD_SRC
#define DEFINE_IMAGE_COPY(name, side) DEFINE_IMAGE_COPY_2(name, side)
DEFINE_IMAGE_COPY(CmdCopyImageToBuffer2, TO_BUFFER)
DEFINE_IMAGE_COPY(CmdCopyImageToBuffer2KHR, TO_BUFFER)
DEFINE_IMAGE_COPY(CmdCopyBufferToImage2, TO_IMAGE)
DEFINE_IMAGE_COPY(CmdCopyBufferToImage2KHR, TO_IMAGE)

/* ---- fills and updates */

/* A fill to the end of a buffer writes whole words only. */
static VkDeviceSize filled_size(const struct hazard_recording *recording, VkBuffer buffer,
                                VkDeviceSize offset, VkDeviceSize size)
{
    struct memory_bytes bytes;
    if (size != VK_WHOLE_SIZE)
        return size;
    if (!resources_find_buffer_bytes(recording->device->resources, buffer, &bytes) ||
        offset >= bytes.size)
        return 0;
    return (bytes.size - offset) / 4 * 4;
}

VKAPI_ATTR void VKAPI_CALL hazards_CmdFillBuffer(VkCommandBuffer commandBuffer, VkBuffer dstBuffer,
                                                 VkDeviceSize dstOffset, VkDeviceSize size,
                                                 uint32_t data)
{
    struct layer_device *device = layer_find_recording_device(commandBuffer);
    struct hazard_recording recording;
    if (!device)
        return;
    if (hazard_recording_begin(&recording, commandBuffer, "vkCmdFillBuffer"))
        hazard_recording_add_buffer(&recording, ACCESS_FILL_WRITE, HAZARD_DST, dstBuffer, dstOffset,
                                    filled_size(&recording, dstBuffer, dstOffset, size));
    device->vk.CmdFillBuffer(commandBuffer, dstBuffer, dstOffset, size, data);
}

VKAPI_ATTR void VKAPI_CALL hazards_CmdUpdateBuffer(VkCommandBuffer commandBuffer,
                                                   VkBuffer dstBuffer, VkDeviceSize dstOffset,
                                                   VkDeviceSize dataSize, const void *pData)
{
    struct layer_device *device = layer_find_recording_device(commandBuffer);
    struct hazard_recording recording;
    if (!device)
        return;
    if (hazard_recording_begin(&recording, commandBuffer, "vkCmdUpdateBuffer"))
        hazard_recording_add_buffer(&recording, ACCESS_FILL_WRITE, HAZARD_DST, dstBuffer, dstOffset,
                                    dataSize);
    device->vk.CmdUpdateBuffer(commandBuffer, dstBuffer, dstOffset, dataSize, pData);
}

/* ---- markers (VK_AMD_buffer_marker) */

static void add_marker(VkCommandBuffer handle, const char *name, VkBuffer dst, VkDeviceSize offset)
{
    struct hazard_recording recording;
    if (hazard_recording_begin(&recording, handle, name))
        hazard_recording_add_buffer(&recording, ACCESS_MARKER_WRITE, HAZARD_DST, dst, offset,
                                    sizeof(uint32_t));
}

VKAPI_ATTR void VKAPI_CALL hazards_CmdWriteBufferMarkerAMD(VkCommandBuffer commandBuffer,
                                                           VkPipelineStageFlagBits pipelineStage,
                                                           VkBuffer dstBuffer,
                                                           VkDeviceSize dstOffset, uint32_t marker)
{
    struct layer_device *device = layer_find_recording_device(commandBuffer);
    if (!device)
        return;
    add_marker(commandBuffer, "vkCmdWriteBufferMarkerAMD", dstBuffer, dstOffset);
    device->vk.CmdWriteBufferMarkerAMD(commandBuffer, pipelineStage, dstBuffer, dstOffset, marker);
}

VKAPI_ATTR void VKAPI_CALL hazards_CmdWriteBufferMarker2AMD(VkCommandBuffer commandBuffer,
                                                            VkPipelineStageFlags2 stage,
                                                            VkBuffer dstBuffer,
                                                            VkDeviceSize dstOffset, uint32_t marker)
{
    struct layer_device *device = layer_find_recording_device(commandBuffer);
    if (!device)
        return;
    add_marker(commandBuffer, "vkCmdWriteBufferMarker2AMD", dstBuffer, dstOffset);
    device->vk.CmdWriteBufferMarker2AMD(commandBuffer, stage, dstBuffer, dstOffset, marker);
}

/* ---- results of queries */

/* What is surely written of each query: with VK_QUERY_RESULT_WAIT_BIT its first word, and behind it
 * another value or the availability; otherwise only the availability, whose place is known if the
 * query has one value, as those of compacted sizes have. */
static void add_results(struct hazard_recording *recording, VkQueryPool pool, uint32_t count,
                        VkBuffer dst, VkDeviceSize offset, VkDeviceSize stride,
                        VkQueryResultFlags flags)
{
    VkDeviceSize word = flags & VK_QUERY_RESULT_64_BIT ? 8 : 4;
    bool has_availability = flags & VK_QUERY_RESULT_WITH_AVAILABILITY_BIT;
    VkDeviceSize size = has_availability ? 2 * word : word;
    struct query_pool known;
    if (!(flags & VK_QUERY_RESULT_WAIT_BIT)) {
        if (!has_availability || !query_pools_find(recording->device->query_pools, pool, &known))
            return;
        offset += word;
        size = word;
    }
    if (!count)
        return;
    if (stride == size || count == 1) {
        hazard_recording_add_buffer(recording, ACCESS_TRANSFER_WRITE, HAZARD_DST, dst, offset,
                                    (count - 1) * stride + size);
        return;
    }
    hazard_recording_add_buffer(recording, ACCESS_TRANSFER_WRITE, HAZARD_DST, dst, offset, size);
    hazard_recording_add_buffer(recording, ACCESS_TRANSFER_WRITE, HAZARD_DST, dst,
                                offset + (count - 1) * stride, size);
}

VKAPI_ATTR void VKAPI_CALL hazards_CmdCopyQueryPoolResults(
    VkCommandBuffer commandBuffer, VkQueryPool queryPool, uint32_t firstQuery, uint32_t queryCount,
    VkBuffer dstBuffer, VkDeviceSize dstOffset, VkDeviceSize stride, VkQueryResultFlags flags)
{
    struct layer_device *device = layer_find_recording_device(commandBuffer);
    struct hazard_recording recording;
    if (!device)
        return;
    if (hazard_recording_begin(&recording, commandBuffer, "vkCmdCopyQueryPoolResults"))
        add_results(&recording, queryPool, queryCount, dstBuffer, dstOffset, stride, flags);
    device->vk.CmdCopyQueryPoolResults(commandBuffer, queryPool, firstQuery, queryCount, dstBuffer,
                                       dstOffset, stride, flags);
}
