/* SPDX-License-Identifier: Apache-2.0 */
/* What guarded builds cost the device: builds of a TLAS between two timestamps, without the layer,
 * at level content, and with setting guard. The argument is a platform. */
#include "tests/snapshots/scene.h"

#include <stdio.h>
#include <string.h>

enum { ROUNDS = 15, BOX_STRUCTURE_SIZE = 1 << 16, ALIGNMENT = 256 };

static struct device_buffer storage(VkDeviceSize size, VkBufferUsageFlags usage)
{
    return fixture_buffer(&fixture, size + ALIGNMENT, usage);
}

static VkDeviceAddress aligned(const struct device_buffer *buffer)
{
    return (buffer->address + ALIGNMENT - 1) / ALIGNMENT * ALIGNMENT;
}

/* ---- the scene: `count` instances of a box */

static VkAccelerationStructureKHR build_box(void)
{
    const VkBufferUsageFlags input =
        VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_BIT_KHR;
    struct device_buffer box = storage(sizeof(VkAabbPositionsKHR), input),
                         memory = storage(BOX_STRUCTURE_SIZE,
                                          VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_STORAGE_BIT_KHR),
                         scratch = storage(BOX_STRUCTURE_SIZE, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT);
    const VkAabbPositionsKHR bounds = {.maxX = 1, .maxY = 1, .maxZ = 1};
    memcpy(box.bytes, &bounds, sizeof(bounds));
    VkAccelerationStructureKHR structure = fixture_structure(
        &fixture, &memory, 0, BOX_STRUCTURE_SIZE, VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR);
    VkCommandBuffer commands = fixture_begin(&fixture, 0);
    fixture_build_boxes(&fixture, commands, structure, box.address, 1, aligned(&scratch));
    fixture_finish(&fixture, commands);
    return structure;
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

static struct fixture_build describe(uint32_t count, const struct device_buffer *instances)
{
    struct fixture_build build = {
        .geometry = instances_geometry(instances->address, false),
        .info = {.sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_BUILD_GEOMETRY_INFO_KHR,
                 .type = VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR,
                 .geometryCount = 1},
        .range.primitiveCount = count,
    };
    build.info.pGeometries = &build.geometry;
    STRUCT(VkAccelerationStructureBuildSizesInfoKHR, sizes);
    fixture.vk.GetAccelerationStructureBuildSizesKHR(
        fixture.device, VK_ACCELERATION_STRUCTURE_BUILD_TYPE_DEVICE_KHR, &build.info, &count,
        &sizes);
    struct device_buffer memory = storage(sizes.accelerationStructureSize,
                                          VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_STORAGE_BIT_KHR),
                         scratch =
                             storage(sizes.buildScratchSize, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT);
    build.info.dstAccelerationStructure =
        fixture_structure(&fixture, &memory, 0, sizes.accelerationStructureSize,
                          VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR);
    build.info.scratchData.deviceAddress = aligned(&scratch);
    return build;
}

/* ---- measuring */

/* Ticks between the timestamps around a build. */
static uint64_t time_build(const struct fixture_build *build, VkQueryPool queries)
{
    uint64_t ticks[2];
    VkCommandBuffer commands = fixture_begin(&fixture, 0);
    fixture.vk.CmdResetQueryPool(commands, queries, 0, 2);
    fixture.vk.CmdWriteTimestamp(commands, VK_PIPELINE_STAGE_BOTTOM_OF_PIPE_BIT, queries, 0);
    fixture_build(&fixture, commands, build);
    fixture_barrier(&fixture, commands);
    fixture.vk.CmdWriteTimestamp(commands, VK_PIPELINE_STAGE_BOTTOM_OF_PIPE_BIT, queries, 1);
    fixture_finish(&fixture, commands);
    GET(fixture.vk.GetQueryPoolResults(fixture.device, queries, 0, 2, sizeof(ticks), ticks,
                                       sizeof(ticks[0]), VK_QUERY_RESULT_64_BIT));
    return ticks[1] - ticks[0];
}

/* Milliseconds of a build: the fastest, because other work of the machine only adds to it. */
static double measure(uint32_t count, const struct instance_settings *settings)
{
    uint64_t best = UINT64_MAX;
    VkPhysicalDeviceProperties properties;
    fixture_open(&fixture, &platform, settings);
    fixture.instance.vk.GetPhysicalDeviceProperties(fixture.instance.physical, &properties);
    uint64_t reference = structure_address(&fixture.vk, fixture.device, build_box());
    struct device_buffer instances =
        storage((VkDeviceSize)count * sizeof(VkAccelerationStructureInstanceKHR),
                VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_BIT_KHR);
    write_instances(instances.bytes, count, reference);
    const struct fixture_build build = describe(count, &instances);
    VkQueryPool queries =
        query_pool_create(&fixture.vk, fixture.device, VK_QUERY_TYPE_TIMESTAMP, 2);
    time_build(&build, queries);
    for (int i = 0; i < ROUNDS; i++) {
        uint64_t ticks = time_build(&build, queries);
        best = ticks < best ? ticks : best;
    }
    if (fixture.instance.messages.count)
        fprintf(stderr, "%s\n", fixture.instance.messages.items[0].text);
    fixture.vk.DestroyQueryPool(fixture.device, queries, NULL);
    fixture_close(&fixture);
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
