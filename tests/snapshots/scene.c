/* SPDX-License-Identifier: Apache-2.0 */
/* Devices, buffers and command buffers; a BLAS of boxes, and a TLAS of an instance of it. */
#include "tests/snapshots/scene.h"

#include <string.h>

void fixture_open_with(struct fixture *own, const struct platform *on,
                       const struct instance_settings *settings, void *chain, const char *extension)
{
    const char *const extensions[] = {VK_KHR_ACCELERATION_STRUCTURE_EXTENSION_NAME,
                                      VK_KHR_DEFERRED_HOST_OPERATIONS_EXTENSION_NAME, extension};
    const STRUCT(VkPhysicalDeviceAccelerationStructureFeaturesKHR, structures, .pNext = chain,
                 .accelerationStructure = VK_TRUE, .accelerationStructureHostCommands = on->is_cpu);
    memset(own, 0, sizeof(*own));
    instance_fixture_create(&own->instance, on, settings);
    GET(instance_fixture_create_device(&own->instance, &structures, extensions, extension ? 3 : 2,
                                       &own->device, &own->vk));
    own->memory_type = instance_fixture_memory_type(&own->instance);
    own->vk.GetDeviceQueue(own->device, 0, 0, &own->queue);
    own->pool = command_pool_create(&own->vk, own->device);
}

void fixture_open(struct fixture *own, const struct platform *on,
                  const struct instance_settings *settings)
{
    fixture_open_with(own, on, settings, NULL, NULL);
}

void fixture_close(struct fixture *own)
{
    for (uint32_t i = 0; i < own->structure_count; i++)
        own->vk.DestroyAccelerationStructureKHR(own->device, own->structures[i], NULL);
    for (uint32_t i = 0; i < own->buffer_count; i++)
        buffer_destroy(&own->vk, own->device, &own->buffers[i]);
    own->vk.DestroyCommandPool(own->device, own->pool, NULL);
    own->vk.DestroyDevice(own->device, NULL);
    if (own->instance.platform->is_null)
        assert_int_equal(own->instance.platform->null_driver.invalid_queries(), 0);
    instance_fixture_close(&own->instance);
}

struct device_buffer fixture_buffer(struct fixture *own, VkDeviceSize size,
                                    VkBufferUsageFlags usage)
{
    const STRUCT(VkBufferCreateInfo, info, .size = size,
                 .usage = usage | VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT);
    assert_true(own->buffer_count < FIXTURE_OBJECTS);
    return own->buffers[own->buffer_count++] =
               buffer_create(&own->vk, own->device, own->memory_type, &info);
}

VkAccelerationStructureKHR fixture_structure(struct fixture *own,
                                             const struct device_buffer *buffer,
                                             VkDeviceSize offset, VkDeviceSize size,
                                             VkAccelerationStructureTypeKHR type)
{
    const STRUCT(VkAccelerationStructureCreateInfoKHR, info, .buffer = buffer->handle,
                 .offset = offset, .size = size, .type = type);
    VkAccelerationStructureKHR structure;
    GET(own->vk.CreateAccelerationStructureKHR(own->device, &info, NULL, &structure));
    assert_true(own->structure_count < FIXTURE_OBJECTS);
    return own->structures[own->structure_count++] = structure;
}

VkCommandBuffer fixture_begin(struct fixture *own, VkCommandBufferUsageFlags flags)
{
    return commands_begin(&own->vk, own->device, own->pool, VK_COMMAND_BUFFER_LEVEL_PRIMARY, flags,
                          NULL);
}

VkResult fixture_submit(struct fixture *own, VkCommandBuffer commands, VkFence fence)
{
    return commands_submit(&own->vk, own->queue, commands, fence);
}

void fixture_finish(struct fixture *own, VkCommandBuffer commands)
{
    GET(own->vk.EndCommandBuffer(commands));
    commands_run(&own->vk, own->device, own->queue, commands);
    own->vk.FreeCommandBuffers(own->device, own->pool, 1, &commands);
}

void fixture_barrier(struct fixture *own, VkCommandBuffer commands)
{
    commands_barrier(&own->vk, commands);
}

void fixture_build(struct fixture *own, VkCommandBuffer commands, const struct fixture_build *build)
{
    VkAccelerationStructureBuildGeometryInfoKHR info = build->info;
    const VkAccelerationStructureBuildRangeInfoKHR *ranges = &build->range;
    info.sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_BUILD_GEOMETRY_INFO_KHR;
    info.geometryCount = 1;
    info.pGeometries = &build->geometry;
    own->vk.CmdBuildAccelerationStructuresKHR(commands, 1, &info, &ranges);
}

void fixture_build_boxes(struct fixture *own, VkCommandBuffer commands,
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
    fixture_build(own, commands, &build);
}

/* ---- the device of a test program */

struct platform platform;
struct fixture fixture;
struct scene scene;

enum { SCRATCH_ALIGNMENT = 256 };

void scene_open(const struct scene_setup *setup)
{
    const VkDeviceSize size = setup->structure_size;
    struct instance_settings settings = setup->settings;
    if (!settings.level)
        settings.level = "content";
    fixture_open(&fixture, &platform, &settings);
    scene = (struct scene){
        .boxes = scene_input(setup->boxes_size),
        .structures = fixture_buffer(&fixture, (1 + setup->has_tlas) * size,
                                     VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_STORAGE_BIT_KHR),
        .scratch = fixture_buffer(&fixture, size, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT),
    };
    scene.scratch_address =
        (scene.scratch.address + SCRATCH_ALIGNMENT - 1) / SCRATCH_ALIGNMENT * SCRATCH_ALIGNMENT;
    scene.blas = fixture_structure(&fixture, &scene.structures, 0, size,
                                   VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR);
    if (setup->has_tlas)
        scene.tlas = fixture_structure(&fixture, &scene.structures, size, size,
                                       VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR);
}

void scene_close(void)
{
    fixture_close(&fixture);
}

struct device_buffer scene_input(VkDeviceSize size)
{
    return fixture_buffer(&fixture, size,
                          VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_BIT_KHR);
}

void scene_build_boxes(VkCommandBuffer commands, uint32_t count)
{
    fixture_build_boxes(&fixture, commands, scene.blas, scene.boxes.address, count,
                        scene.scratch_address);
    fixture_barrier(&fixture, commands);
}

VkCommandBuffer scene_record_boxes(VkCommandBufferUsageFlags flags, uint32_t count)
{
    VkCommandBuffer commands = fixture_begin(&fixture, flags);
    scene_build_boxes(commands, count);
    return commands;
}

void scene_submit(VkCommandBuffer commands)
{
    GET(fixture.vk.EndCommandBuffer(commands));
    GET(fixture_submit(&fixture, commands, VK_NULL_HANDLE));
}

void scene_write_instance(const struct device_buffer *buffer, bool is_valid)
{
    VkAccelerationStructureInstanceKHR written = {
        .mask = 0xff,
        .accelerationStructureReference =
            structure_address(&fixture.vk, fixture.device, scene.blas),
    };
    for (int i = 0; i < 3; i++)
        written.transform.matrix[i][i] = is_valid ? 1 : 0;
    memcpy(buffer->bytes, &written, sizeof(written));
}

void scene_build_instance(VkCommandBuffer commands, VkDeviceAddress data, bool is_pointer)
{
    const struct fixture_build build = {
        .geometry = instances_geometry(data, is_pointer),
        .info = {.type = VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR,
                 .dstAccelerationStructure = scene.tlas,
                 .scratchData.deviceAddress = scene.scratch_address},
        .range.primitiveCount = 1,
    };
    fixture_build(&fixture, commands, &build);
}

void scene_invalidate_box(uint32_t i)
{
    ((VkAabbPositionsKHR *)scene.boxes.bytes)[i] = (VkAabbPositionsKHR){.minX = 1, .maxX = -1};
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
    fixture_open(&fixture, &platform, &(struct instance_settings){.without_layer = true});
    layout = constants_layout_create(&fixture.vk, fixture.device, 0, constants_size);
    pipeline = compute_pipeline_create(&fixture.vk, fixture.device, layout, code, code_size);
}

void shader_run(const void *constants, uint32_t constants_size, uint32_t groups)
{
    VkCommandBuffer commands = fixture_begin(&fixture, 0);
    fixture.vk.CmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline);
    fixture.vk.CmdPushConstants(commands, layout, VK_SHADER_STAGE_COMPUTE_BIT, 0, constants_size,
                                constants);
    fixture.vk.CmdDispatch(commands, groups, 1, 1);
    fixture_barrier(&fixture, commands);
    fixture_finish(&fixture, commands);
}

void shader_close(void)
{
    fixture.vk.DestroyPipeline(fixture.device, pipeline, NULL);
    fixture.vk.DestroyPipelineLayout(fixture.device, layout, NULL);
    fixture_close(&fixture);
}
