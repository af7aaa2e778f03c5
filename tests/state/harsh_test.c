/* SPDX-License-Identifier: Apache-2.0 */
/* Tests of the figures of setting limits = harsh: those that docs/harsh.md has, and what the
 * specification demands of sizes. */
#include "src/state/builds/harsh.h"

#include "tests/unit/unit_test.h"

typedef VkAccelerationStructureBuildSizesInfoKHR sizes_info;

#define HOST VK_ACCELERATION_STRUCTURE_BUILD_TYPE_HOST_KHR
#define DEVICE VK_ACCELERATION_STRUCTURE_BUILD_TYPE_DEVICE_KHR
#define EITHER VK_ACCELERATION_STRUCTURE_BUILD_TYPE_HOST_OR_DEVICE_KHR
#define BOTTOM VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR
#define TOP VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR
#define FLAG(name) VK_BUILD_ACCELERATION_STRUCTURE_##name
#define UPDATE FLAG(ALLOW_UPDATE_BIT_KHR)
#define LEAST (UPDATE | FLAG(PREFER_FAST_BUILD_BIT_KHR) | FLAG(LOW_MEMORY_BIT_KHR))

static sizes_info grown(sizes_info sizes, VkAccelerationStructureBuildTypeKHR build_type,
                        VkAccelerationStructureTypeKHR type,
                        VkBuildAccelerationStructureFlagsKHR flags)
{
    harsh_grow_build_sizes(&(struct harsh_build){build_type, type, flags, false}, &sizes);
    return sizes;
}

/* A multiple of 256 bytes and 104 more, so that what is placed behind it is misaligned. */
static VkDeviceSize rounded(VkDeviceSize size)
{
    return (size + 255) / 256 * 256 + 104;
}

TEST(sizes_have_the_shares_of_the_document)
{
    static const VkDeviceSize driver_sizes[] = {1536, 1537, 1ull << 56};
    const VkDeviceSize b = 700, u = 300;
    static const struct {
        struct harsh_build build;
        unsigned structure, scratch; /* shares */
    } rows[] = {
        {{DEVICE, BOTTOM, LEAST, false}, 2, 1},
        {{HOST, BOTTOM, LEAST, false}, 3, 0},
        {{EITHER, BOTTOM, LEAST, false}, 3, 1},
        {{DEVICE, TOP, LEAST, false}, 3, 2},
        {{DEVICE, BOTTOM, LEAST, true}, 3, 2},
        {{DEVICE, BOTTOM, LEAST & ~UPDATE, false}, 0, 3},
        {{DEVICE, BOTTOM, LEAST & ~FLAG(PREFER_FAST_BUILD_BIT_KHR), false}, 3, 1},
        {{DEVICE, BOTTOM, LEAST & ~FLAG(LOW_MEMORY_BIT_KHR), false}, 3, 2},
        {{DEVICE, BOTTOM, LEAST | FLAG(ALLOW_COMPACTION_BIT_KHR), false}, 3, 1},
        {{DEVICE, BOTTOM, LEAST | FLAG(PREFER_FAST_TRACE_BIT_KHR), false}, 4, 3},
        {{DEVICE, BOTTOM, LEAST | FLAG(MOTION_BIT_NV), false}, 6, 3},
        {{DEVICE, BOTTOM, LEAST | FLAG(ALLOW_OPACITY_MICROMAP_UPDATE_BIT_EXT), false}, 3, 1},
        {{DEVICE, BOTTOM, LEAST | FLAG(ALLOW_DISABLE_OPACITY_MICROMAPS_BIT_EXT), false}, 3, 1},
        {{DEVICE, BOTTOM, LEAST | FLAG(ALLOW_OPACITY_MICROMAP_DATA_UPDATE_BIT_EXT), false}, 3, 1},
        {{DEVICE, BOTTOM, LEAST | FLAG(ALLOW_DATA_ACCESS_BIT_KHR), false}, 4, 1},
    };
    for (size_t i = 0; i < sizeof(rows) / sizeof(rows[0]); i++)
        for (int j = 0; j < 3; j++) {
            const VkDeviceSize s = driver_sizes[j];
            sizes_info sizes = {
                .accelerationStructureSize = s, .buildScratchSize = b, .updateScratchSize = u};
            harsh_grow_build_sizes(&rows[i].build, &sizes);
            assert_int_equal(sizes.accelerationStructureSize,
                             rounded(2 * s + 256 + rows[i].structure * (s / 8 + 256)));
            assert_int_equal(sizes.buildScratchSize,
                             rounded(b + s / 4 + 1024 + rows[i].scratch * (s / 16 + 256)));
            assert_int_equal(sizes.updateScratchSize,
                             rows[i].build.flags & UPDATE ? rounded(u + s / 16 + 256) : u);
        }
}

/* Drivers return no size for builds that they do not support, and nothing is as large as the other
 * sizes. */
TEST(some_sizes_stay_the_same)
{
    static const VkDeviceSize large = (1ull << 56) + 1;
    static const VkDeviceSize rows[][3] = {{0, 0, 0}, {large, 1, 1}, {1, large, 1}, {1, 1, large}};
    for (size_t i = 0; i < sizeof(rows) / sizeof(rows[0]); i++) {
        const sizes_info driver = {.accelerationStructureSize = rows[i][0],
                                   .buildScratchSize = rows[i][1],
                                   .updateScratchSize = rows[i][2]};
        const sizes_info same = grown(driver, DEVICE, BOTTOM, UPDATE);
        assert_int_equal(same.accelerationStructureSize, rows[i][0]);
        assert_int_equal(same.buildScratchSize, rows[i][1]);
        assert_int_equal(same.updateScratchSize, rows[i][2]);
    }
}

TEST(limits_are_those_of_the_strictest_device)
{
    VkPhysicalDeviceAccelerationStructurePropertiesKHR limits = {
        .maxGeometryCount = UINT64_MAX,
        .maxInstanceCount = 1 << 10,
        .maxPrimitiveCount = UINT32_MAX,
        .minAccelerationStructureScratchOffsetAlignment = 8};
    harsh_limit_structures(&limits);
    assert_int_equal(limits.maxGeometryCount, (1 << 24) - 1);
    assert_int_equal(limits.maxInstanceCount, 1 << 10);
    assert_int_equal(limits.maxPrimitiveCount, (1 << 29) - 1);
    assert_int_equal(limits.minAccelerationStructureScratchOffsetAlignment, 256);
    limits.minAccelerationStructureScratchOffsetAlignment = 512;
    harsh_limit_structures(&limits);
    assert_int_equal(limits.minAccelerationStructureScratchOffsetAlignment, 512);
}

TEST(micromaps_grow_as_structures_do)
{
    static const struct {
        VkBuildMicromapFlagsEXT micromap;
        VkBuildAccelerationStructureFlagsKHR structure;
    } rows[] = {
        {0, 0},
        {VK_BUILD_MICROMAP_ALLOW_COMPACTION_BIT_EXT, FLAG(ALLOW_COMPACTION_BIT_KHR)},
        {VK_BUILD_MICROMAP_PREFER_FAST_TRACE_BIT_EXT, FLAG(PREFER_FAST_TRACE_BIT_KHR)},
        {VK_BUILD_MICROMAP_PREFER_FAST_BUILD_BIT_EXT, FLAG(PREFER_FAST_BUILD_BIT_KHR)},
    };
    const sizes_info driver = {.accelerationStructureSize = 4096, .buildScratchSize = 100};
    for (size_t i = 0; i < sizeof(rows) / sizeof(rows[0]); i++) {
        VkMicromapBuildSizesInfoEXT micromap = {.micromapSize = 4096, .buildScratchSize = 100};
        const sizes_info structure = grown(driver, DEVICE, BOTTOM, rows[i].structure);
        harsh_grow_micromap_sizes(DEVICE, rows[i].micromap, &micromap);
        assert_int_equal(micromap.micromapSize, structure.accelerationStructureSize);
        assert_int_equal(micromap.buildScratchSize, structure.buildScratchSize);
    }
}

TEST(requirements_of_nv_structures_grow)
{
#define OF(name) VK_ACCELERATION_STRUCTURE_MEMORY_REQUIREMENTS_TYPE_##name
    static const struct {
        VkAccelerationStructureMemoryRequirementsTypeNV type;
        VkDeviceSize driver_size, size, alignment;
    } rows[] = {
        {OF(OBJECT_NV), 1000, 2304, 64 * 1024},
        {OF(BUILD_SCRATCH_NV), 1000, 2560, 256},
        {OF(UPDATE_SCRATCH_NV), 1000, 1536, 256},
        {OF(UPDATE_SCRATCH_NV), 0, 0, 256},
        {OF(OBJECT_NV), (1ull << 56) + 1, (1ull << 56) + 1, 256},
    };
    for (size_t i = 0; i < sizeof(rows) / sizeof(rows[0]); i++) {
        VkMemoryRequirements requirements = {rows[i].driver_size, 256, 6};
        harsh_grow_requirements(rows[i].type, &requirements);
        assert_int_equal(requirements.size, rows[i].size);
        assert_int_equal(requirements.alignment, rows[i].alignment);
        assert_int_equal(requirements.memoryTypeBits, 6);
    }
}
