/* SPDX-License-Identifier: Apache-2.0 */
/* A device with acceleration structures, buffers and command buffers; and a compute shader. */
#include "tests/snapshots/scene.h"

#include <string.h>

struct platform platform;
struct fixture fixture;

void fixture_open(const struct instance_settings *settings)
{
    static const char *const extensions[] = {VK_KHR_ACCELERATION_STRUCTURE_EXTENSION_NAME,
                                             VK_KHR_DEFERRED_HOST_OPERATIONS_EXTENSION_NAME};
    const STRUCT(VkPhysicalDeviceAccelerationStructureFeaturesKHR, structures,
                 .accelerationStructure = VK_TRUE);
    memset(&fixture, 0, sizeof(fixture));
    instance_fixture_create(&fixture.instance, &platform, settings);
    GET(instance_fixture_create_device(&fixture.instance, &structures, extensions, 2,
                                       &fixture.device, &fixture.vk));
    fixture.memory_type = instance_fixture_memory_type(&fixture.instance);
    fixture.vk.GetDeviceQueue(fixture.device, 0, 0, &fixture.queue);
    fixture.pool = command_pool_create(&fixture.vk, fixture.device);
}

void fixture_close(void)
{
    for (uint32_t i = 0; i < fixture.buffer_count; i++)
        buffer_destroy(&fixture.vk, fixture.device, &fixture.buffers[i]);
    fixture.vk.DestroyCommandPool(fixture.device, fixture.pool, NULL);
    fixture.vk.DestroyDevice(fixture.device, NULL);
    instance_fixture_close(&fixture.instance);
}

struct device_buffer fixture_buffer(VkDeviceSize size, VkBufferUsageFlags usage)
{
    const STRUCT(VkBufferCreateInfo, info, .size = size,
                 .usage = usage | VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT);
    assert_true(fixture.buffer_count < FIXTURE_BUFFERS);
    return fixture.buffers[fixture.buffer_count++] =
               buffer_create(&fixture.vk, fixture.device, fixture.memory_type, &info);
}

VkCommandBuffer fixture_begin(void)
{
    return commands_begin(&fixture.vk, fixture.device, fixture.pool,
                          VK_COMMAND_BUFFER_LEVEL_PRIMARY, 0, NULL);
}

void fixture_finish(VkCommandBuffer commands)
{
    commands_barrier(&fixture.vk, commands);
    GET(fixture.vk.EndCommandBuffer(commands));
    commands_run(&fixture.vk, fixture.device, fixture.queue, commands);
    fixture.vk.FreeCommandBuffers(fixture.device, fixture.pool, 1, &commands);
}

const char *unit_test_open(const char *name)
{
    return platform_open(&platform, name ? name : "null");
}

/* ---- a compute shader */

static VkPipelineLayout layout;
static VkPipeline pipeline;

void shader_open(const uint32_t *code, size_t code_size, uint32_t constants_size)
{
    fixture_open(&(struct instance_settings){.without_layer = true});
    layout = constants_layout_create(&fixture.vk, fixture.device, 0, constants_size);
    pipeline = compute_pipeline_create(&fixture.vk, fixture.device, layout, code, code_size);
}

void shader_run(const void *constants, uint32_t constants_size, uint32_t groups)
{
    VkCommandBuffer commands = fixture_begin();
    fixture.vk.CmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline);
    fixture.vk.CmdPushConstants(commands, layout, VK_SHADER_STAGE_COMPUTE_BIT, 0, constants_size,
                                constants);
    fixture.vk.CmdDispatch(commands, groups, 1, 1);
    fixture_finish(commands);
}

void shader_close(void)
{
    fixture.vk.DestroyPipeline(fixture.device, pipeline, NULL);
    fixture.vk.DestroyPipelineLayout(fixture.device, layout, NULL);
    fixture_close();
}
