/* SPDX-License-Identifier: Apache-2.0 */
/* Copies of images and of results of queries, and commands that take addresses:
 *
 *     copy-image SRC > DST [row TEXELS] [height TEXELS] [layers COUNT | rest] [depth]
 *                              between an image and a buffer; `copy-image2`, `copy-image2KHR`: by
 *                              newer names
 *     results POOL > PLACE [from QUERY] [queries NUMBER] [stride BYTES] [narrow] [no-wait]
 *             [availability]
 *     memory copy PLACE > PLACE SIZE         memory marker PLACE
 *     memory fill PLACE SIZE                 memory update PLACE SIZE
 *     memory copy-image ...                  memory results ...
 *
 * `memory`: with VK_KHR_device_address_commands. */
#include "tests/player/play.h"

#include <stdlib.h>
#include <string.h>

static uint32_t number_of(const struct play *play, const char *word)
{
    PLAY_REQUIRE(play, word != NULL);
    return (uint32_t)strtoul(word, NULL, 0);
}

/* ---- images */

struct image_copy {
    VkImage image;
    const struct play_object *buffer;
    VkBufferImageCopy region;
    VkDeviceAddress address; /* of the region */
    bool is_to_image;
};

static struct image_copy read_image_copy(struct play *play, char **words)
{
    PLAY_REQUIRE(play, words[1] && play_is(words[2], ">") && words[3]);
    struct image_copy copy = {.is_to_image = words[3][0] == 'F'};
    VkBufferImageCopy *region = &copy.region;
    copy.image = play_object(play, words[copy.is_to_image ? 3 : 1])->image;
    copy.buffer = play_place(play, words[copy.is_to_image ? 1 : 3], &region->bufferOffset);
    copy.address = copy.buffer->buffer.address + region->bufferOffset;
    region->imageSubresource = (VkImageSubresourceLayers){VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
    region->imageExtent = (VkExtent3D){4, 4, 1};
    for (words += 4; *words; words++) {
        if (play_is(*words, "depth"))
            region->imageSubresource.aspectMask = VK_IMAGE_ASPECT_DEPTH_BIT;
        else if (play_is(*words, "row"))
            region->bufferRowLength = number_of(play, *++words);
        else if (play_is(*words, "height"))
            region->bufferImageHeight = number_of(play, *++words);
        else if (play_is(*words, "layers"))
            region->imageSubresource.layerCount =
                play_is(*++words, "rest") ? VK_REMAINING_ARRAY_LAYERS : number_of(play, *words);
        else
            play_fail(play, *words);
    }
    return copy;
}

static void copy_image_1(struct play *play, const struct image_copy *copy)
{
    const VkBuffer buffer = copy->buffer->buffer.handle;
    if (copy->is_to_image)
        play->vk.CmdCopyBufferToImage(play_commands(play), buffer, copy->image,
                                      VK_IMAGE_LAYOUT_GENERAL, 1, &copy->region);
    else
        play->vk.CmdCopyImageToBuffer(play_commands(play), copy->image, VK_IMAGE_LAYOUT_GENERAL,
                                      buffer, 1, &copy->region);
}

static void copy_image_2(struct play *play, const struct image_copy *copy, bool is_khr)
{
    const VkuDeviceDispatchTable *vk = &play->vk;
    const VkBufferImageCopy *from = &copy->region;
    const STRUCT(VkBufferImageCopy2, region, .bufferOffset = from->bufferOffset,
                 .bufferRowLength = from->bufferRowLength,
                 .bufferImageHeight = from->bufferImageHeight,
                 .imageSubresource = from->imageSubresource, .imageExtent = from->imageExtent);
    const STRUCT(VkCopyBufferToImageInfo2, in, .srcBuffer = copy->buffer->buffer.handle,
                 .dstImage = copy->image, .dstImageLayout = VK_IMAGE_LAYOUT_GENERAL,
                 .regionCount = 1, .pRegions = &region);
    const STRUCT(VkCopyImageToBufferInfo2, out, .srcImage = copy->image,
                 .srcImageLayout = VK_IMAGE_LAYOUT_GENERAL,
                 .dstBuffer = copy->buffer->buffer.handle, .regionCount = 1, .pRegions = &region);
    if (copy->is_to_image)
        (is_khr ? vk->CmdCopyBufferToImage2KHR : vk->CmdCopyBufferToImage2)(play_commands(play),
                                                                            &in);
    else
        (is_khr ? vk->CmdCopyImageToBuffer2KHR : vk->CmdCopyImageToBuffer2)(play_commands(play),
                                                                            &out);
}

static void copy_image_by_address(struct play *play, const struct image_copy *copy)
{
    const VkBufferImageCopy *from = &copy->region;
    const STRUCT(VkDeviceMemoryImageCopyKHR, region, .addressRange = {copy->address, 256},
                 .addressRowLength = from->bufferRowLength,
                 .addressImageHeight = from->bufferImageHeight,
                 .imageSubresource = from->imageSubresource, .imageLayout = VK_IMAGE_LAYOUT_GENERAL,
                 .imageExtent = from->imageExtent);
    const STRUCT(VkCopyDeviceMemoryImageInfoKHR, info, .image = copy->image, .regionCount = 1,
                 .pRegions = &region);
    (copy->is_to_image ? play->vk.CmdCopyMemoryToImageKHR
                       : play->vk.CmdCopyImageToMemoryKHR)(play_commands(play), &info);
}

static void copy_image(struct play *play, char **words, bool is_by_address)
{
    const struct image_copy copy = read_image_copy(play, words);
    if (is_by_address)
        copy_image_by_address(play, &copy);
    else if (play_is(words[0], "copy-image"))
        copy_image_1(play, &copy);
    else
        copy_image_2(play, &copy, play_is(words[0], "copy-image2KHR"));
}

/* ---- results of queries */

static void copy_results(struct play *play, char **words, bool is_by_address)
{
    VkDeviceSize offset, stride = sizeof(uint64_t);
    VkQueryResultFlags flags = VK_QUERY_RESULT_64_BIT | VK_QUERY_RESULT_WAIT_BIT;
    uint32_t first = 0, count = 1;
    PLAY_REQUIRE(play, play_is(words[2], ">"));
    const VkQueryPool pool = play_object(play, words[1])->queries;
    const struct play_object *to = play_place(play, words[3], &offset);
    for (words += 4; *words; words++) {
        if (play_is(*words, "from"))
            first = number_of(play, *++words);
        else if (play_is(*words, "queries"))
            count = number_of(play, *++words);
        else if (play_is(*words, "stride"))
            stride = number_of(play, *++words);
        else if (play_is(*words, "narrow"))
            flags &= ~(VkFlags)VK_QUERY_RESULT_64_BIT;
        else if (play_is(*words, "no-wait"))
            flags &= ~(VkFlags)VK_QUERY_RESULT_WAIT_BIT;
        else if (play_is(*words, "availability"))
            flags |= VK_QUERY_RESULT_WITH_AVAILABILITY_BIT;
        else
            play_fail(play, *words);
    }
    const VkStridedDeviceAddressRangeKHR range = {to->buffer.address + offset, 256, stride};
    if (is_by_address)
        play->vk.CmdCopyQueryPoolResultsToMemoryKHR(play_commands(play), pool, first, count, &range,
                                                    0, flags);
    else
        play->vk.CmdCopyQueryPoolResults(play_commands(play), pool, first, count, to->buffer.handle,
                                         offset, stride, flags);
}

/* ---- by address */

static void copy_memory(struct play *play, char **words)
{
    PLAY_REQUIRE(play, play_is(words[2], ">"));
    const VkDeviceSize size = number_of(play, words[4]);
    const STRUCT(VkDeviceMemoryCopyKHR, region, .srcRange = {play_address(play, words[1]), size},
                 .dstRange = {play_address(play, words[3]), size});
    const STRUCT(VkCopyDeviceMemoryInfoKHR, info, .regionCount = 1, .pRegions = &region);
    play->vk.CmdCopyMemoryKHR(play_commands(play), &info);
}

static void write_memory(struct play *play, char **words)
{
    static const unsigned char zeros[256];
    const bool is_marker = play_is(words[0], "marker");
    const VkDeviceAddressRangeKHR range = {play_address(play, words[1]),
                                           is_marker ? 4 : number_of(play, words[2])};
    const STRUCT(VkMemoryMarkerInfoAMD, marker, .stage = VK_PIPELINE_STAGE_2_COPY_BIT,
                 .dstRange = range);
    if (is_marker)
        play->vk.CmdWriteMarkerToMemoryAMD(play_commands(play), &marker);
    else if (play_is(words[0], "fill"))
        play->vk.CmdFillMemoryKHR(play_commands(play), &range, 0, 0);
    else
        play->vk.CmdUpdateMemoryKHR(play_commands(play), &range, 0, range.size, zeros);
}

bool play_transfer(struct play *play, char **words)
{
    const bool is_by_address = play_is(words[0], "memory");
    words += is_by_address;
    PLAY_REQUIRE(play, words[0] != NULL);
    if (strncmp(words[0], "copy-image", 10) == 0)
        copy_image(play, words, is_by_address);
    else if (play_is(words[0], "results"))
        copy_results(play, words, is_by_address);
    else if (is_by_address && play_is(words[0], "copy"))
        copy_memory(play, words);
    else if (is_by_address)
        write_memory(play, words);
    else
        return false;
    return true;
}
