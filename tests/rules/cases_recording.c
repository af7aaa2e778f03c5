/* SPDX-License-Identifier: Apache-2.0 */
/* What the command buffer is in the middle of: its state, and render pass instances. */
#include "case.h"

static uint32_t compute_family(const struct scene *scene)
{
    return fixture_find_family(scene->fixture, VK_QUEUE_COMPUTE_BIT | VK_QUEUE_GRAPHICS_BIT, 0);
}

/* ---- states ---- */

static void never_begin(struct scene *scene)
{
    scene->command_buffer = scene_command_buffer(scene, compute_family(scene));
}

static void reset(struct scene *scene)
{
    scene->vk->ResetCommandBuffer(scene->command_buffer, 0);
}

static VkCommandPool record_in_new_pool(struct scene *scene)
{
    const VkCommandPool pool = scene_pool(scene, compute_family(scene), 0);
    scene->command_buffer =
        scene_allocate_command_buffer(scene, pool, VK_COMMAND_BUFFER_LEVEL_PRIMARY);
    scene_begin(scene, scene->command_buffer, 0);
    return pool;
}

static void reset_pool(struct scene *scene)
{
    const VkCommandPool pool = record_in_new_pool(scene);
    expect_success(scene->vk->ResetCommandPool(scene->fixture->device, pool, 0),
                   "vkResetCommandPool");
}

static void begin(struct scene *scene, VkCommandBufferUsageFlags flags)
{
    scene_begin(scene, scene->command_buffer, flags);
}

static void submit_once(struct scene *scene)
{
    record_in_new_pool(scene);
    scene_begin(scene, scene->command_buffer, VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT);
    scene_end(scene, scene->command_buffer);
    scene_submit(scene, compute_family(scene), scene->command_buffer);
}

static VkCommandBuffer record_secondary(struct scene *scene)
{
    const VkCommandBuffer secondary = scene_allocate_command_buffer(
        scene, scene_pool(scene, compute_family(scene), 0), VK_COMMAND_BUFFER_LEVEL_SECONDARY);
    scene_begin(scene, secondary, 0);
    return secondary;
}

static void reset_executed_secondary(struct scene *scene)
{
    const VkCommandBuffer secondary = record_secondary(scene);
    scene_end(scene, secondary);
    scene->vk->CmdExecuteCommands(scene->command_buffer, 1, &secondary);
    scene->vk->ResetCommandBuffer(secondary, 0);
}

static void reset_secondary_before_execution(struct scene *scene)
{
    const VkCommandBuffer secondary = record_secondary(scene);
    scene_end(scene, secondary);
    scene->vk->ResetCommandBuffer(secondary, 0);
    scene_begin(scene, secondary, 0);
    scene_end(scene, secondary);
    scene->vk->CmdExecuteCommands(scene->command_buffer, 1, &secondary);
}

/* ---- render pass instances ---- */

static void end_render_pass(struct scene *scene)
{
    scene->vk->CmdEndRenderPass(scene->command_buffer);
}

static void end_render_pass2(struct scene *scene)
{
    const VkSubpassEndInfo end_info = {.sType = VK_STRUCTURE_TYPE_SUBPASS_END_INFO};
    scene_begin_render_pass2(scene, scene->command_buffer);
    if (scene->fixture->setup.route == ROUTE_KHR)
        scene->vk->CmdEndRenderPass2KHR(scene->command_buffer, &end_info);
    else
        scene->vk->CmdEndRenderPass2(scene->command_buffer, &end_info);
}

static void begin_rendering(struct scene *scene, VkRenderingFlags flags)
{
    scene_begin_rendering(scene, scene->command_buffer, flags);
}

static void continue_render_pass(struct scene *scene)
{
    const VkCommandBufferInheritanceInfo inheritance = {
        .sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_INHERITANCE_INFO,
        .renderPass = scene_render_pass(scene),
    };
    const VkCommandBufferBeginInfo begin_info = {
        .sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO,
        .flags = VK_COMMAND_BUFFER_USAGE_RENDER_PASS_CONTINUE_BIT,
        .pInheritanceInfo = &inheritance,
    };
    scene->command_buffer = scene_allocate_command_buffer(
        scene, scene_pool(scene, compute_family(scene), 0), VK_COMMAND_BUFFER_LEVEL_SECONDARY);
    expect_success(scene->vk->BeginCommandBuffer(scene->command_buffer, &begin_info),
                   "vkBeginCommandBuffer");
}

static void begin_secondary(struct scene *scene)
{
    scene->command_buffer = record_secondary(scene);
}

/* ---- suspension ---- */

static void render(struct scene *scene, VkRenderingFlags flags)
{
    scene_begin_rendering(scene, scene->command_buffer, flags);
    scene_end_rendering(scene, scene->command_buffer);
}

static void render_in_secondary(struct scene *scene, VkRenderingFlags flags)
{
    const VkCommandBuffer secondary = record_secondary(scene);
    scene_begin_rendering(scene, secondary, flags);
    scene_end_rendering(scene, secondary);
    scene_end(scene, secondary);
    scene->vk->CmdExecuteCommands(scene->command_buffer, 1, &secondary);
}

#define SUSPENDING VK_RENDERING_SUSPENDING_BIT
#define RESUMING VK_RENDERING_RESUMING_BIT
#define RESET_AND_BEGIN CALL(reset), CALL_WITH(begin, VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT)

static const struct setup by_extensions = {.route = ROUTE_KHR};

static const struct test_case cases[] = {
    SHARED(RULE(command_buffer_is_recording)),
    CASE("state_initial", .mutate = never_begin),
    CASE("state_executable", PREPARE_EDITS(RECORD(scene_end)), TWIN_EDITS(CALL_WITH(begin, 0))),
    CASE("state_executable_is_forwarded_if_the_callback_wants", EDITS(RECORD(scene_end)),
         .needs_null_driver = true, .forwards = true),
    CASE("state_reset", .mutate = reset, TWIN_EDITS(RESET_AND_BEGIN)),
    CASE("state_pool_reset", .prepare = reset_pool, TWIN_EDITS(CALL_WITH(begin, 0))),
    CASE("state_submitted_once", .prepare = submit_once, TWIN_EDITS(CALL_WITH(begin, 0))),
    CASE("state_invalid_by_reset_secondary", .mutate = reset_executed_secondary,
         .mutate_twin = reset_secondary_before_execution),

    SHARED(RULE(build_is_outside_render_pass)),
    CASE("render_pass", PREPARE_EDITS(RECORD(scene_begin_render_pass)),
         .mutate_twin = end_render_pass),
    CASE("render_pass_2", EDITS(RECORD(scene_begin_render_pass2)), .mutate_twin = end_render_pass2),
    CASE("render_pass_2_khr", .setup = &by_extensions, EDITS(RECORD(scene_begin_render_pass2)),
         .mutate_twin = end_render_pass2),
    CASE("dynamic_rendering", PREPARE_EDITS(CALL_WITH(begin_rendering, 0)),
         TWIN_EDITS(RECORD(scene_end_rendering))),
    CASE("dynamic_rendering_khr", .setup = &by_extensions,
         PREPARE_EDITS(CALL_WITH(begin_rendering, 0)), TWIN_EDITS(RECORD(scene_end_rendering))),
    CASE("render_pass_continued_by_secondary", .mutate = continue_render_pass,
         .mutate_twin = begin_secondary),
    CASE("render_pass_forgotten_by_reset", .silent = true,
         EDITS(RECORD(scene_begin_render_pass), RESET_AND_BEGIN)),
    /* A primary command buffer ignores that flag. */
    CASE("render_pass_continue_flag_of_a_primary", .silent = true,
         EDITS(RECORD(scene_end),
               CALL_WITH(begin, VK_COMMAND_BUFFER_USAGE_RENDER_PASS_CONTINUE_BIT))),
    CASE("render_pass_begun_to_be_suspended", EDITS(CALL_WITH(begin_rendering, SUSPENDING))),
    CASE("render_pass_resumed",
         EDITS(CALL_WITH(render, SUSPENDING), CALL_WITH(begin_rendering, RESUMING))),

    SHARED(RULE(build_is_not_between_suspended_render_passes)),
    CASE("suspended", PREPARE_EDITS(CALL_WITH(render, SUSPENDING)),
         TWIN_EDITS(CALL_WITH(render, RESUMING))),
    CASE("suspended_twice", PREPARE_EDITS(CALL_WITH(render, SUSPENDING)),
         EDITS(CALL_WITH(render, RESUMING | SUSPENDING)), TWIN_EDITS(RESET_AND_BEGIN)),
    CASE("suspended_khr", .setup = &by_extensions, PREPARE_EDITS(CALL_WITH(render, SUSPENDING)),
         TWIN_EDITS(CALL_WITH(render, RESUMING))),
    CASE("suspended_by_secondary", EDITS(CALL_WITH(render_in_secondary, SUSPENDING)),
         TWIN_EDITS(CALL_WITH(render, SUSPENDING), CALL_WITH(render_in_secondary, RESUMING))),
};

CASE_LIST(cases_recording, cases);
