/* SPDX-License-Identifier: Apache-2.0 */
/* Barriers, events and render passes of cases:
 *
 *     barrier DEPENDENCY [, DEPENDENCY]...     vkCmdPipelineBarrier2
 *     barrier1 DEPENDENCY [, DEPENDENCY]...    vkCmdPipelineBarrier
 *     set EVENT DEPENDENCY...                  wait EVENT DEPENDENCY...       reset EVENT STAGES
 *     wait EVENT DEPENDENCY... and EVENT DEPENDENCY...       for several events
 *     set1 EVENT STAGES                        wait1 EVENT DEPENDENCY...      reset1 EVENT STAGES
 *     setKHR, waitKHR, resetKHR      set, wait and reset by their older names
 *     host set EVENT                 host reset EVENT
 *     image NAME               makes its layout GENERAL, and waits
 *     render DEPENDENCY [, DEPENDENCY]...      an empty render pass; its dependencies are those
 *                        from and to what is outside, and one between two subpasses; the fourth is
 *                        a barrier in the second subpass. More are all from what is outside
 *     timestamp STAGE [POOL]   timestamp2 STAGE [POOL]      of query 0; without a pool: only null
 *     below ...                what reached the null driver: below.c
 *     render2 ..., render2KHR ...              the same by newer names; the masks are those of
 *                        VkMemoryBarrier2 in the chain, but `render2 own ...` has none
 *
 * DEPENDENCY: [COUNT] (so many times) [on PLACE [SIZE]] [image NAME] [from FAMILY to FAMILY]
 * [src3 | dst3] STAGES[:ACCESSES] > STAGES[:ACCESSES]. `src3`, `dst3`: with a flag of
 * VkMemoryBarrierAccessFlags3KHR. A dependency of an extension begins with `at PLACE SIZE` (an
 * address range), `tensor`, `tensors` (in a list), or `unknown`. STAGES and ACCESSES are words of
 * the tables below, with | between them. */
#include "tests/player/commands/sync.h"

#include <stdlib.h>
#include <string.h>

/* ---- words */

static const struct play_word stages[] = {
    {"none", 0},
    {"top", VK_PIPELINE_STAGE_2_TOP_OF_PIPE_BIT},
    {"bottom", VK_PIPELINE_STAGE_2_BOTTOM_OF_PIPE_BIT},
    {"all", VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT},
    {"graphics", VK_PIPELINE_STAGE_2_ALL_GRAPHICS_BIT},
    {"host", VK_PIPELINE_STAGE_2_HOST_BIT},
    {"build", VK_PIPELINE_STAGE_2_ACCELERATION_STRUCTURE_BUILD_BIT_KHR},
    {"accel_copy", VK_PIPELINE_STAGE_2_ACCELERATION_STRUCTURE_COPY_BIT_KHR},
    {"micromap", VK_PIPELINE_STAGE_2_MICROMAP_BUILD_BIT_EXT},
    {"transfer", VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT},
    {"copy", VK_PIPELINE_STAGE_2_COPY_BIT},
    {"clear", VK_PIPELINE_STAGE_2_CLEAR_BIT},
    {"blit", VK_PIPELINE_STAGE_2_BLIT_BIT},
    {"indirect", VK_PIPELINE_STAGE_2_DRAW_INDIRECT_BIT},
    {"compute", VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT},
    {"rays", VK_PIPELINE_STAGE_2_RAY_TRACING_SHADER_BIT_KHR},
    {"vertex_input", VK_PIPELINE_STAGE_2_VERTEX_INPUT_BIT},
    {"vertex", VK_PIPELINE_STAGE_2_VERTEX_SHADER_BIT},
    {"fragment", VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT},
};

static const struct play_word accesses[] = {
    {"none", 0},
    {"accel_read", VK_ACCESS_2_ACCELERATION_STRUCTURE_READ_BIT_KHR},
    {"accel_write", VK_ACCESS_2_ACCELERATION_STRUCTURE_WRITE_BIT_KHR},
    {"shader_read", VK_ACCESS_2_SHADER_READ_BIT},
    {"shader_write", VK_ACCESS_2_SHADER_WRITE_BIT},
    {"storage_read", VK_ACCESS_2_SHADER_STORAGE_READ_BIT},
    {"indirect_read", VK_ACCESS_2_INDIRECT_COMMAND_READ_BIT},
    {"transfer_read", VK_ACCESS_2_TRANSFER_READ_BIT},
    {"transfer_write", VK_ACCESS_2_TRANSFER_WRITE_BIT},
    {"memory_read", VK_ACCESS_2_MEMORY_READ_BIT},
    {"memory_write", VK_ACCESS_2_MEMORY_WRITE_BIT},
    {"host_read", VK_ACCESS_2_HOST_READ_BIT},
    {"host_write", VK_ACCESS_2_HOST_WRITE_BIT},
    {"micromap_read", VK_ACCESS_2_MICROMAP_READ_BIT_EXT},
    {"micromap_write", VK_ACCESS_2_MICROMAP_WRITE_BIT_EXT},
};

VkPipelineStageFlags2 play_stages(struct play *play, const char *names)
{
    PLAY_REQUIRE(play, names != NULL);
    return play_words_value(play, names, stages, ARRAY_COUNT(stages));
}

VkAccessFlags2 play_accesses(struct play *play, const char *word)
{
    const char *names = strchr(word, ':');
    return names ? play_words_value(play, names + 1, accesses, ARRAY_COUNT(accesses)) : 0;
}

/* ---- dependencies */

/* What stands in front of the masks. */
struct target {
    const struct play_object *buffer, *image;
    VkDeviceSize offset, size;
    uint32_t src_family, dst_family;
    const char *extension; /* the word of one, or NULL */
};

static char **read_target(struct play *play, char **words, struct target *target)
{
    *target = (struct target){.size = VK_WHOLE_SIZE,
                              .src_family = VK_QUEUE_FAMILY_IGNORED,
                              .dst_family = VK_QUEUE_FAMILY_IGNORED};
    if (play_is(words[0], "on")) {
        target->buffer = play_place(play, words[1], &target->offset);
        words += 2;
        if (words[0] && words[0][0] >= '0' && words[0][0] <= '9')
            target->size = strtoull(*words++, NULL, 0);
    } else if (play_is(words[0], "image")) {
        target->image = play_object(play, words[1]);
        words += 2;
    } else if (play_is(words[0], "at")) {
        target->extension = words[0];
        target->buffer = play_place(play, words[1], &target->offset);
        target->size = strtoull(words[2], NULL, 0);
        words += 3;
    } else if (strncmp(words[0], "tensor", 6) == 0 || play_is(words[0], "unknown")) {
        target->extension = *words++;
    }
    if (play_is(words[0], "from")) {
        target->src_family = (uint32_t)atoi(words[1]);
        target->dst_family = (uint32_t)atoi(words[3]);
        words += 4;
    }
    return words;
}

static void add_buffer(struct dependencies *to, const struct target *target,
                       const VkMemoryBarrier2 *masks)
{
    const uint32_t i = to->info.bufferMemoryBarrierCount++;
    to->buffers[i] =
        MAKE(VkBufferMemoryBarrier2, .pNext = masks->pNext, .srcStageMask = masks->srcStageMask,
             .srcAccessMask = masks->srcAccessMask, .dstStageMask = masks->dstStageMask,
             .dstAccessMask = masks->dstAccessMask, .srcQueueFamilyIndex = target->src_family,
             .dstQueueFamilyIndex = target->dst_family, .buffer = target->buffer->buffer.handle,
             .offset = target->offset, .size = target->size);
    to->old.buffers[i] = MAKE(
        VkBufferMemoryBarrier, .srcAccessMask = (VkAccessFlags)masks->srcAccessMask,
        .dstAccessMask = (VkAccessFlags)masks->dstAccessMask,
        .srcQueueFamilyIndex = target->src_family, .dstQueueFamilyIndex = target->dst_family,
        .buffer = target->buffer->buffer.handle, .offset = target->offset, .size = target->size);
}

static void add_image(struct dependencies *to, const struct target *target,
                      const VkMemoryBarrier2 *masks)
{
    const uint32_t i = to->info.imageMemoryBarrierCount++;
    to->images[i] =
        MAKE(VkImageMemoryBarrier2, .srcStageMask = masks->srcStageMask,
             .srcAccessMask = masks->srcAccessMask, .dstStageMask = masks->dstStageMask,
             .dstAccessMask = masks->dstAccessMask, .oldLayout = VK_IMAGE_LAYOUT_GENERAL,
             .newLayout = VK_IMAGE_LAYOUT_GENERAL, .srcQueueFamilyIndex = target->src_family,
             .dstQueueFamilyIndex = target->dst_family, .image = target->image->image,
             .subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1});
    to->old.images[i] = MAKE(
        VkImageMemoryBarrier, .srcAccessMask = (VkAccessFlags)masks->srcAccessMask,
        .dstAccessMask = (VkAccessFlags)masks->dstAccessMask, .oldLayout = VK_IMAGE_LAYOUT_GENERAL,
        .newLayout = VK_IMAGE_LAYOUT_GENERAL, .srcQueueFamilyIndex = target->src_family,
        .dstQueueFamilyIndex = target->dst_family, .image = target->image->image,
        .subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1});
}

/* A command has at most one such barrier of an extension. */
static void add_extension(struct dependencies *to, const struct target *target,
                          const VkMemoryBarrier2 *masks)
{
    const char *word = target->extension;
    to->tensor = MAKE(VkTensorMemoryBarrierARM, .srcStageMask = masks->srcStageMask,
                      .srcAccessMask = masks->srcAccessMask, .dstStageMask = masks->dstStageMask,
                      .dstAccessMask = masks->dstAccessMask);
    to->tensors = MAKE(VkTensorDependencyInfoARM, .tensorMemoryBarrierCount = 1,
                       .pTensorMemoryBarriers = &to->tensor);
    to->not_of_list = MAKE(VkTensorMemoryBarrierARM, .srcStageMask = ~0ull, .dstStageMask = ~0ull);
    to->range =
        MAKE(VkMemoryRangeBarrierKHR, .pNext = masks->pNext, .srcStageMask = masks->srcStageMask,
             .srcAccessMask = masks->srcAccessMask, .dstStageMask = masks->dstStageMask,
             .dstAccessMask = masks->dstAccessMask, .srcQueueFamilyIndex = target->src_family,
             .dstQueueFamilyIndex = target->dst_family);
    if (target->buffer)
        to->range.addressRange = (VkDeviceAddressRangeKHR){
            target->buffer->buffer.address + target->offset, target->size};
    to->ranges = MAKE(VkMemoryRangeBarriersInfoKHR, .memoryRangeBarrierCount = 1,
                      .pMemoryRangeBarriers = &to->range);
    to->unknown.sType = (VkStructureType)0x7ffffff0;
    to->info.pNext = play_is(word, "at")        ? (const void *)&to->ranges
                     : play_is(word, "tensor")  ? (const void *)&to->tensor
                     : play_is(word, "tensors") ? (const void *)&to->tensors
                                                : (const void *)&to->unknown;
}

static void add(struct dependencies *to, const struct target *target, const VkMemoryBarrier2 *masks)
{
    if (target->extension) {
        add_extension(to, target, masks);
        return;
    }
    to->old.src |= (VkPipelineStageFlags)masks->srcStageMask;
    to->old.dst |= (VkPipelineStageFlags)masks->dstStageMask;
    if (target->buffer) {
        add_buffer(to, target, masks);
    } else if (target->image) {
        add_image(to, target, masks);
    } else {
        const uint32_t i = to->info.memoryBarrierCount++;
        to->memory[i] = *masks;
        to->old.memory[i] =
            MAKE(VkMemoryBarrier, .srcAccessMask = (VkAccessFlags)masks->srcAccessMask,
                 .dstAccessMask = (VkAccessFlags)masks->dstAccessMask);
    }
}

/* Reads the dependencies of one command. Returns the words behind it. */
static char **read_dependencies(struct play *play, char **words, struct dependencies *to)
{
    struct target target;
    to->info = MAKE(VkDependencyInfo, .pMemoryBarriers = to->memory,
                    .pBufferMemoryBarriers = to->buffers, .pImageMemoryBarriers = to->images);
    while (*words && !play_is(*words, "and")) {
        const bool is_counted = words[0][0] >= '0' && words[0][0] <= '9';
        const uint32_t count = is_counted ? (uint32_t)atoi(words[0]) : 1;
        words = read_target(play, words + is_counted, &target);
        const bool is_src_3 = play_is(words[0], "src3"), is_dst_3 = play_is(words[0], "dst3");
        to->flags_3 = MAKE(VkMemoryBarrierAccessFlags3KHR, .srcAccessMask3 = is_src_3,
                           .dstAccessMask3 = is_dst_3);
        words += is_src_3 || is_dst_3;
        PLAY_REQUIRE(play, words[0] && play_is(words[1], ">") && words[2]);
        const STRUCT(VkMemoryBarrier2, masks, .pNext = is_src_3 || is_dst_3 ? &to->flags_3 : NULL,
                     .srcStageMask = play_stages(play, words[0]),
                     .srcAccessMask = play_accesses(play, words[0]),
                     .dstStageMask = play_stages(play, words[2]),
                     .dstAccessMask = play_accesses(play, words[2]));
        PLAY_REQUIRE(play, count <= DEPENDENCIES_MAX - PLAY_ITEMS);
        for (uint32_t i = 0; i < count; i++)
            add(to, &target, &masks);
        words += 3;
        PLAY_REQUIRE(play, !*words || play_is(*words, ",") || play_is(*words, "and"));
        words += play_is(*words, ",");
    }
    return words;
}

struct dependencies *play_read_dependencies(struct play *play, char **words, uint32_t *count)
{
    *count = 1;
    for (char **word = words; *word; word++)
        *count += play_is(*word, "and");
    struct dependencies *all = play_block(play, *count * sizeof(*all));
    for (uint32_t i = 0; i < *count; i++) {
        words = read_dependencies(play, words, &all[i]);
        PLAY_REQUIRE(play, !*words || words[1]);
        words += *words ? 2 : 0; /* and EVENT */
    }
    return all;
}

/* ---- commands */

/* Reads the dependencies of a command, which it must not modify. */
static const struct dependencies *lend(struct play *play, char **words, uint32_t *count)
{
    const struct dependencies *all = play_read_dependencies(play, words, count);
    play_lend(play, all, *count * sizeof(*all));
    return all;
}

static void play_barrier(struct play *play, char **words)
{
    uint32_t count;
    const struct dependencies *all = lend(play, words + 1, &count);
    PLAY_REQUIRE(play, count == 1);
    if (play_is(words[0], "barrier"))
        play->vk.CmdPipelineBarrier2(play_commands(play), &all->info);
    else
        play->vk.CmdPipelineBarrier(play_commands(play), all->old.src, all->old.dst, 0,
                                    all->info.memoryBarrierCount, all->old.memory,
                                    all->info.bufferMemoryBarrierCount, all->old.buffers,
                                    all->info.imageMemoryBarrierCount, all->old.images);
    play_expect_unmodified(play);
}

static void play_wait(struct play *play, char **words)
{
    VkEvent events[PLAY_ITEMS];
    VkDependencyInfo infos[PLAY_ITEMS];
    uint32_t count, found = 0;
    const struct dependencies *all = lend(play, words + 2, &count);
    PLAY_REQUIRE(play, count <= PLAY_ITEMS);
    for (char **word = words; *word; word++)
        if (word == words || play_is(*word, "and"))
            events[found++] = play_object(play, word[1])->event;
    for (uint32_t i = 0; i < count; i++)
        infos[i] = all[i].info;
    if (play_is(words[0], "wait1"))
        play->vk.CmdWaitEvents(play_commands(play), count, events, all->old.src, all->old.dst,
                               all->info.memoryBarrierCount, all->old.memory,
                               all->info.bufferMemoryBarrierCount, all->old.buffers,
                               all->info.imageMemoryBarrierCount, all->old.images);
    else
        (play_is(words[0], "wait") ? play->vk.CmdWaitEvents2 : play->vk.CmdWaitEvents2KHR)(
            play_commands(play), count, events, infos);
    play_expect_unmodified(play);
}

static void set_event(struct play *play, char **words, VkEvent event)
{
    uint32_t count;
    const struct dependencies *all = lend(play, words + 2, &count);
    PLAY_REQUIRE(play, count == 1);
    (play_is(words[0], "set") ? play->vk.CmdSetEvent2
                              : play->vk.CmdSetEvent2KHR)(play_commands(play), event, &all->info);
    play_expect_unmodified(play);
}

static bool play_event(struct play *play, char **words)
{
    if (!words[1] || words[1][0] != 'E')
        return false;
    const VkEvent event = play_object(play, words[1])->event;
    if (play_is(words[0], "set") || play_is(words[0], "setKHR")) {
        set_event(play, words, event);
    } else if (play_is(words[0], "set1")) {
        play->vk.CmdSetEvent(play_commands(play), event,
                             (VkPipelineStageFlags)play_stages(play, words[2]));
    } else if (play_is(words[0], "reset") || play_is(words[0], "resetKHR")) {
        (play_is(words[0], "reset") ? play->vk.CmdResetEvent2 : play->vk.CmdResetEvent2KHR)(
            play_commands(play), event, play_stages(play, words[2]));
    } else if (play_is(words[0], "reset1")) {
        play->vk.CmdResetEvent(play_commands(play), event,
                               (VkPipelineStageFlags)play_stages(play, words[2]));
    } else if (strncmp(words[0], "wait", 4) == 0) {
        play_wait(play, words);
    } else {
        return false;
    }
    return true;
}

static void prepare_image(struct play *play, const char *name)
{
    const VkImageMemoryBarrier barrier =
        MAKE(VkImageMemoryBarrier, .newLayout = VK_IMAGE_LAYOUT_GENERAL,
             .image = play_object(play, name)->image,
             .subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1});
    VkCommandBuffer commands = commands_begin(&play->vk, play->device, play->pools[0],
                                              VK_COMMAND_BUFFER_LEVEL_PRIMARY, 0, NULL);
    play->vk.CmdPipelineBarrier(commands, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT,
                                VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, 0, 0, NULL, 0, NULL, 1,
                                &barrier);
    play_end_recording(play, commands);
    commands_run(&play->vk, play->device, play->queues[0], commands);
}

static void write_timestamp(struct play *play, char **words)
{
    const VkPipelineStageFlags2 stage = play_stages(play, words[1]);
    const VkQueryPool pool = words[2] ? play_object(play, words[2])->queries : VK_NULL_HANDLE;
    if (play_is(words[0], "timestamp2"))
        play->vk.CmdWriteTimestamp2(play_commands(play), stage, pool, 0);
    else
        play->vk.CmdWriteTimestamp(play_commands(play), (VkPipelineStageFlagBits)stage, pool, 0);
}

bool play_sync(struct play *play, char **words)
{
    if (play_is(words[0], "barrier") || play_is(words[0], "barrier1"))
        play_barrier(play, words);
    else if (play_is(words[0], "below"))
        play_expect_below(play, words + 1);
    else if (strncmp(words[0], "timestamp", 9) == 0)
        write_timestamp(play, words);
    else if (play_is(words[0], "image"))
        prepare_image(play, words[1]);
    else if (strncmp(words[0], "render", 6) == 0)
        play_render(play, words);
    else if (play_is(words[0], "host") && play_is(words[1], "set"))
        GET(play->vk.SetEvent(play->device, play_object(play, words[2])->event));
    else if (play_is(words[0], "host") && play_is(words[1], "reset") && words[2] &&
             words[2][0] == 'E')
        GET(play->vk.ResetEvent(play->device, play_object(play, words[2])->event));
    else
        return play_event(play, words);
    return true;
}
