/* SPDX-License-Identifier: Apache-2.0 */
/* Empty render passes of programs: the first lines of sync.c say how they are written. */
#include "sync.h"

/* Dependency 0 comes from what is outside, 1 leads there, and 2 is between the subpasses. */
static uint32_t src_of(uint32_t dependency, uint32_t subpasses)
{
    return dependency == 0 ? VK_SUBPASS_EXTERNAL : dependency == 1 ? subpasses - 1 : 0;
}

static uint32_t dst_of(uint32_t dependency)
{
    return dependency == 0 ? 0 : dependency == 1 ? VK_SUBPASS_EXTERNAL : 1;
}

static uint32_t count_of(const struct dependencies *all)
{
    return all->info.memoryBarrierCount < 3 ? all->info.memoryBarrierCount : 3;
}

static void create_render_pass(struct play *play, const struct dependencies *all)
{
    VkSubpassDependency dependencies[3];
    const VkSubpassDescription subpasses[2] = {{.pipelineBindPoint = 0}};
    const uint32_t count = count_of(all), subpass_count = count > 2 ? 2 : 1;
    for (uint32_t i = 0; i < count; i++)
        dependencies[i] =
            (VkSubpassDependency){.srcSubpass = src_of(i, subpass_count),
                                  .dstSubpass = dst_of(i),
                                  .srcStageMask = (VkPipelineStageFlags)all->memory[i].srcStageMask,
                                  .dstStageMask = (VkPipelineStageFlags)all->memory[i].dstStageMask,
                                  .srcAccessMask = (VkAccessFlags)all->memory[i].srcAccessMask,
                                  .dstAccessMask = (VkAccessFlags)all->memory[i].dstAccessMask};
    const STRUCT(VkRenderPassCreateInfo, info, .subpassCount = subpass_count,
                 .pSubpasses = subpasses, .dependencyCount = count, .pDependencies = dependencies);
    GET(play->vk.CreateRenderPass(play->device, &info, NULL, &play->render_pass));
}

/* The masks are those of the barriers in the chains. */
static void create_render_pass_2(struct play *play, const struct dependencies *all, bool is_khr)
{
    VkSubpassDependency2 dependencies[3];
    const VkSubpassDescription2 subpasses[2] = {MAKE(VkSubpassDescription2),
                                                MAKE(VkSubpassDescription2)};
    const uint32_t count = count_of(all), subpass_count = count > 2 ? 2 : 1;
    for (uint32_t i = 0; i < count; i++)
        dependencies[i] = MAKE(VkSubpassDependency2, .pNext = &all->memory[i],
                               .srcSubpass = src_of(i, subpass_count), .dstSubpass = dst_of(i));
    const STRUCT(VkRenderPassCreateInfo2, info, .subpassCount = subpass_count,
                 .pSubpasses = subpasses, .dependencyCount = count, .pDependencies = dependencies);
    GET((is_khr ? play->vk.CreateRenderPass2KHR
                : play->vk.CreateRenderPass2)(play->device, &info, NULL, &play->render_pass));
}

/* The fourth dependency is a barrier in the second subpass. */
static void add_barrier(struct play *play, const struct dependencies *all)
{
    const STRUCT(VkDependencyInfo, info, .memoryBarrierCount = 1,
                 .pMemoryBarriers = &all->memory[3]);
    if (all->info.memoryBarrierCount > 3)
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
    if (all->info.memoryBarrierCount > 2)
        (is_khr ? vk->CmdNextSubpass2KHR : vk->CmdNextSubpass2)(commands, &begin, &end);
    add_barrier(play, all);
    (is_khr ? vk->CmdEndRenderPass2KHR : vk->CmdEndRenderPass2)(commands, &end);
}

/* The program keeps one render pass, and its framebuffer. */
void play_render(struct play *play, char **words)
{
    const bool is_first = play_is(words[0], "render"), is_khr = play_is(words[0], "render2KHR");
    struct dependencies all;
    play_read_dependencies(play, words + 1, &all);
    PLAY_REQUIRE(play, !play->render_pass && all.info.memoryBarrierCount <= 4);
    if (is_first)
        create_render_pass(play, &all);
    else
        create_render_pass_2(play, &all, is_khr);
    const STRUCT(VkFramebufferCreateInfo, info, .renderPass = play->render_pass, .width = 4,
                 .height = 4, .layers = 1);
    GET(play->vk.CreateFramebuffer(play->device, &info, NULL, &play->framebuffer));
    const STRUCT(VkRenderPassBeginInfo, begin, .renderPass = play->render_pass,
                 .framebuffer = play->framebuffer, .renderArea.extent = {4, 4});
    if (!is_first) {
        render_2(play, &begin, &all, is_khr);
        return;
    }
    play->vk.CmdBeginRenderPass(play_commands(play), &begin, VK_SUBPASS_CONTENTS_INLINE);
    if (all.info.memoryBarrierCount > 2)
        play->vk.CmdNextSubpass(play_commands(play), VK_SUBPASS_CONTENTS_INLINE);
    add_barrier(play, &all);
    play->vk.CmdEndRenderPass(play_commands(play));
}
