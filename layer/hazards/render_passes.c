/* SPDX-License-Identifier: Apache-2.0 */
/* Records the dependencies of render passes. No access inside a render pass is tracked, so its
 * dependencies matter only as links of chains that pass through it. Barriers inside a subpass may
 * be further links. At each place where a dependency may take effect, all that may do so there are
 * recorded, in any order: a chain from subpass to subpass has one link at most for each
 * vkCmdNextSubpass. This orders more than the specification guarantees, never less. Without
 * VK_SUBPASS_EXTERNAL dependencies the implicit ones order nothing outside. */
#include <stdlib.h>

#include "layer/hazards/recording.h"
#include "observers.h"
#include "src/base/chain.h"

/* ---- creation */

/* A VkMemoryBarrier2 replaces the masks of the structure that it extends. */
static struct subpass_dependency describe_dependency(const VkSubpassDependency2 *from)
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

/* The render pass is unknown if memory runs out, also for the dependencies of a call that is
 * lowered. There is room for at least one, so that NULL means that memory has run out. */
void hazards_note_render_pass(struct layer_device *device, VkRenderPass render_pass,
                              const VkRenderPassCreateInfo2 *info)
{
    const uint32_t count = info->dependencyCount;
    const bool is_known = !count || info->pDependencies;
    struct subpass_dependency *all = is_known ? calloc(count ? count : 1, sizeof(*all)) : NULL;
    for (uint32_t i = 0; all && i < count; i++)
        all[i] = describe_dependency(&info->pDependencies[i]);
    if (all)
        hazard_objects_add_render_pass(device->hazard_objects, render_pass, all, count);
    else
        hazard_objects_remove_render_pass(device->hazard_objects, render_pass);
    free(all);
}

void hazards_forget_render_pass(struct layer_device *device, VkRenderPass render_pass)
{
    hazard_objects_remove_render_pass(device->hazard_objects, render_pass);
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

void hazards_begin_render_pass(struct hazard_recording *recording,
                               const VkRenderPassBeginInfo *info)
{
    recording->command_buffer->render_pass = handle_number(info->renderPass);
    add_place(recording, PASS_BEGIN);
}

void hazards_next_subpass(struct hazard_recording *recording)
{
    add_place(recording, PASS_NEXT);
}

void hazards_end_render_pass(struct hazard_recording *recording)
{
    add_place(recording, PASS_END);
}

/* ---- images */

void hazards_note_image(struct layer_device *device, VkImage image, const VkImageCreateInfo *info)
{
    hazard_objects_add_image(device->hazard_objects, image, info->format);
}

void hazards_forget_image(struct layer_device *device, VkImage image)
{
    hazard_objects_remove_image(device->hazard_objects, image);
}
