/* SPDX-License-Identifier: Apache-2.0 */
/* Empty render passes of programs: the first lines of sync.c say how they are written. */
#include "tests/player/commands/sync.h"

/* The number of dependencies that the render pass has. */
static uint32_t count_of(const struct dependencies *all)
{
    return all->info.memoryBarrierCount == 4 ? 3 : all->info.memoryBarrierCount;
}

static uint32_t subpasses_of(const struct dependencies *all)
{
    return count_of(all) == 3 ? 2 : 1;
}

/* Dependency 0 comes from what is outside, 1 leads there, and 2 is between the subpasses. Of more,
 * all come from what is outside. */
static uint32_t src_of(const struct dependencies *all, uint32_t dependency)
{
    return dependency == 0 || count_of(all) > 3 ? VK_SUBPASS_EXTERNAL
           : dependency == 1                    ? subpasses_of(all) - 1
                                                : 0;
}

static uint32_t dst_of(const struct dependencies *all, uint32_t dependency)
{
    return dependency == 0 || count_of(all) > 3 ? 0 : dependency == 1 ? VK_SUBPASS_EXTERNAL : 1;
}

static void create_render_pass(struct play *play, struct dependencies *all)
{
    const VkSubpassDescription subpasses[2] = {{.pipelineBindPoint = 0}};
    for (uint32_t i = 0; i < count_of(all); i++)
        all->of_subpasses[i] =
            (VkSubpassDependency){.srcSubpass = src_of(all, i),
                                  .dstSubpass = dst_of(all, i),
                                  .srcStageMask = (VkPipelineStageFlags)all->memory[i].srcStageMask,
                                  .dstStageMask = (VkPipelineStageFlags)all->memory[i].dstStageMask,
                                  .srcAccessMask = (VkAccessFlags)all->memory[i].srcAccessMask,
                                  .dstAccessMask = (VkAccessFlags)all->memory[i].dstAccessMask};
    const size_t size = count_of(all) * sizeof(all->of_subpasses[0]);
    const STRUCT(VkRenderPassCreateInfo, info, .subpassCount = subpasses_of(all),
                 .pSubpasses = subpasses, .dependencyCount = count_of(all),
                 .pDependencies = play_copy_for_call(play, all->of_subpasses, size));
    play_lend(play, info.pDependencies, size);
    GET(play->vk.CreateRenderPass(play->device, &info, NULL, &play->render_pass));
    play_expect_unmodified(play);
}

static void create_render_pass_2(struct play *play, struct dependencies *all, bool is_khr,
                                 bool is_chained)
{
    const VkSubpassDescription2 subpasses[2] = {MAKE(VkSubpassDescription2),
                                                MAKE(VkSubpassDescription2)};
    for (uint32_t i = 0; i < count_of(all); i++) {
        const VkMemoryBarrier2 *masks = &all->memory[i];
        all->of_subpasses_2[i] =
            MAKE(VkSubpassDependency2, .srcSubpass = src_of(all, i), .dstSubpass = dst_of(all, i));
        if (is_chained) {
            all->of_subpasses_2[i].pNext = masks;
            continue;
        }
        all->of_subpasses_2[i].srcStageMask = (VkPipelineStageFlags)masks->srcStageMask;
        all->of_subpasses_2[i].dstStageMask = (VkPipelineStageFlags)masks->dstStageMask;
        all->of_subpasses_2[i].srcAccessMask = (VkAccessFlags)masks->srcAccessMask;
        all->of_subpasses_2[i].dstAccessMask = (VkAccessFlags)masks->dstAccessMask;
    }
    const size_t size = count_of(all) * sizeof(all->of_subpasses_2[0]);
    const STRUCT(VkRenderPassCreateInfo2, info, .subpassCount = subpasses_of(all),
                 .pSubpasses = subpasses, .dependencyCount = count_of(all),
                 .pDependencies = play_copy_for_call(play, all->of_subpasses_2, size));
    if (is_chained)
        play_lend(play, all, sizeof(*all));
    else
        play_lend(play, info.pDependencies, size);
    GET((is_khr ? play->vk.CreateRenderPass2KHR
                : play->vk.CreateRenderPass2)(play->device, &info, NULL, &play->render_pass));
    play_expect_unmodified(play);
    PLAY_REQUIRE(play, memcmp(info.pDependencies, all->of_subpasses_2, size) == 0);
}

/* The fourth dependency is a barrier in the second subpass. */
static void add_barrier(struct play *play, const struct dependencies *all)
{
    const STRUCT(VkDependencyInfo, info, .memoryBarrierCount = 1,
                 .pMemoryBarriers = &all->memory[3]);
    if (all->info.memoryBarrierCount == 4)
        play->vk.CmdPipelineBarrier2(play_commands(play), &info);
}

static void render_2(struct play *play, const VkRenderPassBeginInfo *info,
                     const struct dependencies *all, bool is_khr)
{
    const VkuDeviceDispatchTable *vk = &play->vk;
    const VkCommandBuffer commands = play_commands(play);
    const STRUCT(VkSubpassBeginInfo, begin);
    const STRUCT(VkSubpassEndInfo, end);
    (is_khr ? vk->CmdBeginRenderPass2KHR : vk->CmdBeginRenderPass2)(commands, info, &begin);
    if (subpasses_of(all) > 1)
        (is_khr ? vk->CmdNextSubpass2KHR : vk->CmdNextSubpass2)(commands, &begin, &end);
    add_barrier(play, all);
    (is_khr ? vk->CmdEndRenderPass2KHR : vk->CmdEndRenderPass2)(commands, &end);
}

/* The program keeps one render pass, and its framebuffer. */
void play_render(struct play *play, char **words)
{
    const bool is_first = play_is(words[0], "render"), is_khr = play_is(words[0], "render2KHR");
    const bool is_own = play_is(words[1], "own");
    uint32_t count;
    struct dependencies *all = play_read_dependencies(play, words + 1 + is_own, &count);
    PLAY_REQUIRE(play, !play->render_pass && count == 1);
    if (is_first)
        create_render_pass(play, all);
    else
        create_render_pass_2(play, all, is_khr, !is_own);
    const STRUCT(VkFramebufferCreateInfo, info, .renderPass = play->render_pass, .width = 4,
                 .height = 4, .layers = 1);
    GET(play->vk.CreateFramebuffer(play->device, &info, NULL, &play->framebuffer));
    const STRUCT(VkRenderPassBeginInfo, begin, .renderPass = play->render_pass,
                 .framebuffer = play->framebuffer, .renderArea.extent = {4, 4});
    if (!is_first) {
        render_2(play, &begin, all, is_khr);
        return;
    }
    play->vk.CmdBeginRenderPass(play_commands(play), &begin, VK_SUBPASS_CONTENTS_INLINE);
    if (subpasses_of(all) > 1)
        play->vk.CmdNextSubpass(play_commands(play), VK_SUBPASS_CONTENTS_INLINE);
    add_barrier(play, all);
    play->vk.CmdEndRenderPass(play_commands(play));
}
