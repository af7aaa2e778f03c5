/* SPDX-License-Identifier: Apache-2.0 */
/* Command buffers of a scene, and what they record beside builds. */

#include "tests/fixture/copies.h"
#include "tests/player/scene/scene.h"

SCENE_CREATES(create_pool, CommandPool, VkCommandPool, VkCommandPoolCreateInfo)
SCENE_CREATES(create_render_pass, RenderPass, VkRenderPass, VkRenderPassCreateInfo)
SCENE_CREATES(create_framebuffer, Framebuffer, VkFramebuffer, VkFramebufferCreateInfo)

VkCommandPool scene_pool(struct scene *scene, uint32_t family, VkCommandPoolCreateFlags flags)
{
    const STRUCT(VkCommandPoolCreateInfo, create_info,
                 .flags = VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT | flags,
                 .queueFamilyIndex = family);
    return create_pool(scene, &create_info);
}

VkCommandBuffer scene_allocate_command_buffer(struct scene *scene, VkCommandPool pool,
                                              VkCommandBufferLevel level)
{
    const STRUCT(VkCommandBufferAllocateInfo, allocate_info, .commandPool = pool, .level = level,
                 .commandBufferCount = 1);
    VkCommandBuffer command_buffer;
    GET(scene->vk->AllocateCommandBuffers(scene->fixture->device, &allocate_info, &command_buffer));
    return command_buffer;
}

VkCommandBuffer scene_command_buffer(struct scene *scene, uint32_t family)
{
    return scene_allocate_command_buffer(scene, scene_pool(scene, family, 0),
                                         VK_COMMAND_BUFFER_LEVEL_PRIMARY);
}

void scene_begin(struct scene *scene, VkCommandBuffer command_buffer,
                 VkCommandBufferUsageFlags flags)
{
    const STRUCT(VkCommandBufferInheritanceInfo, inheritance);
    const STRUCT(VkCommandBufferBeginInfo, begin_info, .flags = flags,
                 .pInheritanceInfo = &inheritance);
    GET(scene->vk->BeginCommandBuffer(command_buffer, &begin_info));
}

void scene_end(struct scene *scene, VkCommandBuffer command_buffer)
{
    GET(scene->vk->EndCommandBuffer(command_buffer));
}

uint32_t scene_family(const struct scene *scene)
{
    return fixture_find_family(scene->fixture, VK_QUEUE_COMPUTE_BIT, 0);
}

VkQueue scene_queue(const struct scene *scene, uint32_t family)
{
    VkQueue queue;
    scene->vk->GetDeviceQueue(scene->fixture->device, family, 0, &queue);
    return queue;
}

static VkResult try_submit(struct scene *scene, uint32_t family, VkCommandBuffer command_buffer)
{
    const VkQueue queue = scene_queue(scene, family);
    const VkResult result = commands_submit(scene->vk, queue, command_buffer, VK_NULL_HANDLE);
    GET(scene->vk->QueueWaitIdle(queue));
    return result;
}

void scene_submit(struct scene *scene, uint32_t family, VkCommandBuffer command_buffer)
{
    GET(try_submit(scene, family, command_buffer));
}

VkResult scene_submit_call(struct scene *scene)
{
    scene_end(scene, scene->command_buffer);
    return try_submit(scene, scene_family(scene), scene->command_buffer);
}

VkCommandBuffer scene_begin_own(struct scene *scene)
{
    const VkCommandBuffer command_buffer = scene_command_buffer(scene, scene_family(scene));
    scene_begin(scene, command_buffer, 0);
    return command_buffer;
}

void scene_run(struct scene *scene, VkCommandBuffer command_buffer)
{
    scene_end(scene, command_buffer);
    scene_submit(scene, scene_family(scene), command_buffer);
}

void scene_record_in_family(struct scene *scene, uint32_t family, VkCommandPoolCreateFlags flags)
{
    if (family == UINT32_MAX) {
        scene_skip(scene, "no queue family of that kind");
        return;
    }
    scene->command_buffer = scene_allocate_command_buffer(scene, scene_pool(scene, family, flags),
                                                          VK_COMMAND_BUFFER_LEVEL_PRIMARY);
    scene_begin(scene, scene->command_buffer, 0);
}

/* ---- render passes ---- */

VkRenderPass scene_render_pass(struct scene *scene)
{
    const VkSubpassDescription subpass = {.pipelineBindPoint = VK_PIPELINE_BIND_POINT_GRAPHICS};
    const STRUCT(VkRenderPassCreateInfo, create_info, .subpassCount = 1, .pSubpasses = &subpass);
    return create_render_pass(scene, &create_info);
}

static VkRenderPassBeginInfo begin_info_of(struct scene *scene)
{
    STRUCT(VkRenderPassBeginInfo, begin_info, .renderPass = scene_render_pass(scene),
           .renderArea.extent = {4, 4});
    const STRUCT(VkFramebufferCreateInfo, create_info, .renderPass = begin_info.renderPass,
                 .width = 4, .height = 4, .layers = 1);
    begin_info.framebuffer = create_framebuffer(scene, &create_info);
    return begin_info;
}

void scene_begin_render_pass(struct scene *scene, VkCommandBuffer command_buffer)
{
    const VkRenderPassBeginInfo begin_info = begin_info_of(scene);
    scene->vk->CmdBeginRenderPass(command_buffer, &begin_info, VK_SUBPASS_CONTENTS_INLINE);
}

void scene_begin_render_pass2(struct scene *scene, VkCommandBuffer command_buffer)
{
    const VkRenderPassBeginInfo begin_info = begin_info_of(scene);
    const STRUCT(VkSubpassBeginInfo, subpass, .contents = VK_SUBPASS_CONTENTS_INLINE);
    if (scene->fixture->setup.route == ROUTE_KHR)
        scene->vk->CmdBeginRenderPass2KHR(command_buffer, &begin_info, &subpass);
    else
        scene->vk->CmdBeginRenderPass2(command_buffer, &begin_info, &subpass);
}

void scene_begin_rendering(struct scene *scene, VkCommandBuffer command_buffer,
                           VkRenderingFlags flags)
{
    const STRUCT(VkRenderingInfo, info, .flags = flags, .renderArea.extent = {4, 4},
                 .layerCount = 1);
    if (scene->fixture->setup.route == ROUTE_KHR)
        scene->vk->CmdBeginRenderingKHR(command_buffer, &info);
    else
        scene->vk->CmdBeginRendering(command_buffer, &info);
}

void scene_end_rendering(struct scene *scene, VkCommandBuffer command_buffer)
{
    if (scene->fixture->setup.route == ROUTE_KHR)
        scene->vk->CmdEndRenderingKHR(command_buffer);
    else
        scene->vk->CmdEndRendering(command_buffer);
}

/* ---- before the call ---- */

void scene_build_before(struct scene *scene, uint32_t first, uint32_t count)
{
    if (command_is_on_host(scene->command)) {
        GET(scene->vk->BuildAccelerationStructuresKHR(scene->fixture->device, VK_NULL_HANDLE, count,
                                                      &scene->infos[first],
                                                      &scene->range_pointers[first]));
        return;
    }
    const VkCommandBuffer command_buffer = scene_begin_before(scene);
    scene->vk->CmdBuildAccelerationStructuresKHR(command_buffer, count, &scene->infos[first],
                                                 &scene->range_pointers[first]);
    scene_end_before(scene, command_buffer);
}

void scene_build_source(struct scene *scene, uint32_t update)
{
    const VkAccelerationStructureBuildGeometryInfoKHR info = scene->infos[update];
    if (!command_is_on_host(scene->command))
        return;
    scene->infos[update].mode = VK_BUILD_ACCELERATION_STRUCTURE_MODE_BUILD_KHR;
    scene->infos[update].dstAccelerationStructure = info.srcAccelerationStructure;
    scene_build_before(scene, update, 1);
    scene->infos[update] = info;
}

VkResult scene_copy(struct scene *scene, VkAccelerationStructureKHR src,
                    VkAccelerationStructureKHR dst, VkCopyAccelerationStructureModeKHR mode)
{
    const VkCopyAccelerationStructureInfoKHR info = copy_info(src, dst, mode);
    if (command_is_on_host(scene->command))
        return scene->vk->CopyAccelerationStructureKHR(scene->fixture->device, VK_NULL_HANDLE,
                                                       &info);
    const VkCommandBuffer command_buffer = scene_begin_before(scene);
    scene->vk->CmdCopyAccelerationStructureKHR(command_buffer, &info);
    scene_end_before(scene, command_buffer);
    return VK_SUCCESS;
}

uint32_t scene_reserve_build(struct scene *scene, uint32_t model)
{
    const uint32_t build = scene_add_build(scene, model);
    scene->info_count--;
    return build;
}
