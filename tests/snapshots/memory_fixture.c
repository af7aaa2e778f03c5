/* SPDX-License-Identifier: Apache-2.0 */
/* Inputs of builds, structures, and a shader that writes. */
#include "tests/snapshots/memory_fixture.h"

#include <string.h>

static const uint32_t fill_code[] = {
#include "fill_comp.h"
};

static void create_fill(struct memory_fixture *memory_fixture)
{
    const VkuDeviceDispatchTable *vk = &memory_fixture->fixture.vk;
    VkDevice device = memory_fixture->fixture.device;
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
    for (int i = 0; i < 2; i++)
        GET(vk->CreatePipelineLayout(device, &layout, NULL, &memory_fixture->layouts[i]));
    GET(vk->CreateShaderModule(device, &code, NULL, &module));
    const VkComputePipelineCreateInfo info = {
        .sType = VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO,
        .stage = {.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO,
                  .stage = VK_SHADER_STAGE_COMPUTE_BIT,
                  .module = module,
                  .pName = "main"},
        .layout = memory_fixture->layouts[0],
    };
    GET(vk->CreateComputePipelines(device, VK_NULL_HANDLE, 1, &info, NULL, &memory_fixture->fill));
    vk->DestroyShaderModule(device, module, NULL);
}

static void write_instances(struct memory_fixture *memory_fixture)
{
    VkAccelerationStructureInstanceKHR instances[INSTANCES] = {0};
    uint64_t pointers[INSTANCES];
    for (uint32_t i = 0; i < INSTANCES; i++) {
        const VkAccelerationStructureDeviceAddressInfoKHR info = {
            .sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_DEVICE_ADDRESS_INFO_KHR,
            .accelerationStructure = memory_fixture->blases[i % BLASES],
        };
        for (int j = 0; j < 3; j++)
            instances[i].transform.matrix[j][j] = 1;
        instances[i].mask = 0xff;
        instances[i].accelerationStructureReference =
            memory_fixture->fixture.vk.GetAccelerationStructureDeviceAddressKHR(
                memory_fixture->fixture.device, &info);
        pointers[i] = memory_fixture->instances.address + i * sizeof(instances[0]);
    }
    memcpy(memory_fixture->instances_written, instances, sizeof(instances));
    memcpy(memory_fixture->instances_written + POINTERS_AT, pointers, sizeof(pointers));
    memcpy(memory_fixture->instances.bytes, memory_fixture->instances_written,
           sizeof(memory_fixture->instances_written));
}

/* Only the first of the inputs can be copied from by the application. */
void memory_fixture_open(struct memory_fixture *memory_fixture, const struct platform *platform,
                         bool has_layer)
{
    const VkBufferUsageFlags input =
        VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_BIT_KHR |
        VK_BUFFER_USAGE_TRANSFER_DST_BIT | VK_BUFFER_USAGE_STORAGE_BUFFER_BIT;
    const struct fixture_setup setup = {.has_layer = has_layer};
    struct fixture *fixture = &memory_fixture->fixture;
    fixture_open(fixture, platform, &setup);
    for (int i = 0; i < BUFFERS; i++)
        memory_fixture->inputs[i] = fixture_buffer(
            fixture, SIZE, input | (i ? 0 : (VkBufferUsageFlags)VK_BUFFER_USAGE_TRANSFER_SRC_BIT));
    memory_fixture->instances =
        fixture_buffer(fixture, sizeof(memory_fixture->instances_written), input);
    memory_fixture->scratch =
        fixture_buffer(fixture, SCRATCH_SIZE, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT);
    memory_fixture->structures =
        fixture_buffer(fixture, (BLASES + 1) * STRUCTURE_SIZE,
                       VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_STORAGE_BIT_KHR);
    for (int i = 0; i < BLASES; i++)
        memory_fixture->blases[i] =
            fixture_structure(fixture, &memory_fixture->structures, i * STRUCTURE_SIZE,
                              STRUCTURE_SIZE, VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR);
    memory_fixture->tlas =
        fixture_structure(fixture, &memory_fixture->structures, BLASES * STRUCTURE_SIZE,
                          STRUCTURE_SIZE, VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR);
    memory_fixture->conditions = fixture_buffer(fixture, 2 * sizeof(uint32_t),
                                                fixture->has_conditional_rendering
                                                    ? VK_BUFFER_USAGE_CONDITIONAL_RENDERING_BIT_EXT
                                                    : VK_BUFFER_USAGE_STORAGE_BUFFER_BIT);
    ((uint32_t *)memory_fixture->conditions.bytes)[1] = 1;
    write_instances(memory_fixture);
    create_fill(memory_fixture);
}

void memory_fixture_close(struct memory_fixture *memory_fixture)
{
    const VkuDeviceDispatchTable *vk = &memory_fixture->fixture.vk;
    VkDevice device = memory_fixture->fixture.device;
    vk->DestroyPipeline(device, memory_fixture->fill, NULL);
    for (int i = 0; i < 2; i++)
        vk->DestroyPipelineLayout(device, memory_fixture->layouts[i], NULL);
    for (int i = 0; i < BLASES; i++)
        vk->DestroyAccelerationStructureKHR(device, memory_fixture->blases[i], NULL);
    vk->DestroyAccelerationStructureKHR(device, memory_fixture->tlas, NULL);
    for (int i = 0; i < BUFFERS; i++)
        fixture_destroy_buffer(&memory_fixture->fixture, &memory_fixture->inputs[i]);
    fixture_destroy_buffer(&memory_fixture->fixture, &memory_fixture->instances);
    fixture_destroy_buffer(&memory_fixture->fixture, &memory_fixture->conditions);
    fixture_destroy_buffer(&memory_fixture->fixture, &memory_fixture->structures);
    fixture_destroy_buffer(&memory_fixture->fixture, &memory_fixture->scratch);
    fixture_close(&memory_fixture->fixture);
}
