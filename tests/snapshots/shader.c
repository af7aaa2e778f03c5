/* SPDX-License-Identifier: Apache-2.0 */
/* The device is that of programs, at a level where the layer passes all calls on. */
#include "tests/snapshots/shader.h"

#include "tests/player/play.h"

enum { BUFFERS = 8 };

static struct platform platform;
static struct play play;
static struct program program;
static struct device_buffer buffers[BUFFERS];
static uint32_t buffer_count;
static VkPipelineLayout layout;
static VkPipeline pipeline;

const char *unit_test_open(const char *name)
{
    return platform_open(&platform, name ? name : "null");
}

void shader_open(const uint32_t *code, size_t code_size, uint32_t constants_size)
{
    play = (struct play){.platform = &platform, .level = "parameters"};
    assert_true(play_begin(&play, &program));
    layout = constants_layout_create(&play.vk, play.device, 0, constants_size);
    pipeline = compute_pipeline_create(&play.vk, play.device, layout, code, code_size);
}

void shader_close(void)
{
    while (buffer_count > 0)
        buffer_destroy(&play.vk, play.device, &buffers[--buffer_count]);
    play.vk.DestroyPipeline(play.device, pipeline, NULL);
    play.vk.DestroyPipelineLayout(play.device, layout, NULL);
    messages_expect_none(&play.fixture.messages);
    play_end(&play);
    play_close(&play);
}

struct device_buffer shader_buffer(VkDeviceSize size)
{
    const STRUCT(VkBufferCreateInfo, info, .size = size,
                 .usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT |
                          VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT);
    assert_true(buffer_count < BUFFERS);
    return buffers[buffer_count++] = buffer_create(&play.vk, play.device, play.memory_type, &info);
}

void shader_run(const void *constants, uint32_t constants_size, uint32_t groups)
{
    VkCommandBuffer commands = commands_begin(&play.vk, play.device, play.pools[0],
                                              VK_COMMAND_BUFFER_LEVEL_PRIMARY, 0, NULL);
    play.vk.CmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline);
    play.vk.CmdPushConstants(commands, layout, VK_SHADER_STAGE_COMPUTE_BIT, 0, constants_size,
                             constants);
    play.vk.CmdDispatch(commands, groups, 1, 1);
    commands_barrier(&play.vk, commands);
    GET(play.vk.EndCommandBuffer(commands));
    commands_run(&play.vk, play.device, play.queues[0], commands);
    play.vk.FreeCommandBuffers(play.device, play.pools[0], 1, &commands);
}
