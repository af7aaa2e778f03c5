/* SPDX-License-Identifier: Apache-2.0 */
/* Inputs of builds, structures, and a shader that writes. */
#include "tests/snapshots/memory_fixture.h"

#include <string.h>

static const uint32_t fill_code[] = {
#include "fill_comp.h"
};

static void write_instances(struct memory_fixture *memory_fixture)
{
    VkAccelerationStructureInstanceKHR instances[INSTANCES] = {0};
    uint64_t pointers[INSTANCES];
    for (uint32_t i = 0; i < INSTANCES; i++) {
        for (int j = 0; j < 3; j++)
            instances[i].transform.matrix[j][j] = 1;
        instances[i].mask = 0xff;
        instances[i].accelerationStructureReference =
            structure_address(&memory_fixture->fixture.vk, memory_fixture->fixture.device,
                              memory_fixture->blases[i % BLASES]);
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
    const struct instance_settings settings = {.level = "content", .without_layer = !has_layer};
    struct fixture *fixture = &memory_fixture->fixture;
    fixture_open(fixture, platform, &settings);
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
                                                instance_fixture_has_conditions(&fixture->instance)
                                                    ? VK_BUFFER_USAGE_CONDITIONAL_RENDERING_BIT_EXT
                                                    : VK_BUFFER_USAGE_STORAGE_BUFFER_BIT);
    ((uint32_t *)memory_fixture->conditions.bytes)[1] = 1;
    write_instances(memory_fixture);
    for (int i = 0; i < 2; i++)
        memory_fixture->layouts[i] =
            constants_layout_create(&fixture->vk, fixture->device, 0, sizeof(struct constants));
    memory_fixture->fill = compute_pipeline_create(
        &fixture->vk, fixture->device, memory_fixture->layouts[0], fill_code, sizeof(fill_code));
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
