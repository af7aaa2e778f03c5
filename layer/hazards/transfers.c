/* SPDX-License-Identifier: Apache-2.0 */
/* Records copies, fills and updates of buffers, and markers. */
#include "layer/hazards/recording.h"
#include "observers.h"

/* Memory that a command uses: of a buffer or, without one, behind an address. */
struct place {
    enum access_kind kind;
    enum hazard_role role;
    VkBuffer buffer;
    VkDeviceAddress address;
};

static void add_at(struct hazard_recording *recording, const struct place *place,
                   VkDeviceSize offset, VkDeviceSize size)
{
    struct address_facts facts;
    const struct hazard_use use = {.kind = place->kind, .role = place->role};
    if (place->buffer) {
        hazards_access_buffer(recording, place->kind, place->role, place->buffer, offset, size);
        return;
    }
    resources_look_up_address(recording->device->resources, place->address + offset, &facts);
    hazard_recording_add_address(recording, &use, &facts, 0, size);
}

/* ---- between buffers */

void hazards_copy_buffer(struct hazard_recording *recording, const VkCopyBufferInfo2 *info)
{
    for (uint32_t i = 0; i < info->regionCount; i++) {
        const VkBufferCopy2 *region = &info->pRegions[i];
        hazards_access_buffer(recording, ACCESS_TRANSFER_READ, HAZARD_SRC, info->srcBuffer,
                              region->srcOffset, region->size);
        hazards_access_buffer(recording, ACCESS_TRANSFER_WRITE, HAZARD_DST, info->dstBuffer,
                              region->dstOffset, region->size);
    }
}

/* ---- between memory and images */

/* A copy between an image and memory: how it uses the memory, which is that of a buffer, or behind
 * an address. */
struct image_copy {
    VkImage image;
    struct place memory;
};

static uint64_t blocks(uint32_t texels, uint32_t block)
{
    return ((uint64_t)texels + block - 1) / block;
}

/* Adds the first and the last row if there are bytes between rows. The rest of the copy is then not
 * recorded. */
static void add_rows(struct hazard_recording *recording, const struct image_copy *copy,
                     const VkBufferImageCopy2 *region, const struct format_block *block)
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
        add_at(recording, &copy->memory, region->bufferOffset, last + row);
        return;
    }
    add_at(recording, &copy->memory, region->bufferOffset, row);
    if (last)
        add_at(recording, &copy->memory, region->bufferOffset + last, row);
}

/* Other aspects, and planes, have blocks of other sizes. */
static void add_region(struct hazard_recording *recording, const struct image_copy *copy,
                       const VkBufferImageCopy2 *region)
{
    struct format_block block;
    if (region->imageSubresource.aspectMask == VK_IMAGE_ASPECT_COLOR_BIT &&
        region->imageSubresource.layerCount != VK_REMAINING_ARRAY_LAYERS &&
        format_color_block(hazard_objects_format(recording->device->hazard_objects, copy->image),
                           &block))
        add_rows(recording, copy, region, &block);
}

static struct image_copy to_buffer(VkImage src, VkBuffer dst)
{
    return (struct image_copy){src, {ACCESS_TRANSFER_WRITE, HAZARD_DST, .buffer = dst}};
}

static struct image_copy to_image(VkBuffer src, VkImage dst)
{
    return (struct image_copy){dst, {ACCESS_TRANSFER_READ, HAZARD_SRC, .buffer = src}};
}

void hazards_copy_to_buffer(struct hazard_recording *recording,
                            const VkCopyImageToBufferInfo2 *info)
{
    const struct image_copy copy = to_buffer(info->srcImage, info->dstBuffer);
    for (uint32_t i = 0; i < info->regionCount; i++)
        add_region(recording, &copy, &info->pRegions[i]);
    hazards_write_unfollowed(recording); /* the bytes added are not all that are written */
}

void hazards_copy_to_image(struct hazard_recording *recording, const VkCopyBufferToImageInfo2 *info)
{
    const struct image_copy copy = to_image(info->srcBuffer, info->dstImage);
    for (uint32_t i = 0; i < info->regionCount; i++)
        add_region(recording, &copy, &info->pRegions[i]);
}

static void add_addressed_copy(struct hazard_recording *recording, struct image_copy *copy,
                               const VkCopyDeviceMemoryImageInfoKHR *info)
{
    for (uint32_t i = 0; i < info->regionCount; i++) {
        const VkDeviceMemoryImageCopyKHR *region = &info->pRegions[i];
        copy->memory.address = region->addressRange.address;
        add_region(recording, copy,
                   &(VkBufferImageCopy2){.bufferRowLength = region->addressRowLength,
                                         .bufferImageHeight = region->addressImageHeight,
                                         .imageSubresource = region->imageSubresource,
                                         .imageOffset = region->imageOffset,
                                         .imageExtent = region->imageExtent});
    }
}

void hazards_copy_image_to_memory(struct hazard_recording *recording,
                                  const VkCopyDeviceMemoryImageInfoKHR *info)
{
    struct image_copy copy = to_buffer(info->image, VK_NULL_HANDLE);
    add_addressed_copy(recording, &copy, info);
    hazards_write_unfollowed(recording); /* the bytes added are not all that are written */
}

void hazards_copy_memory_to_image(struct hazard_recording *recording,
                                  const VkCopyDeviceMemoryImageInfoKHR *info)
{
    struct image_copy copy = to_image(VK_NULL_HANDLE, info->image);
    add_addressed_copy(recording, &copy, info);
}

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

void hazards_fill(struct hazard_recording *recording, VkBuffer dst, VkDeviceSize offset,
                  VkDeviceSize size)
{
    hazards_access_buffer(recording, ACCESS_FILL_WRITE, HAZARD_DST, dst, offset,
                          filled_size(recording, dst, offset, size));
}

/* ---- results of queries */

/* What is certainly written of each query: with VK_QUERY_RESULT_WAIT_BIT its first word, and behind
 * it another value or the availability; otherwise only the availability, whose place is known if
 * the query has one value, as those of compacted sizes have. */
static void add_results(struct hazard_recording *recording, VkQueryPool pool, uint32_t count,
                        const struct place *dst, VkDeviceSize offset, VkDeviceSize stride,
                        VkQueryResultFlags flags)
{
    VkDeviceSize word = flags & VK_QUERY_RESULT_64_BIT ? 8 : 4;
    bool has_availability = flags & VK_QUERY_RESULT_WITH_AVAILABILITY_BIT;
    VkDeviceSize size = has_availability ? 2 * word : word;
    struct query_pool known;
    hazards_write_unfollowed(recording); /* the bytes added are not all that are written */
    if (!(flags & VK_QUERY_RESULT_WAIT_BIT)) {
        if (!has_availability || !query_pools_find(recording->device->query_pools, pool, &known))
            return;
        offset += word;
        size = word;
    }
    if (!count)
        return;
    if (stride == size || count == 1) {
        add_at(recording, dst, offset, (count - 1) * stride + size);
        return;
    }
    add_at(recording, dst, offset, size);
    add_at(recording, dst, offset + (count - 1) * stride, size);
}

void hazards_copy_results(struct hazard_recording *recording, VkQueryPool pool, uint32_t count,
                          VkBuffer dst, VkDeviceSize offset, VkDeviceSize stride,
                          VkQueryResultFlags flags)
{
    const struct place place = {ACCESS_TRANSFER_WRITE, HAZARD_DST, .buffer = dst};
    add_results(recording, pool, count, &place, offset, stride, flags);
}

void hazards_copy_results_to_memory(struct hazard_recording *recording, VkQueryPool pool,
                                    uint32_t count, const VkStridedDeviceAddressRangeKHR *dst,
                                    VkQueryResultFlags flags)
{
    const struct place place = {ACCESS_TRANSFER_WRITE, HAZARD_DST, .address = dst->address};
    add_results(recording, pool, count, &place, 0, dst->stride, flags);
}

/* ---- by address (VK_KHR_device_address_commands) */

void hazards_access_address(struct hazard_recording *recording, enum access_kind kind,
                            enum hazard_role role, VkDeviceAddress address, VkDeviceSize size)
{
    add_at(recording, &(struct place){kind, role, .address = address}, 0, size);
}

void hazards_copy_memory(struct hazard_recording *recording, const VkCopyDeviceMemoryInfoKHR *info)
{
    for (uint32_t i = 0; i < info->regionCount; i++) {
        const VkDeviceMemoryCopyKHR *region = &info->pRegions[i];
        hazards_access_address(recording, ACCESS_TRANSFER_READ, HAZARD_SRC,
                               region->srcRange.address, region->srcRange.size);
        hazards_access_address(recording, ACCESS_TRANSFER_WRITE, HAZARD_DST,
                               region->dstRange.address, region->dstRange.size);
    }
}
