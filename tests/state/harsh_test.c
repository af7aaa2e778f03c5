/* SPDX-License-Identifier: Apache-2.0 */
/* Tests of the figures of setting limits = harsh: what the specification demands of sizes, that a
 * driver gets what it needs, and what the figures are there for. */
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
#define UPDATE VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_UPDATE_BIT_KHR
#define COMPACTION VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_COMPACTION_BIT_KHR
#define FAST_TRACE VK_BUILD_ACCELERATION_STRUCTURE_PREFER_FAST_TRACE_BIT_KHR
#define FAST_BUILD VK_BUILD_ACCELERATION_STRUCTURE_PREFER_FAST_BUILD_BIT_KHR
#define LOW_MEMORY VK_BUILD_ACCELERATION_STRUCTURE_LOW_MEMORY_BIT_KHR

/* What lavapipe 25.0 returns for 2 triangles. */
static const sizes_info lavapipe = {
    .accelerationStructureSize = 192, .buildScratchSize = 64, .updateScratchSize = 64};

static sizes_info grown(sizes_info sizes, VkAccelerationStructureBuildTypeKHR build_type,
                        VkAccelerationStructureTypeKHR type,
                        VkBuildAccelerationStructureFlagsKHR flags)
{
    harsh_grow_build_sizes(&(struct harsh_build){build_type, type, flags, false}, &sizes);
    return sizes;
}

static sizes_info grown_for(VkBuildAccelerationStructureFlagsKHR flags)
{
    return grown(lavapipe, DEVICE, BOTTOM, flags);
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

TEST(the_structure_leaves_room_for_a_compacted_copy_of_half_its_size)
{
    for (VkBuildAccelerationStructureFlagsKHR flags = 0; flags < FLAGS; flags++)
        assert_true(grown_for(flags).accelerationStructureSize >
                    2 * lavapipe.accelerationStructureSize);
}

TEST(sizes_differ_by_flags)
{
    const sizes_info plain = grown_for(0), updates = grown_for(UPDATE),
                     compacts = grown_for(COMPACTION), traces = grown_for(FAST_TRACE),
                     builds = grown_for(FAST_BUILD), saves = grown_for(LOW_MEMORY);
    assert_true(updates.accelerationStructureSize > plain.accelerationStructureSize);
    assert_true(updates.buildScratchSize < plain.buildScratchSize);
    assert_true(compacts.accelerationStructureSize > plain.accelerationStructureSize);
    assert_true(traces.accelerationStructureSize > builds.accelerationStructureSize);
    assert_true(traces.buildScratchSize > builds.buildScratchSize);
    assert_true(builds.accelerationStructureSize < plain.accelerationStructureSize);
    assert_true(saves.accelerationStructureSize < plain.accelerationStructureSize);
    assert_true(saves.buildScratchSize < plain.buildScratchSize);
}

TEST(a_transform_needs_more)
{
    const sizes_info plain = grown_for(0);
    sizes_info transformed = lavapipe;
    harsh_grow_build_sizes(&(struct harsh_build){DEVICE, BOTTOM, 0, true}, &transformed);
    assert_true(transformed.accelerationStructureSize > plain.accelerationStructureSize);
    assert_true(transformed.buildScratchSize > plain.buildScratchSize);
}

/* Sizes of structures and of scratch memory. */
TEST(no_size_is_a_multiple_of_an_alignment)
{
    const sizes_info sizes = grown_for(UPDATE);
    assert_true(sizes.accelerationStructureSize % 256);
    assert_true(sizes.buildScratchSize % 256);
    assert_true(sizes.updateScratchSize % 256);
}

TEST(sizes_differ_by_level_and_by_who_builds)
{
    const sizes_info bottom = grown_for(0), top = grown(lavapipe, DEVICE, TOP, 0),
                     host = grown(lavapipe, HOST, BOTTOM, 0);
    assert_true(top.accelerationStructureSize > bottom.accelerationStructureSize);
    assert_true(host.accelerationStructureSize > bottom.accelerationStructureSize);
    assert_true(host.buildScratchSize < bottom.buildScratchSize);
}

TEST(an_update_needs_less_scratch_than_a_build)
{
    const sizes_info none = {.accelerationStructureSize = 192};
    const sizes_info updates = grown_for(UPDATE), scratch = grown(none, DEVICE, BOTTOM, UPDATE);
    assert_true(updates.updateScratchSize < updates.buildScratchSize);
    assert_true(updates.updateScratchSize > lavapipe.updateScratchSize);
    assert_true(scratch.updateScratchSize > 0 && scratch.buildScratchSize > 0);
    assert_int_equal(grown(none, DEVICE, BOTTOM, 0).updateScratchSize, 0);
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

static VkMicromapBuildSizesInfoEXT grown_micromap(VkBuildMicromapFlagsEXT flags)
{
    VkMicromapBuildSizesInfoEXT sizes = {.micromapSize = 4096};
    harsh_grow_micromap_sizes(DEVICE, flags, &sizes);
    return sizes;
}

TEST(micromaps_grow_as_structures_do)
{
    const VkMicromapBuildSizesInfoEXT plain = grown_micromap(0),
                                      compacts = grown_micromap(
                                          VK_BUILD_MICROMAP_ALLOW_COMPACTION_BIT_EXT),
                                      traces = grown_micromap(
                                          VK_BUILD_MICROMAP_PREFER_FAST_TRACE_BIT_EXT),
                                      builds = grown_micromap(
                                          VK_BUILD_MICROMAP_PREFER_FAST_BUILD_BIT_EXT);
    assert_true(plain.micromapSize > 2 * 4096 && plain.buildScratchSize > 0);
    assert_true(compacts.micromapSize > plain.micromapSize);
    assert_true(builds.micromapSize < plain.micromapSize);
    assert_true(traces.micromapSize > builds.micromapSize);
    assert_true(traces.buildScratchSize > builds.buildScratchSize);
}

static VkMemoryRequirements grown_requirements(VkAccelerationStructureMemoryRequirementsTypeNV type,
                                               VkDeviceSize size)
{
    VkMemoryRequirements requirements = {.size = size, .alignment = 256, .memoryTypeBits = 6};
    harsh_grow_requirements(type, &requirements);
    assert_int_equal(requirements.memoryTypeBits, 6);
    return requirements;
}

TEST(requirements_of_nv_structures_grow)
{
    const VkMemoryRequirements
        object =
            grown_requirements(VK_ACCELERATION_STRUCTURE_MEMORY_REQUIREMENTS_TYPE_OBJECT_NV, 1000),
        build = grown_requirements(
            VK_ACCELERATION_STRUCTURE_MEMORY_REQUIREMENTS_TYPE_BUILD_SCRATCH_NV, 1000),
        update = grown_requirements(
            VK_ACCELERATION_STRUCTURE_MEMORY_REQUIREMENTS_TYPE_UPDATE_SCRATCH_NV, 1000),
        none = grown_requirements(
            VK_ACCELERATION_STRUCTURE_MEMORY_REQUIREMENTS_TYPE_UPDATE_SCRATCH_NV, 0);
    assert_true(object.size > 2000 && object.alignment == 64 * 1024);
    assert_true(build.size > update.size && update.size > 1000);
    assert_int_equal(build.alignment, 256);
    assert_int_equal(none.size, 0);
}
