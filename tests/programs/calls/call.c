/* SPDX-License-Identifier: Apache-2.0 */
/* The call as a whole: features, handles, pointers, the state of the command buffer, limits. */
#include <vk_video/vulkan_video_codec_h264std_decode.h>

#include "tests/player/calls/case.h"

/* Looks like a handle of this device to the loader, and is none. */
static void record_on_a_forgery(struct scene *scene)
{
    static void *forged[64];
    forged[0] = *(void **)scene->command_buffer;
    scene->command_buffer = (VkCommandBuffer)(void *)forged;
}

SCENE_CREATES(create_video_session, VideoSessionKHR, VkVideoSessionKHR, VkVideoSessionCreateInfoKHR)

static VkVideoSessionKHR make_video_session(struct scene *scene, uint32_t family)
{
    const STRUCT(VkVideoDecodeH264ProfileInfoKHR, h264,
                 .stdProfileIdc = STD_VIDEO_H264_PROFILE_IDC_BASELINE);
    const STRUCT(VkVideoProfileInfoKHR, profile, .pNext = &h264,
                 .videoCodecOperation = VK_VIDEO_CODEC_OPERATION_DECODE_H264_BIT_KHR,
                 .chromaSubsampling = VK_VIDEO_CHROMA_SUBSAMPLING_420_BIT_KHR,
                 .lumaBitDepth = VK_VIDEO_COMPONENT_BIT_DEPTH_8_BIT_KHR,
                 .chromaBitDepth = VK_VIDEO_COMPONENT_BIT_DEPTH_8_BIT_KHR);
    const VkExtensionProperties header = {
        .extensionName = VK_STD_VULKAN_VIDEO_CODEC_H264_DECODE_EXTENSION_NAME,
        .specVersion = VK_STD_VULKAN_VIDEO_CODEC_H264_DECODE_SPEC_VERSION,
    };
    const STRUCT(VkVideoSessionCreateInfoKHR, create_info, .queueFamilyIndex = family,
                 .pVideoProfile = &profile, .pictureFormat = VK_FORMAT_G8_B8R8_2PLANE_420_UNORM,
                 .maxCodedExtent = {64, 64},
                 .referencePictureFormat = VK_FORMAT_G8_B8R8_2PLANE_420_UNORM, .maxDpbSlots = 1,
                 .maxActiveReferencePictures = 1, .pStdHeaderVersion = &header);
    return create_video_session(scene, &create_info);
}

static void begin_video_coding(struct scene *scene)
{
    const uint32_t family = fixture_find_family(
        scene->fixture, VK_QUEUE_VIDEO_DECODE_BIT_KHR | VK_QUEUE_COMPUTE_BIT, 0);
    scene_record_in_family(scene, family, 0);
    if (scene->skip != NULL)
        return;
    const STRUCT(VkVideoBeginCodingInfoKHR, begin_info,
                 .videoSession = make_video_session(scene, family));
    scene->vk->CmdBeginVideoCodingKHR(scene->command_buffer, &begin_info);
}

static uint32_t compute_family(const struct scene *scene)
{
    return fixture_find_family(scene->fixture, VK_QUEUE_COMPUTE_BIT | VK_QUEUE_GRAPHICS_BIT, 0);
}

static VkCommandPool record_in_new_pool(struct scene *scene)
{
    const VkCommandPool pool = scene_pool(scene, compute_family(scene), 0);
    scene->command_buffer =
        scene_allocate_command_buffer(scene, pool, VK_COMMAND_BUFFER_LEVEL_PRIMARY);
    scene_begin(scene, scene->command_buffer, 0);
    return pool;
}

static VkCommandBuffer record_secondary(struct scene *scene)
{
    const VkCommandBuffer secondary = scene_allocate_command_buffer(
        scene, scene_pool(scene, compute_family(scene), 0), VK_COMMAND_BUFFER_LEVEL_SECONDARY);
    scene_begin(scene, secondary, 0);
    return secondary;
}

#include "call.inc"
