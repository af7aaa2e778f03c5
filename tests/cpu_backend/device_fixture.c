/* SPDX-License-Identifier: Apache-2.0 */
/* Command buffers, buffers, and builds with them. */
#include "device_fixture.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define GET(call) assert_int_equal(call, VK_SUCCESS)

const char *device_fixture_open(struct device_fixture *fixture, const char *platform)
{
    const char *reason = fixture_open(&fixture->fixture, platform);
    if (reason)
        return reason;
    const VkCommandPoolCreateInfo pool = {
        .sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO,
        .flags = VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT,
    };
    fixture->fixture.vk.GetDeviceQueue(fixture->fixture.device, 0, 0, &fixture->queue);
    GET(fixture->fixture.vk.CreateCommandPool(fixture->fixture.device, &pool, NULL,
                                              &fixture->pool));
    return NULL;
}

void device_fixture_close(struct device_fixture *fixture)
{
    fixture->fixture.vk.DestroyCommandPool(fixture->fixture.device, fixture->pool, NULL);
    fixture_close(&fixture->fixture);
}

int device_fixture_main(struct device_fixture *fixture, int argc, char **argv, int (*run_all)(void))
{
    const char *reason = argc == 2 ? device_fixture_open(fixture, argv[1]) : "name a platform";
    if (reason) {
        printf("skipped: %s\n", reason);
        return 77;
    }
    int failed = run_all();
    device_fixture_close(fixture);
    return failed;
}

/* ---- buffers */

struct device_buffer device_buffer_create(struct device_fixture *fixture, VkDeviceSize size)
{
    const VkuDeviceDispatchTable *vk = &fixture->fixture.vk;
    VkDevice device = fixture->fixture.device;
    struct device_buffer buffer = {0};
    const VkBufferUsageFlags2CreateInfo usage = {
        .sType = VK_STRUCTURE_TYPE_BUFFER_USAGE_FLAGS_2_CREATE_INFO,
        .usage = VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_BIT_KHR |
                 VK_BUFFER_USAGE_RAY_TRACING_BIT_NV | VK_BUFFER_USAGE_STORAGE_BUFFER_BIT |
                 VK_BUFFER_USAGE_CONDITIONAL_RENDERING_BIT_EXT |
                 VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT | VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT |
                 VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT |
                 VK_BUFFER_USAGE_2_COMPRESSED_DATA_DGF1_BIT_AMDX,
    };
    const VkBufferCreateInfo info = {.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO,
                                     .pNext = &usage,
                                     .size = size,
                                     .usage = (VkBufferUsageFlags)usage.usage};
    GET(vk->CreateBuffer(device, &info, NULL, &buffer.handle));
    VkMemoryRequirements requirements;
    vk->GetBufferMemoryRequirements(device, buffer.handle, &requirements);
    const VkMemoryAllocateFlagsInfo flags = {
        .sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_FLAGS_INFO,
        .flags = VK_MEMORY_ALLOCATE_DEVICE_ADDRESS_BIT,
    };
    const VkMemoryAllocateInfo memory = {.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO,
                                         .pNext = &flags,
                                         .allocationSize = requirements.size,
                                         .memoryTypeIndex = fixture->fixture.host_memory_type};
    GET(vk->AllocateMemory(device, &memory, NULL, &buffer.memory));
    GET(vk->BindBufferMemory(device, buffer.handle, buffer.memory, 0));
    GET(vk->MapMemory(device, buffer.memory, 0, VK_WHOLE_SIZE, 0, &buffer.bytes));
    memset(buffer.bytes, 0, size);
    const VkBufferDeviceAddressInfo address = {
        .sType = VK_STRUCTURE_TYPE_BUFFER_DEVICE_ADDRESS_INFO, .buffer = buffer.handle};
    buffer.address = vk->GetBufferDeviceAddress(device, &address);
    return buffer;
}

void device_buffer_destroy(struct device_fixture *fixture, struct device_buffer *buffer)
{
    fixture->fixture.vk.DestroyBuffer(fixture->fixture.device, buffer->handle, NULL);
    fixture->fixture.vk.FreeMemory(fixture->fixture.device, buffer->memory, NULL);
}

/* ---- command buffers */

VkCommandBuffer device_begin(struct device_fixture *fixture, VkCommandBufferLevel level)
{
    const VkCommandBufferAllocateInfo allocate = {
        .sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO,
        .commandPool = fixture->pool,
        .level = level,
        .commandBufferCount = 1,
    };
    const VkCommandBufferInheritanceInfo inheritance = {
        .sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_INHERITANCE_INFO};
    const VkCommandBufferBeginInfo begin = {
        .sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO,
        .pInheritanceInfo = &inheritance,
    };
    VkCommandBuffer commands;
    GET(fixture->fixture.vk.AllocateCommandBuffers(fixture->fixture.device, &allocate, &commands));
    GET(fixture->fixture.vk.BeginCommandBuffer(commands, &begin));
    return commands;
}

void device_end(struct device_fixture *fixture, VkCommandBuffer commands)
{
    GET(fixture->fixture.vk.EndCommandBuffer(commands));
}

void device_run(struct device_fixture *fixture, VkCommandBuffer commands)
{
    const VkuDeviceDispatchTable *vk = &fixture->fixture.vk;
    const VkFenceCreateInfo info = {.sType = VK_STRUCTURE_TYPE_FENCE_CREATE_INFO};
    const VkSubmitInfo submit = {
        .sType = VK_STRUCTURE_TYPE_SUBMIT_INFO,
        .commandBufferCount = 1,
        .pCommandBuffers = &commands,
    };
    VkFence fence;
    GET(vk->CreateFence(fixture->fixture.device, &info, NULL, &fence));
    GET(vk->QueueSubmit(fixture->queue, 1, &submit, fence));
    GET(vk->WaitForFences(fixture->fixture.device, 1, &fence, VK_TRUE, UINT64_MAX));
    vk->DestroyFence(fixture->fixture.device, fence, NULL);
}

void device_finish(struct device_fixture *fixture, VkCommandBuffer commands)
{
    device_end(fixture, commands);
    device_run(fixture, commands);
    fixture->fixture.vk.FreeCommandBuffers(fixture->fixture.device, fixture->pool, 1, &commands);
}

void device_barrier(struct device_fixture *fixture, VkCommandBuffer commands)
{
    const VkMemoryBarrier barrier = {
        .sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER,
        .srcAccessMask = VK_ACCESS_MEMORY_WRITE_BIT,
        .dstAccessMask = VK_ACCESS_MEMORY_READ_BIT | VK_ACCESS_MEMORY_WRITE_BIT,
    };
    fixture->fixture.vk.CmdPipelineBarrier(commands, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT,
                                           VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, 0, 1, &barrier, 0,
                                           NULL, 0, NULL);
}

/* ---- builds */

static VkDeviceOrHostAddressConstKHR *data_of(VkAccelerationStructureGeometryKHR *geometry)
{
    switch (geometry->geometryType) {
    case VK_GEOMETRY_TYPE_TRIANGLES_KHR:
        return &geometry->geometry.triangles.vertexData;
    case VK_GEOMETRY_TYPE_AABBS_KHR:
        return &geometry->geometry.aabbs.data;
    default:
        return &geometry->geometry.instances.data;
    }
}

void device_build_create(struct device_fixture *fixture, struct fixture_build *host,
                         VkDeviceSize size, struct device_build *build)
{
    enum { ALIGNMENT = 256 };
    const VkAccelerationStructureBuildSizesInfoKHR sizes = fixture_sizes(&fixture->fixture, host);
    const VkDeviceSize scratch = sizes.buildScratchSize > sizes.updateScratchSize
                                     ? sizes.buildScratchSize
                                     : sizes.updateScratchSize;
    *build = (struct device_build){.host = host,
                                   .size = size,
                                   .geometry = host->geometry,
                                   .info = host->info,
                                   .staging = device_buffer_create(fixture, size),
                                   .data = device_buffer_create(fixture, size),
                                   .scratch = device_buffer_create(fixture, scratch + ALIGNMENT)};
    data_of(&build->geometry)->deviceAddress = build->data.address;
    build->info.pGeometries = &build->geometry;
    build->info.scratchData.deviceAddress =
        (build->scratch.address + ALIGNMENT - 1) / ALIGNMENT * ALIGNMENT;
}

void device_build_destroy(struct device_fixture *fixture, struct device_build *build)
{
    device_buffer_destroy(fixture, &build->staging);
    device_buffer_destroy(fixture, &build->data);
    device_buffer_destroy(fixture, &build->scratch);
}

void device_upload(struct device_fixture *fixture, VkCommandBuffer commands,
                   struct device_build *build)
{
    const VkBufferCopy region = {0, 0, build->size};
    memcpy(build->staging.bytes, build->host->data, build->size);
    device_barrier(fixture, commands);
    fixture->fixture.vk.CmdCopyBuffer(commands, build->staging.handle, build->data.handle, 1,
                                      &region);
    device_barrier(fixture, commands);
}

void device_build(struct device_fixture *fixture, VkCommandBuffer commands,
                  struct device_build *build, VkAccelerationStructureKHR dst,
                  VkAccelerationStructureKHR src)
{
    const VkAccelerationStructureBuildRangeInfoKHR *ranges = &build->host->range;
    build->info.mode = src ? VK_BUILD_ACCELERATION_STRUCTURE_MODE_UPDATE_KHR
                           : VK_BUILD_ACCELERATION_STRUCTURE_MODE_BUILD_KHR;
    build->info.dstAccelerationStructure = dst;
    build->info.srcAccelerationStructure = src;
    fixture->fixture.vk.CmdBuildAccelerationStructuresKHR(commands, 1, &build->info, &ranges);
    device_barrier(fixture, commands);
}

/* ---- asking */

void device_expect_silence(struct device_fixture *fixture)
{
    const struct messages *messages = &fixture->fixture.instance_fixture.messages;
    for (uint32_t i = 0; i < messages_kept(messages); i++)
        print_error("%s: %s\n", messages->items[i].id, messages->items[i].text);
    assert_int_equal(messages->count, 0);
}

void *device_serialize(struct device_fixture *fixture, VkAccelerationStructureKHR structure,
                       size_t *size)
{
    const VkuDeviceDispatchTable *vk = &fixture->fixture.vk;
    const VkQueryType type = VK_QUERY_TYPE_ACCELERATION_STRUCTURE_SERIALIZATION_SIZE_KHR;
    VkDeviceSize value = 0;
    GET(vk->WriteAccelerationStructuresPropertiesKHR(fixture->fixture.device, 1, &structure, type,
                                                     sizeof(value), &value, sizeof(value)));
    void *bytes = aligned_alloc(16, (value + 15) / 16 * 16);
    const VkCopyAccelerationStructureToMemoryInfoKHR copy = {
        .sType = VK_STRUCTURE_TYPE_COPY_ACCELERATION_STRUCTURE_TO_MEMORY_INFO_KHR,
        .src = structure,
        .dst.hostAddress = bytes,
        .mode = VK_COPY_ACCELERATION_STRUCTURE_MODE_SERIALIZE_KHR,
    };
    GET(vk->CopyAccelerationStructureToMemoryKHR(fixture->fixture.device, VK_NULL_HANDLE, &copy));
    *size = value;
    return bytes;
}

void device_expect_same_bytes(struct device_fixture *fixture, VkAccelerationStructureKHR a,
                              VkAccelerationStructureKHR b)
{
    size_t size_a, size_b;
    void *bytes_a = device_serialize(fixture, a, &size_a);
    void *bytes_b = device_serialize(fixture, b, &size_b);
    assert_int_equal(size_a, size_b);
    assert_memory_equal(bytes_a, bytes_b, size_a);
    free(bytes_a);
    free(bytes_b);
}
