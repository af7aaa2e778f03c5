/* SPDX-License-Identifier: Apache-2.0 */
/* Devices, buffers and command buffers. */
#include "tests/snapshots/fixture.h"

#include <string.h>

void fixture_open_with(struct fixture *fixture, const struct platform *platform,
                       const struct instance_settings *settings, void *chain, const char *extension)
{
    const char *const extensions[] = {VK_KHR_ACCELERATION_STRUCTURE_EXTENSION_NAME,
                                      VK_KHR_DEFERRED_HOST_OPERATIONS_EXTENSION_NAME, extension};
    const STRUCT(VkPhysicalDeviceAccelerationStructureFeaturesKHR, structures, .pNext = chain,
                 .accelerationStructure = VK_TRUE,
                 .accelerationStructureHostCommands = platform->is_cpu);
    memset(fixture, 0, sizeof(*fixture));
    instance_fixture_create(&fixture->instance, platform, settings);
    GET(instance_fixture_create_device(&fixture->instance, &structures, extensions,
                                       extension ? 3 : 2, &fixture->device, &fixture->vk));
    fixture->memory_type = instance_fixture_memory_type(&fixture->instance);
    fixture->vk.GetDeviceQueue(fixture->device, 0, 0, &fixture->queue);
    fixture->pool = command_pool_create(&fixture->vk, fixture->device);
}

void fixture_open(struct fixture *fixture, const struct platform *platform,
                  const struct instance_settings *settings)
{
    fixture_open_with(fixture, platform, settings, NULL, NULL);
}

void fixture_close(struct fixture *fixture)
{
    for (uint32_t i = 0; i < fixture->structure_count; i++)
        fixture->vk.DestroyAccelerationStructureKHR(fixture->device, fixture->structures[i], NULL);
    for (uint32_t i = 0; i < fixture->buffer_count; i++)
        buffer_destroy(&fixture->vk, fixture->device, &fixture->buffers[i]);
    fixture->vk.DestroyCommandPool(fixture->device, fixture->pool, NULL);
    fixture->vk.DestroyDevice(fixture->device, NULL);
    if (fixture->instance.platform->is_null)
        assert_int_equal(fixture->instance.platform->null_driver.invalid_queries(), 0);
    instance_fixture_close(&fixture->instance);
}

struct device_buffer fixture_buffer(struct fixture *fixture, VkDeviceSize size,
                                    VkBufferUsageFlags usage)
{
    const STRUCT(VkBufferCreateInfo, info, .size = size,
                 .usage = usage | VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT);
    assert_true(fixture->buffer_count < FIXTURE_OBJECTS);
    return fixture->buffers[fixture->buffer_count++] =
               buffer_create(&fixture->vk, fixture->device, fixture->memory_type, &info);
}

VkAccelerationStructureKHR fixture_structure(struct fixture *fixture,
                                             const struct device_buffer *buffer,
                                             VkDeviceSize offset, VkDeviceSize size,
                                             VkAccelerationStructureTypeKHR type)
{
    const STRUCT(VkAccelerationStructureCreateInfoKHR, info, .buffer = buffer->handle,
                 .offset = offset, .size = size, .type = type);
    VkAccelerationStructureKHR structure;
    GET(fixture->vk.CreateAccelerationStructureKHR(fixture->device, &info, NULL, &structure));
    assert_true(fixture->structure_count < FIXTURE_OBJECTS);
    return fixture->structures[fixture->structure_count++] = structure;
}

VkCommandBuffer fixture_begin(struct fixture *fixture, VkCommandBufferUsageFlags flags)
{
    return commands_begin(&fixture->vk, fixture->device, fixture->pool,
                          VK_COMMAND_BUFFER_LEVEL_PRIMARY, flags, NULL);
}

VkCommandBuffer fixture_begin_secondary(struct fixture *fixture, VkCommandBufferUsageFlags flags)
{
    return commands_begin(&fixture->vk, fixture->device, fixture->pool,
                          VK_COMMAND_BUFFER_LEVEL_SECONDARY, flags, NULL);
}

VkResult fixture_submit(struct fixture *fixture, VkCommandBuffer commands, VkFence fence)
{
    return commands_submit(&fixture->vk, fixture->queue, commands, fence);
}

void fixture_finish(struct fixture *fixture, VkCommandBuffer commands)
{
    GET(fixture->vk.EndCommandBuffer(commands));
    commands_run(&fixture->vk, fixture->device, fixture->queue, commands);
    fixture->vk.FreeCommandBuffers(fixture->device, fixture->pool, 1, &commands);
}

void fixture_barrier(struct fixture *fixture, VkCommandBuffer commands)
{
    commands_barrier(&fixture->vk, commands);
}

void fixture_build(struct fixture *fixture, VkCommandBuffer commands,
                   const struct fixture_build *build)
{
    VkAccelerationStructureBuildGeometryInfoKHR info = build->info;
    const VkAccelerationStructureBuildRangeInfoKHR *ranges = &build->range;
    info.sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_BUILD_GEOMETRY_INFO_KHR;
    info.geometryCount = 1;
    info.pGeometries = &build->geometry;
    fixture->vk.CmdBuildAccelerationStructuresKHR(commands, 1, &info, &ranges);
}

void fixture_build_boxes(struct fixture *fixture, VkCommandBuffer commands,
                         VkAccelerationStructureKHR dst, VkDeviceAddress boxes, uint32_t count,
                         VkDeviceAddress scratch)
{
    const struct fixture_build build = {
        .geometry = boxes_geometry(boxes, sizeof(VkAabbPositionsKHR)),
        .info = {.type = VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR,
                 .dstAccelerationStructure = dst,
                 .scratchData.deviceAddress = scratch},
        .range.primitiveCount = count,
    };
    fixture_build(fixture, commands, &build);
}

void fixture_expect_silence(const struct fixture *fixture)
{
    messages_expect_none(&fixture->instance.messages);
}
