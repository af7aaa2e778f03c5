/* SPDX-License-Identifier: Apache-2.0 */
/* The call as a whole: features, the command buffer's handle and pool, video coding scopes. */
#include <vk_video/vulkan_video_codec_h264std_decode.h>

#include "case.h"

/* ---- features ---- */

static const struct setup with_defaults = {0};

/* ---- command buffer handles ---- */

static void record_on_a_queue(struct scene *scene)
{
    VkQueue queue;
    scene->vk->GetDeviceQueue(scene->fixture->device, 0, 0, &queue);
    scene->command_buffer = (VkCommandBuffer)(void *)queue;
}

static void record_on_the_device(struct scene *scene)
{
    scene->command_buffer = (VkCommandBuffer)(void *)scene->fixture->device;
}

/* Looks like a handle of this device to the loader, and is none. */
static void record_on_a_forgery(struct scene *scene)
{
    static void *forged[64];
    forged[0] = *(void **)scene->command_buffer;
    scene->command_buffer = (VkCommandBuffer)(void *)forged;
}

static void record_on_a_secondary(struct scene *scene)
{
    const uint32_t family = fixture_find_family(scene->fixture, VK_QUEUE_COMPUTE_BIT, 0);
    scene->command_buffer = scene_allocate_command_buffer(scene, scene_pool(scene, family, 0),
                                                          VK_COMMAND_BUFFER_LEVEL_SECONDARY);
    scene_begin(scene, scene->command_buffer, 0);
}

/* ---- queue families ---- */

static void record_in_family(struct scene *scene, VkQueueFlags with, VkDeviceSize without)
{
    scene_record_in_family(scene, fixture_find_family(scene->fixture, with, (VkQueueFlags)without),
                           0);
}

static void make_first_family_graphics_only(struct null_driver_config *config)
{
    config->queue_families[2].queueFlags = VK_QUEUE_GRAPHICS_BIT | VK_QUEUE_TRANSFER_BIT;
}

/* ---- protected ---- */

static void record_in_protected_family(struct scene *scene, VkCommandPoolCreateFlags flags)
{
    const VkQueueFlags with = VK_QUEUE_PROTECTED_BIT | VK_QUEUE_COMPUTE_BIT;
    scene_record_in_family(scene, fixture_find_family(scene->fixture, with, 0), flags);
}

/* ---- video ---- */

static void add_compute_to_video(struct null_driver_config *config)
{
    for (uint32_t i = 0; i < config->queue_family_count; i++)
        if ((config->queue_families[i].queueFlags & VK_QUEUE_VIDEO_DECODE_BIT_KHR) != 0)
            config->queue_families[i].queueFlags |= VK_QUEUE_COMPUTE_BIT;
}

SCENE_CREATES(create_video_session, VideoSessionKHR, VkVideoSessionKHR, VkVideoSessionCreateInfoKHR)

static VkVideoSessionKHR make_video_session(struct scene *scene, uint32_t family)
{
    const VkVideoDecodeH264ProfileInfoKHR h264 = {
        .sType = VK_STRUCTURE_TYPE_VIDEO_DECODE_H264_PROFILE_INFO_KHR,
        .stdProfileIdc = STD_VIDEO_H264_PROFILE_IDC_BASELINE,
    };
    const VkVideoProfileInfoKHR profile = {
        .sType = VK_STRUCTURE_TYPE_VIDEO_PROFILE_INFO_KHR,
        .pNext = &h264,
        .videoCodecOperation = VK_VIDEO_CODEC_OPERATION_DECODE_H264_BIT_KHR,
        .chromaSubsampling = VK_VIDEO_CHROMA_SUBSAMPLING_420_BIT_KHR,
        .lumaBitDepth = VK_VIDEO_COMPONENT_BIT_DEPTH_8_BIT_KHR,
        .chromaBitDepth = VK_VIDEO_COMPONENT_BIT_DEPTH_8_BIT_KHR,
    };
    const VkExtensionProperties header = {
        .extensionName = VK_STD_VULKAN_VIDEO_CODEC_H264_DECODE_EXTENSION_NAME,
        .specVersion = VK_STD_VULKAN_VIDEO_CODEC_H264_DECODE_SPEC_VERSION,
    };
    const VkVideoSessionCreateInfoKHR create_info = {
        .sType = VK_STRUCTURE_TYPE_VIDEO_SESSION_CREATE_INFO_KHR,
        .queueFamilyIndex = family,
        .pVideoProfile = &profile,
        .pictureFormat = VK_FORMAT_G8_B8R8_2PLANE_420_UNORM,
        .maxCodedExtent = {64, 64},
        .referencePictureFormat = VK_FORMAT_G8_B8R8_2PLANE_420_UNORM,
        .maxDpbSlots = 1,
        .maxActiveReferencePictures = 1,
        .pStdHeaderVersion = &header,
    };
    return create_video_session(scene, &create_info);
}

static void begin_video_coding(struct scene *scene)
{
    const uint32_t family = fixture_find_family(
        scene->fixture, VK_QUEUE_VIDEO_DECODE_BIT_KHR | VK_QUEUE_COMPUTE_BIT, 0);
    scene_record_in_family(scene, family, 0);
    if (scene->skip != NULL)
        return;
    const VkVideoBeginCodingInfoKHR begin_info = {
        .sType = VK_STRUCTURE_TYPE_VIDEO_BEGIN_CODING_INFO_KHR,
        .videoSession = make_video_session(scene, family),
    };
    scene->vk->CmdBeginVideoCodingKHR(scene->command_buffer, &begin_info);
}

static void end_video_coding(struct scene *scene)
{
    const VkVideoEndCodingInfoKHR end_info = {.sType = VK_STRUCTURE_TYPE_VIDEO_END_CODING_INFO_KHR};
    begin_video_coding(scene);
    scene->vk->CmdEndVideoCodingKHR(scene->command_buffer, &end_info);
}

static void begin_again_in_video_coding(struct scene *scene)
{
    begin_video_coding(scene);
    scene->vk->ResetCommandBuffer(scene->command_buffer, 0);
    scene_begin(scene, scene->command_buffer, 0);
}

static const struct test_case cases[] = {
    CASE("feature_acceleration_structure_off", RULE(acceleration_structure_feature_is_enabled),
         SETUP(.disable = DISABLE_ACCELERATION_STRUCTURE), .twin_setup = &with_defaults),
    CASE("feature_acceleration_structure_off_in_features2",
         RULE(acceleration_structure_feature_is_enabled),
         SETUP(.disable = DISABLE_ACCELERATION_STRUCTURE, .route = ROUTE_FEATURES2),
         TWIN_SETUP(.route = ROUTE_FEATURES2)),
    CASE("feature_indirect_build_off", RULE(indirect_build_feature_is_enabled),
         SETUP(.disable = DISABLE_INDIRECT_BUILD), .twin_setup = &with_defaults),
    /* Without the build whose source can't be built either. */
    CASE("feature_host_commands_off", RULE(host_commands_feature_is_enabled),
         SETUP(.disable = DISABLE_HOST_COMMANDS), .twin_setup = &with_defaults,
         EDITS(SET(info_count, UPDATE))),
    CASE("feature_host_commands_off_is_no_matter_to_devices",
         RULE(host_commands_feature_is_enabled), .silent = true, .commands = ON_COMMAND_BUFFERS,
         SETUP(.disable = DISABLE_HOST_COMMANDS)),
    CASE("feature_indirect_build_off_is_no_matter_to_direct_builds",
         RULE(indirect_build_feature_is_enabled), .silent = true, .commands = ON_WITH_RANGES,
         SETUP(.disable = DISABLE_INDIRECT_BUILD)),
    CASE("command_buffer_is_a_queue", RULE(command_buffer_is_valid), .mutate = record_on_a_queue,
         TWIN_EDITS(CALL_FOR(record_in_family, VK_QUEUE_COMPUTE_BIT, 0))),
    CASE("command_buffer_is_the_device", RULE(command_buffer_is_valid),
         .mutate = record_on_the_device, .mutate_twin = record_on_a_secondary),
    CASE("command_buffer_is_a_forgery", RULE(command_buffer_is_valid),
         .mutate = record_on_a_forgery),
    CASE("pool_without_compute", RULE(command_pool_supports_compute),
         EDITS(CALL_FOR(record_in_family, VK_QUEUE_TRANSFER_BIT,
                        VK_QUEUE_COMPUTE_BIT | VK_QUEUE_VIDEO_DECODE_BIT_KHR)),
         TWIN_EDITS(CALL_FOR(record_in_family, VK_QUEUE_COMPUTE_BIT, VK_QUEUE_GRAPHICS_BIT)),
         .needs_null_driver = true, .forwards = true),
    CASE("pool_with_graphics_but_no_compute", RULE(command_pool_supports_compute),
         SETUP(.configure = make_first_family_graphics_only),
         EDITS(CALL_FOR(record_in_family, VK_QUEUE_GRAPHICS_BIT, VK_QUEUE_COMPUTE_BIT))),
    CASE("protected_command_buffer", RULE(command_buffer_is_not_protected),
         SETUP(.enable = ENABLE_PROTECTED),
         EITHER_CALL(record_in_protected_family, VK_COMMAND_POOL_CREATE_PROTECTED_BIT, 0)),
    CASE("inside_video_coding", RULE(build_is_outside_video_coding),
         SETUP(.configure = add_compute_to_video, .enable = ENABLE_VIDEO),
         .mutate = begin_video_coding, .mutate_twin = end_video_coding),
    CASE("video_coding_ends_with_the_recording", RULE(build_is_outside_video_coding),
         .silent = true, SETUP(.configure = add_compute_to_video, .enable = ENABLE_VIDEO),
         .mutate = begin_again_in_video_coding),
    CASE("info_count_0", RULE(info_count_is_positive), EITHER_SET(info_count, 0, 1)),
    CASE("info_count_0_excuses_all_pointers", RULE(info_count_is_positive),
         EDITS(SET(info_count, 0), SET(infos_argument, 0), SET(ranges_argument, 0),
               SET(counts_argument, 0))),
};

CASE_LIST(cases_call, cases);
