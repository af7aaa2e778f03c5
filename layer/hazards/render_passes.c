/* SPDX-License-Identifier: Apache-2.0 */
/* Records the dependencies of render passes. No access inside a render pass is tracked, so its
 * dependencies matter only as links of chains that pass through it. Barriers inside a subpass may
 * be further links. At each place where a dependency may take effect, it and those of earlier
 * subpasses are recorded, in the order of subpasses: this orders more than the specification
 * guarantees, never less. Without VK_SUBPASS_EXTERNAL dependencies the implicit ones order nothing
 * outside. */
#include <stdlib.h>

#include "layer/hazards/barriers.h"
#include "layer/hazards/commands.h"
#include "layer/hazards/objects.h"
#include "layer/intercepts/intercepts.h"
#include "src/base/chain.h"

/* ---- creation */

static int compare(const void *a, const void *b)
{
    const struct subpass_dependency *x = a, *y = b;
    if (x->dst != y->dst)
        return x->dst < y->dst ? -1 : 1;
    return x->src < y->src ? -1 : x->src > y->src;
}

/* Takes over the dependencies, which are NULL if memory ran out. */
static void keep(const struct layer_device *device, VkRenderPass render_pass,
                 struct subpass_dependency *dependencies, uint32_t count)
{
    if (dependencies)
        qsort(dependencies, count, sizeof(*dependencies), compare);
    if (dependencies)
        hazard_objects_add_render_pass(device->hazard_objects, render_pass, dependencies, count);
    else
        hazard_objects_remove_render_pass(device->hazard_objects, render_pass);
    free(dependencies);
}

/* Room for at least one, so that NULL means that memory has run out. */
static struct subpass_dependency *allocate(uint32_t count)
{
    return calloc(count ? count : 1, sizeof(struct subpass_dependency));
}

VKAPI_ATTR VkResult VKAPI_CALL hazards_CreateRenderPass(VkDevice device,
                                                        const VkRenderPassCreateInfo *pCreateInfo,
                                                        const VkAllocationCallbacks *pAllocator,
                                                        VkRenderPass *pRenderPass)
{
    struct layer_device *state = layer_find_device(device);
    VkResult result = state->vk.CreateRenderPass(device, pCreateInfo, pAllocator, pRenderPass);
    uint32_t count = pCreateInfo->dependencyCount;
    struct subpass_dependency *all = result == VK_SUCCESS ? allocate(count) : NULL;
    for (uint32_t i = 0; all && i < count; i++) {
        const VkSubpassDependency *from = &pCreateInfo->pDependencies[i];
        all[i] =
            (struct subpass_dependency){from->srcSubpass, from->dstSubpass,
                                        dependency_of(from->srcStageMask, from->srcAccessMask,
                                                      from->dstStageMask, from->dstAccessMask)};
    }
    if (result == VK_SUCCESS)
        keep(state, *pRenderPass, all, count);
    return result;
}

/* A VkMemoryBarrier2 replaces the masks of the structure that it extends. */
static struct subpass_dependency describe(const VkSubpassDependency2 *from)
{
    const VkMemoryBarrier2 *barrier = chain_find(from->pNext, VK_STRUCTURE_TYPE_MEMORY_BARRIER_2);
    struct subpass_dependency dependency = {.src = from->srcSubpass, .dst = from->dstSubpass};
    if (barrier)
        dependency.dependency = dependency_of(barrier->srcStageMask, barrier->srcAccessMask,
                                              barrier->dstStageMask, barrier->dstAccessMask);
    else
        dependency.dependency = dependency_of(from->srcStageMask, from->srcAccessMask,
                                              from->dstStageMask, from->dstAccessMask);
    dependency.dependency = barriers_with_flags_3(dependency.dependency, from->pNext);
    return dependency;
}

static void keep_2(const struct layer_device *device, VkRenderPass render_pass,
                   const VkRenderPassCreateInfo2 *info)
{
    struct subpass_dependency *all = allocate(info->dependencyCount);
    for (uint32_t i = 0; all && i < info->dependencyCount; i++)
        all[i] = describe(&info->pDependencies[i]);
    keep(device, render_pass, all, info->dependencyCount);
}

/* A command and its alias differ only in which command they call. */
#define DEFINE_CREATE_RENDER_PASS_2(name)                                                          \
    VKAPI_ATTR VkResult VKAPI_CALL hazards_##name(                                                 \
        VkDevice device, const VkRenderPassCreateInfo2 *pCreateInfo,                               \
        const VkAllocationCallbacks *pAllocator, VkRenderPass *pRenderPass)                        \
    {                                                                                              \
        struct layer_device *state = layer_find_device(device);                                    \
        VkResult result = state->vk.name(device, pCreateInfo, pAllocator, pRenderPass);            \
        if (result == VK_SUCCESS)                                                                  \
            keep_2(state, *pRenderPass, pCreateInfo);                                              \
        return result;                                                                             \
    }

DEFINE_CREATE_RENDER_PASS_2(CreateRenderPass2)
DEFINE_CREATE_RENDER_PASS_2(CreateRenderPass2KHR)

VKAPI_ATTR void VKAPI_CALL hazards_DestroyRenderPass(VkDevice device, VkRenderPass renderPass,
                                                     const VkAllocationCallbacks *pAllocator)
{
    struct layer_device *state = layer_find_device(device);
    hazard_objects_remove_render_pass(state->hazard_objects, renderPass);
    state->vk.DestroyRenderPass(device, renderPass, pAllocator);
}

/* ---- commands */

/* The places of a render pass at which dependencies take effect. */
enum place { PASS_BEGIN, PASS_NEXT, PASS_END };

static bool is_at(const struct subpass_dependency *dependency, enum place place)
{
    bool from_outside = dependency->src == VK_SUBPASS_EXTERNAL;
    bool to_outside = dependency->dst == VK_SUBPASS_EXTERNAL;
    switch (place) {
    case PASS_BEGIN:
        return from_outside;
    case PASS_NEXT:
        return !from_outside && !to_outside;
    case PASS_END:
        break;
    }
    return !from_outside;
}

static void add_place(struct hazard_recording *recording, enum place place)
{
    uint32_t count = 0;
    const struct subpass_dependency *all = hazard_objects_dependencies(
        recording->device->hazard_objects,
        (VkRenderPass)(uintptr_t)recording->command_buffer->render_pass, &count);
    const struct dependency full = barriers_full_dependency();
    if (!all)
        barriers_add_global(recording, &full);
    for (uint32_t i = 0; i < count; i++)
        if (is_at(&all[i], place))
            barriers_add_global(recording, &all[i].dependency);
}

static void begin(VkCommandBuffer handle, const VkRenderPassBeginInfo *info)
{
    struct hazard_recording recording;
    if (!hazard_recording_start(&recording, handle))
        return;
    recording.command_buffer->render_pass = (uint64_t)(uintptr_t)info->renderPass;
    add_place(&recording, PASS_BEGIN);
}

static void go_on(VkCommandBuffer handle, enum place place)
{
    struct hazard_recording recording;
    if (hazard_recording_start(&recording, handle))
        add_place(&recording, place);
}

VKAPI_ATTR void VKAPI_CALL hazards_CmdBeginRenderPass(VkCommandBuffer commandBuffer,
                                                      const VkRenderPassBeginInfo *pRenderPassBegin,
                                                      VkSubpassContents contents)
{
    begin(commandBuffer, pRenderPassBegin);
    assay_CmdBeginRenderPass(commandBuffer, pRenderPassBegin, contents);
}

VKAPI_ATTR void VKAPI_CALL hazards_CmdNextSubpass(VkCommandBuffer commandBuffer,
                                                  VkSubpassContents contents)
{
    struct layer_device *device = layer_find_recording_device(commandBuffer);
    if (!device)
        return;
    go_on(commandBuffer, PASS_NEXT);
    device->vk.CmdNextSubpass(commandBuffer, contents);
}

VKAPI_ATTR void VKAPI_CALL hazards_CmdEndRenderPass(VkCommandBuffer commandBuffer)
{
    go_on(commandBuffer, PASS_END);
    assay_CmdEndRenderPass(commandBuffer);
}

#define DEFINE_RENDER_PASS_2(suffix)                                                               \
    VKAPI_ATTR void VKAPI_CALL hazards_CmdBeginRenderPass##suffix(                                 \
        VkCommandBuffer commandBuffer, const VkRenderPassBeginInfo *pRenderPassBegin,              \
        const VkSubpassBeginInfo *pSubpassBeginInfo)                                               \
    {                                                                                              \
        begin(commandBuffer, pRenderPassBegin);                                                    \
        assay_CmdBeginRenderPass##suffix(commandBuffer, pRenderPassBegin, pSubpassBeginInfo);      \
    }                                                                                              \
    VKAPI_ATTR void VKAPI_CALL hazards_CmdNextSubpass##suffix(                                     \
        VkCommandBuffer commandBuffer, const VkSubpassBeginInfo *pSubpassBeginInfo,                \
        const VkSubpassEndInfo *pSubpassEndInfo)                                                   \
    {                                                                                              \
        struct layer_device *device = layer_find_recording_device(commandBuffer);                  \
        if (!device)                                                                               \
            return;                                                                                \
        go_on(commandBuffer, PASS_NEXT);                                                           \
        device->vk.CmdNextSubpass##suffix(commandBuffer, pSubpassBeginInfo, pSubpassEndInfo);      \
    }                                                                                              \
    VKAPI_ATTR void VKAPI_CALL hazards_CmdEndRenderPass##suffix(                                   \
        VkCommandBuffer commandBuffer, const VkSubpassEndInfo *pSubpassEndInfo)                    \
    {                                                                                              \
        go_on(commandBuffer, PASS_END);                                                            \
        assay_CmdEndRenderPass##suffix(commandBuffer, pSubpassEndInfo);                            \
    }

DEFINE_RENDER_PASS_2(2)
DEFINE_RENDER_PASS_2(2KHR)

/* ---- images */

VKAPI_ATTR VkResult VKAPI_CALL hazards_CreateImage(VkDevice device,
                                                   const VkImageCreateInfo *pCreateInfo,
                                                   const VkAllocationCallbacks *pAllocator,
                                                   VkImage *pImage)
{
    struct layer_device *state = layer_find_device(device);
    VkResult result = state->vk.CreateImage(device, pCreateInfo, pAllocator, pImage);
    if (result == VK_SUCCESS)
        hazard_objects_add_image(state->hazard_objects, *pImage, pCreateInfo->format);
    return result;
}

VKAPI_ATTR void VKAPI_CALL hazards_DestroyImage(VkDevice device, VkImage image,
                                                const VkAllocationCallbacks *pAllocator)
{
    struct layer_device *state = layer_find_device(device);
    hazard_objects_remove_image(state->hazard_objects, image);
    state->vk.DestroyImage(device, image, pAllocator);
}
