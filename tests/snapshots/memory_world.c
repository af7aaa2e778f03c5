/* SPDX-License-Identifier: Apache-2.0 */
/* Inputs of builds, structures, and a shader that writes. */
#include "memory_world.h"

#include <string.h>

static const uint32_t fill_code[] = {
#include "fill_comp.h"
};

static void create_fill(struct world *world)
{
    const VkuDeviceDispatchTable *vk = &world->stage.vk;
    VkDevice device = world->stage.device;
    const VkPushConstantRange range = {VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof(struct constants)};
    const VkPipelineLayoutCreateInfo layout = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO,
        .pushConstantRangeCount = 1,
        .pPushConstantRanges = &range,
    };
    const VkShaderModuleCreateInfo code = {
        .sType = VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO,
        .codeSize = sizeof(fill_code),
        .pCode = fill_code,
    };
    VkShaderModule module;
    GET(vk->CreatePipelineLayout(device, &layout, NULL, &world->layout));
    GET(vk->CreateShaderModule(device, &code, NULL, &module));
    const VkComputePipelineCreateInfo info = {
        .sType = VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO,
        .stage = {.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO,
                  .stage = VK_SHADER_STAGE_COMPUTE_BIT,
                  .module = module,
                  .pName = "main"},
        .layout = world->layout,
    };
    GET(vk->CreateComputePipelines(device, VK_NULL_HANDLE, 1, &info, NULL, &world->fill));
    vk->DestroyShaderModule(device, module, NULL);
}

static void write_instances(struct world *world)
{
    VkAccelerationStructureInstanceKHR instances[INSTANCES] = {0};
    uint64_t pointers[INSTANCES];
    for (uint32_t i = 0; i < INSTANCES; i++) {
        const VkAccelerationStructureDeviceAddressInfoKHR info = {
            .sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_DEVICE_ADDRESS_INFO_KHR,
            .accelerationStructure = world->blases[i % BLASES],
        };
        for (int j = 0; j < 3; j++)
            instances[i].transform.matrix[j][j] = 1;
        instances[i].mask = 0xff;
        instances[i].accelerationStructureReference =
            world->stage.vk.GetAccelerationStructureDeviceAddressKHR(world->stage.device, &info);
        pointers[i] = world->instances.address + i * sizeof(instances[0]);
    }
    memcpy(world->instances_written, instances, sizeof(instances));
    memcpy(world->instances_written + POINTERS_AT, pointers, sizeof(pointers));
    memcpy(world->instances.bytes, world->instances_written, sizeof(world->instances_written));
}

/* Only the first of the inputs can be copied from by the application. */
void world_open(struct world *world, const struct platform *platform, bool has_layer)
{
    const VkBufferUsageFlags input =
        VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_BIT_KHR |
        VK_BUFFER_USAGE_TRANSFER_DST_BIT | VK_BUFFER_USAGE_STORAGE_BUFFER_BIT;
    const struct stage_setup setup = {.has_layer = has_layer};
    struct stage *stage = &world->stage;
    stage_open(stage, platform, &setup);
    for (int i = 0; i < BUFFERS; i++)
        world->inputs[i] = stage_buffer(
            stage, SIZE, input | (i ? 0 : (VkBufferUsageFlags)VK_BUFFER_USAGE_TRANSFER_SRC_BIT));
    world->instances = stage_buffer(stage, sizeof(world->instances_written), input);
    world->scratch = stage_buffer(stage, SCRATCH_SIZE, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT);
    world->structures = stage_buffer(stage, (BLASES + 1) * STRUCTURE_SIZE,
                                     VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_STORAGE_BIT_KHR);
    for (int i = 0; i < BLASES; i++)
        world->blases[i] =
            stage_structure(stage, &world->structures, i * STRUCTURE_SIZE, STRUCTURE_SIZE,
                            VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR);
    world->tlas = stage_structure(stage, &world->structures, BLASES * STRUCTURE_SIZE,
                                  STRUCTURE_SIZE, VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR);
    world->conditions = stage_buffer(stage, 2 * sizeof(uint32_t),
                                     stage->has_conditional_rendering
                                         ? VK_BUFFER_USAGE_CONDITIONAL_RENDERING_BIT_EXT
                                         : VK_BUFFER_USAGE_STORAGE_BUFFER_BIT);
    ((uint32_t *)world->conditions.bytes)[1] = 1;
    write_instances(world);
    create_fill(world);
}

void world_close(struct world *world)
{
    const VkuDeviceDispatchTable *vk = &world->stage.vk;
    VkDevice device = world->stage.device;
    vk->DestroyPipeline(device, world->fill, NULL);
    vk->DestroyPipelineLayout(device, world->layout, NULL);
    for (int i = 0; i < BLASES; i++)
        vk->DestroyAccelerationStructureKHR(device, world->blases[i], NULL);
    vk->DestroyAccelerationStructureKHR(device, world->tlas, NULL);
    for (int i = 0; i < BUFFERS; i++)
        stage_destroy_buffer(&world->stage, &world->inputs[i]);
    stage_destroy_buffer(&world->stage, &world->instances);
    stage_destroy_buffer(&world->stage, &world->conditions);
    stage_destroy_buffer(&world->stage, &world->structures);
    stage_destroy_buffer(&world->stage, &world->scratch);
    stage_close(&world->stage);
}
