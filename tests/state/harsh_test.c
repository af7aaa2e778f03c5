/* SPDX-License-Identifier: Apache-2.0 */
/* Tests of the figures of setting limits = harsh: those that docs/harsh.md has, and what the
 * specification demands of sizes. */
#include "src/state/builds/harsh.h"

#include "tests/unit/random.h"
#include "tests/unit/unit_test.h"

typedef VkAccelerationStructureBuildSizesInfoKHR sizes_info;

enum { ROUNDS = 20000, FLAGS = 1 << 13 };

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
    enum { S = 1536, B = 700, U = 300 };
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
    for (size_t i = 0; i < sizeof(rows) / sizeof(rows[0]); i++) {
        sizes_info sizes = {
            .accelerationStructureSize = S, .buildScratchSize = B, .updateScratchSize = U};
        harsh_grow_build_sizes(&rows[i].build, &sizes);
        assert_int_equal(sizes.accelerationStructureSize,
                         rounded(2 * S + 256 + rows[i].structure * (S / 8 + 256)));
        assert_int_equal(sizes.buildScratchSize,
                         rounded(B + S / 4 + 1024 + rows[i].scratch * (S / 16 + 256)));
        assert_int_equal(sizes.updateScratchSize,
                         rows[i].build.flags & UPDATE ? rounded(U + S / 16 + 256) : U);
    }
}

static void assert_suffices(const sizes_info *larger, const sizes_info *smaller)
{
    assert_true(larger->accelerationStructureSize >= smaller->accelerationStructureSize);
    assert_true(larger->buildScratchSize >= smaller->buildScratchSize);
    assert_true(larger->updateScratchSize >= smaller->updateScratchSize);
}

static VkDeviceSize random_size(struct random *random)
{
    return random_next(random) >> random_below(random, 64);
}

static sizes_info random_sizes(struct random *random)
{
    return (sizes_info){.accelerationStructureSize = random_size(random),
                        .buildScratchSize = random_size(random),
                        .updateScratchSize = random_size(random)};
}

TEST(sizes_only_grow_and_more_needs_more)
{
    struct random random = random_of("harsh sizes");
    for (unsigned i = 0; i < ROUNDS; i++) {
        const VkBuildAccelerationStructureFlagsKHR flags = random_below(&random, FLAGS);
        const VkAccelerationStructureTypeKHR type = random_one_in(&random, 2) ? TOP : BOTTOM;
        sizes_info driver = random_sizes(&random), more = driver;
        const sizes_info either = grown(driver, EITHER, type, flags),
                         on_host = grown(driver, HOST, type, flags),
                         on_device = grown(driver, DEVICE, type, flags);
        assert_suffices(&on_host, &driver);
        assert_suffices(&on_device, &driver);
        assert_suffices(&either, &on_host);
        assert_suffices(&either, &on_device);
        if (driver.accelerationStructureSize >> 50 || driver.buildScratchSize >> 50 ||
            driver.updateScratchSize >> 50)
            continue; /* nothing has so many bytes */
        more.accelerationStructureSize += random_below(&random, 300);
        more.buildScratchSize += random_below(&random, 300);
        more.updateScratchSize += random_below(&random, 300);
        more = grown(more, DEVICE, type, flags);
        assert_suffices(&more, &on_device);
    }
}

/* As drivers answer for builds that they do not support. */
TEST(no_structure_has_no_sizes)
{
    const sizes_info none = grown((sizes_info){0}, DEVICE, BOTTOM, UPDATE);
    assert_true(!none.accelerationStructureSize && !none.buildScratchSize &&
                !none.updateScratchSize);
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
    };
    for (size_t i = 0; i < sizeof(rows) / sizeof(rows[0]); i++) {
        VkMemoryRequirements requirements = {rows[i].driver_size, 256, 6};
        harsh_grow_requirements(rows[i].type, &requirements);
        assert_int_equal(requirements.size, rows[i].size);
        assert_int_equal(requirements.alignment, rows[i].alignment);
        assert_int_equal(requirements.memoryTypeBits, 6);
    }
}
