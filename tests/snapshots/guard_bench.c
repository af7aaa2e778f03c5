/* SPDX-License-Identifier: Apache-2.0 */
/* What guarded builds cost the device: builds of a TLAS between two timestamps, without the layer,
 * at level content, and with setting guard. The argument is a platform. */
#include "tests/fixture/geometry.h"
#include "tests/snapshots/scene.h"

#include <stdio.h>
#include <string.h>

enum { ROUNDS = 15, ALIGNMENT = 256 };

#define INPUT VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_BIT_KHR

/* A build of `range.primitiveCount` elements of one geometry. It must not move. */
struct build {
    VkAccelerationStructureGeometryKHR geometry;
    VkAccelerationStructureBuildGeometryInfoKHR info;
    VkAccelerationStructureBuildRangeInfoKHR range;
};

static struct device_buffer storage(VkDeviceSize size, VkBufferUsageFlags usage)
{
    return fixture_buffer(size + ALIGNMENT, usage);
}

static VkDeviceAddress aligned(const struct device_buffer *buffer)
{
    return (buffer->address + ALIGNMENT - 1) / ALIGNMENT * ALIGNMENT;
}

/* ---- the scene: `count` instances of a box */

/* Creates the structure, and the scratch buffer. */
static void open_build(struct build *build, VkAccelerationStructureTypeKHR type)
{
    STRUCT(VkAccelerationStructureBuildSizesInfoKHR, sizes);
    build->info = MAKE(VkAccelerationStructureBuildGeometryInfoKHR, .type = type,
                       .geometryCount = 1, .pGeometries = &build->geometry);
    fixture.vk.GetAccelerationStructureBuildSizesKHR(
        fixture.device, VK_ACCELERATION_STRUCTURE_BUILD_TYPE_DEVICE_KHR, &build->info,
        &build->range.primitiveCount, &sizes);
    const VkDeviceSize size = sizes.accelerationStructureSize;
    const STRUCT(VkAccelerationStructureCreateInfoKHR, info, .size = size, .type = type,
                 .buffer =
                     storage(size, VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_STORAGE_BIT_KHR).handle);
    GET(fixture.vk.CreateAccelerationStructureKHR(fixture.device, &info, NULL,
                                                  &build->info.dstAccelerationStructure));
    const struct device_buffer scratch =
        storage(sizes.buildScratchSize, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT);
    build->info.scratchData.deviceAddress = aligned(&scratch);
}

static void close_build(const struct build *build)
{
    fixture.vk.DestroyAccelerationStructureKHR(fixture.device, build->info.dstAccelerationStructure,
                                               NULL);
}

static void record(VkCommandBuffer commands, const struct build *build)
{
    const VkAccelerationStructureBuildRangeInfoKHR *ranges = &build->range;
    fixture.vk.CmdBuildAccelerationStructuresKHR(commands, 1, &build->info, &ranges);
}

static void build_box(struct build *build)
{
    const struct device_buffer box = storage(sizeof(VkAabbPositionsKHR), INPUT);
    const VkAabbPositionsKHR bounds = {.maxX = 1, .maxY = 1, .maxZ = 1};
    memcpy(box.bytes, &bounds, sizeof(bounds));
    *build = (struct build){.geometry = boxes_geometry(box.address, sizeof(bounds)),
                            .range.primitiveCount = 1};
    open_build(build, VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR);
    VkCommandBuffer commands = fixture_begin();
    record(commands, build);
    fixture_finish(commands);
}

static void write_instances(unsigned char *bytes, uint32_t count, uint64_t reference)
{
    for (uint32_t i = 0; i < count; i++) {
        VkAccelerationStructureInstanceKHR instance = {.mask = 0xff,
                                                       .accelerationStructureReference = reference};
        for (int j = 0; j < 3; j++)
            instance.transform.matrix[j][j] = 1;
        instance.transform.matrix[0][3] = (float)(i % 1000) * 2;
        instance.transform.matrix[1][3] = (float)(i / 1000) * 2;
        memcpy(bytes + (size_t)i * sizeof(instance), &instance, sizeof(instance));
    }
}

/* ---- measuring */

/* Ticks between the timestamps around a build. */
static uint64_t time_build(const struct build *build, VkQueryPool queries)
{
    uint64_t ticks[2];
    VkCommandBuffer commands = fixture_begin();
    fixture.vk.CmdResetQueryPool(commands, queries, 0, 2);
    fixture.vk.CmdWriteTimestamp(commands, VK_PIPELINE_STAGE_BOTTOM_OF_PIPE_BIT, queries, 0);
    record(commands, build);
    commands_barrier(&fixture.vk, commands);
    fixture.vk.CmdWriteTimestamp(commands, VK_PIPELINE_STAGE_BOTTOM_OF_PIPE_BIT, queries, 1);
    fixture_finish(commands);
    GET(fixture.vk.GetQueryPoolResults(fixture.device, queries, 0, 2, sizeof(ticks), ticks,
                                       sizeof(ticks[0]), VK_QUERY_RESULT_64_BIT));
    return ticks[1] - ticks[0];
}

/* Milliseconds of a build: the fastest, because other work of the machine only adds to it. */
static double measure(uint32_t count, const struct instance_settings *settings)
{
    uint64_t best = UINT64_MAX;
    VkPhysicalDeviceProperties properties;
    struct build box, top = {.range.primitiveCount = count};
    fixture_open(settings);
    fixture.instance.vk.GetPhysicalDeviceProperties(fixture.instance.physical, &properties);
    build_box(&box);
    const struct device_buffer instances =
        storage((VkDeviceSize)count * sizeof(VkAccelerationStructureInstanceKHR), INPUT);
    write_instances(
        instances.bytes, count,
        structure_address(&fixture.vk, fixture.device, box.info.dstAccelerationStructure));
    top.geometry = instances_geometry(instances.address, false);
    open_build(&top, VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR);
    VkQueryPool queries =
        query_pool_create(&fixture.vk, fixture.device, VK_QUERY_TYPE_TIMESTAMP, 2);
    time_build(&top, queries);
    for (int i = 0; i < ROUNDS; i++) {
        uint64_t ticks = time_build(&top, queries);
        best = ticks < best ? ticks : best;
    }
    if (fixture.instance.messages.count)
        fprintf(stderr, "%s\n", fixture.instance.messages.items[0].text);
    fixture.vk.DestroyQueryPool(fixture.device, queries, NULL);
    close_build(&box);
    close_build(&top);
    fixture_close();
    return (double)best * (double)properties.limits.timestampPeriod / 1e6;
}

int main(int argc, char **argv)
{
    static const struct instance_settings kinds[] = {
        {.without_layer = true},
        {.level = "content", .budget_mib = "1024"},
        {.level = "content", .budget_mib = "1024", .guard = "references"},
    };
    const char *missing = platform_open(&platform, argc > 1 ? argv[1] : "lavapipe");
    if (missing) {
        printf("%s\n", missing);
        return 77;
    }
    printf("| instances | build | and copy (level content) | and guard | copy | guard |\n");
    printf("| --- | --- | --- | --- | --- | --- |\n");
    for (uint32_t count = 1000; count <= 1000000; count *= 10) {
        double times[3];
        for (int i = 0; i < 3; i++)
            times[i] = measure(count, &kinds[i]);
        printf("| %u | %.3f ms | %.3f ms | %.3f ms | %.1f M/s | %.1f M/s |\n", count, times[0],
               times[1], times[2], count / (times[1] - times[0]) / 1e3,
               count / (times[2] - times[1]) / 1e3);
    }
    return 0;
}
