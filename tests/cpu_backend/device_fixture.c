/* SPDX-License-Identifier: Apache-2.0 */
/* Command buffers, buffers, and builds with them. */
#include "device_fixture.h"
#include "tests/fixture/copies.h"

#include <stdlib.h>
#include <string.h>

const char *device_fixture_open(struct device_fixture *fixture, const char *platform)
{
    const char *reason = fixture_open(&fixture->fixture, platform);
    if (reason)
        return reason;
    fixture->fixture.vk.GetDeviceQueue(fixture->fixture.device, 0, 0, &fixture->queue);
    fixture->pool = command_pool_create(&fixture->fixture.vk, fixture->fixture.device);
    return NULL;
}

void device_fixture_close(struct device_fixture *fixture)
{
    fixture->fixture.vk.DestroyCommandPool(fixture->fixture.device, fixture->pool, NULL);
    fixture_close(&fixture->fixture);
}

/* ---- buffers */

struct device_buffer device_buffer_create(struct device_fixture *fixture, VkDeviceSize size)
{
    const STRUCT(VkBufferUsageFlags2CreateInfo, usage,
                 .usage = VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_BIT_KHR |
                          VK_BUFFER_USAGE_RAY_TRACING_BIT_NV | VK_BUFFER_USAGE_STORAGE_BUFFER_BIT |
                          VK_BUFFER_USAGE_CONDITIONAL_RENDERING_BIT_EXT |
                          VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT |
                          VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT |
                          VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT |
                          VK_BUFFER_USAGE_2_COMPRESSED_DATA_DGF1_BIT_AMDX);
    const STRUCT(VkBufferCreateInfo, info, .pNext = &usage, .size = size,
                 .usage = (VkBufferUsageFlags)usage.usage);
    return buffer_create(&fixture->fixture.vk, fixture->fixture.device,
                         fixture->fixture.host_memory_type, &info);
}

void device_buffer_destroy(struct device_fixture *fixture, struct device_buffer *buffer)
{
    buffer_destroy(&fixture->fixture.vk, fixture->fixture.device, buffer);
}

/* ---- command buffers */

VkCommandBuffer device_begin(struct device_fixture *fixture, VkCommandBufferLevel level)
{
    return commands_begin(&fixture->fixture.vk, fixture->fixture.device, fixture->pool, level, 0,
                          NULL);
}

void device_end(struct device_fixture *fixture, VkCommandBuffer commands)
{
    GET(fixture->fixture.vk.EndCommandBuffer(commands));
}

void device_run(struct device_fixture *fixture, VkCommandBuffer commands)
{
    commands_run(&fixture->fixture.vk, fixture->fixture.device, fixture->queue, commands);
}

void device_finish(struct device_fixture *fixture, VkCommandBuffer commands)
{
    device_end(fixture, commands);
    device_run(fixture, commands);
    fixture->fixture.vk.FreeCommandBuffers(fixture->fixture.device, fixture->pool, 1, &commands);
}

void device_barrier(struct device_fixture *fixture, VkCommandBuffer commands)
{
    commands_barrier(&fixture->fixture.vk, commands);
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

void device_copy(struct device_fixture *fixture, VkCommandBuffer commands,
                 VkAccelerationStructureKHR src, VkAccelerationStructureKHR dst,
                 VkCopyAccelerationStructureModeKHR mode)
{
    const VkCopyAccelerationStructureInfoKHR info = copy_info(src, dst, mode);
    fixture->fixture.vk.CmdCopyAccelerationStructureKHR(commands, &info);
}

void device_save(struct device_fixture *fixture, VkCommandBuffer commands,
                 VkAccelerationStructureKHR src, VkDeviceAddress dst)
{
    const VkCopyAccelerationStructureToMemoryInfoKHR info = serialize_info(src, dst);
    fixture->fixture.vk.CmdCopyAccelerationStructureToMemoryKHR(commands, &info);
}

void device_load(struct device_fixture *fixture, VkCommandBuffer commands, VkDeviceAddress src,
                 VkAccelerationStructureKHR dst)
{
    const VkCopyMemoryToAccelerationStructureInfoKHR info = deserialize_info(src, dst);
    fixture->fixture.vk.CmdCopyMemoryToAccelerationStructureKHR(commands, &info);
}

/* ---- asking */

uint64_t device_query(struct device_fixture *fixture, VkQueryPool pool, uint32_t query)
{
    uint64_t value = 0;
    GET(fixture->fixture.vk.GetQueryPoolResults(fixture->fixture.device, pool, query, 1,
                                                sizeof(value), &value, sizeof(value),
                                                VK_QUERY_RESULT_64_BIT));
    return value;
}

void device_expect_silence(struct device_fixture *fixture)
{
    messages_expect_none(&fixture->fixture.instance_fixture.messages);
}

void *device_serialize(struct device_fixture *fixture, VkAccelerationStructureKHR structure,
                       size_t *size)
{
    return fixture_serialize(&fixture->fixture, structure, size);
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
