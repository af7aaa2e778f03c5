/* SPDX-License-Identifier: Apache-2.0 */
/* The figures of docs/harsh.md. */
#include "src/state/builds/harsh.h"

#include <stddef.h>
#include <stdint.h>

enum {
    SCRATCH_ALIGNMENT = 256,         /* the largest that the specification allows */
    OBJECT_ALIGNMENT_NV = 64 * 1024, /* no bound in the specification */
    GEOMETRIES_MAX = (1 << 24) - 1,  /* the smallest that the specification allows */
    INSTANCES_MAX = (1 << 24) - 1,   /* likewise */
    PRIMITIVES_MAX = (1 << 29) - 1,  /* likewise */
    UNIT = 256,
    REST = 104, /* all sizes are a multiple of the unit and this rest */
};

/* Nothing has this many bytes: beyond it a size stays the driver's, so that no sum wraps. */
#define SIZE_LIMIT ((VkDeviceSize)1 << 56)

static void raise(VkDeviceSize *value, VkDeviceSize least)
{
    if (*value < least)
        *value = least;
}

static void lower(uint64_t *value, uint64_t most)
{
    if (*value > most)
        *value = most;
}

void harsh_limit_structures(VkPhysicalDeviceAccelerationStructurePropertiesKHR *limits)
{
    lower(&limits->maxGeometryCount, GEOMETRIES_MAX);
    lower(&limits->maxInstanceCount, INSTANCES_MAX);
    lower(&limits->maxPrimitiveCount, PRIMITIVES_MAX);
    if (limits->minAccelerationStructureScratchOffsetAlignment < SCRATCH_ALIGNMENT)
        limits->minAccelerationStructureScratchOffsetAlignment = SCRATCH_ALIGNMENT;
}

/* ---- shares: how much more a build needs than one with the least needs */

struct shares {
    unsigned structure, scratch;
};

/* What a flag adds if it is set, or with `if_clear` if it is not. */
static const struct flag_shares {
    VkBuildAccelerationStructureFlagsKHR flag;
    bool if_clear;
    struct shares shares;
} flag_shares[] = {
    {VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_UPDATE_BIT_KHR, false, {2, 0}},
    {VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_UPDATE_BIT_KHR, true, {0, 2}},
    {VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_COMPACTION_BIT_KHR, false, {1, 0}},
    {VK_BUILD_ACCELERATION_STRUCTURE_PREFER_FAST_TRACE_BIT_KHR, false, {2, 2}},
    {VK_BUILD_ACCELERATION_STRUCTURE_PREFER_FAST_BUILD_BIT_KHR, true, {1, 0}},
    {VK_BUILD_ACCELERATION_STRUCTURE_LOW_MEMORY_BIT_KHR, true, {1, 1}},
    {VK_BUILD_ACCELERATION_STRUCTURE_MOTION_BIT_NV, false, {4, 2}},
    {VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_OPACITY_MICROMAP_UPDATE_BIT_EXT, false, {1, 0}},
    {VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_DISABLE_OPACITY_MICROMAPS_BIT_EXT, false, {1, 0}},
    {VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_OPACITY_MICROMAP_DATA_UPDATE_BIT_EXT, false, {1, 0}},
    {VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_DATA_ACCESS_BIT_KHR, false, {2, 0}},
};

static void add_shares(struct shares *sum, struct shares more)
{
    sum->structure += more.structure;
    sum->scratch += more.scratch;
}

static struct shares shares_of(const struct harsh_build *build)
{
    struct shares sum = {0};
    for (size_t i = 0; i < sizeof(flag_shares) / sizeof(flag_shares[0]); i++)
        if (!(build->flags & flag_shares[i].flag) == flag_shares[i].if_clear)
            add_shares(&sum, flag_shares[i].shares);
    if (build->type == VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR)
        add_shares(&sum, (struct shares){1, 1});
    if (build->has_transform)
        add_shares(&sum, (struct shares){1, 1});
    if (build->build_type != VK_ACCELERATION_STRUCTURE_BUILD_TYPE_DEVICE_KHR)
        add_shares(&sum, (struct shares){1, 0});
    if (build->build_type != VK_ACCELERATION_STRUCTURE_BUILD_TYPE_HOST_KHR)
        add_shares(&sum, (struct shares){0, 1});
    return sum;
}

/* ---- sizes */

static VkDeviceSize round_up(VkDeviceSize size)
{
    return (size + UNIT - 1) / UNIT * UNIT;
}

static VkDeviceSize grow_to(VkDeviceSize size)
{
    return round_up(size) + REST;
}

void harsh_grow_build_sizes(const struct harsh_build *build,
                            VkAccelerationStructureBuildSizesInfoKHR *sizes)
{
    const VkDeviceSize size = sizes->accelerationStructureSize;
    const struct shares shares = shares_of(build);
    if (!size || size > SIZE_LIMIT || sizes->buildScratchSize > SIZE_LIMIT ||
        sizes->updateScratchSize > SIZE_LIMIT)
        return;
    sizes->accelerationStructureSize =
        grow_to(2 * size + UNIT + shares.structure * (size / 8 + UNIT));
    sizes->buildScratchSize = grow_to(sizes->buildScratchSize + size / 4 + 4 * UNIT +
                                      shares.scratch * (size / 16 + UNIT));
    if (build->flags & VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_UPDATE_BIT_KHR)
        sizes->updateScratchSize = grow_to(sizes->updateScratchSize + size / 16 + UNIT);
}

static VkBuildAccelerationStructureFlagsKHR flags_of_micromap(VkBuildMicromapFlagsEXT flags)
{
    return (flags & VK_BUILD_MICROMAP_PREFER_FAST_TRACE_BIT_EXT
                ? VK_BUILD_ACCELERATION_STRUCTURE_PREFER_FAST_TRACE_BIT_KHR
                : 0u) |
           (flags & VK_BUILD_MICROMAP_PREFER_FAST_BUILD_BIT_EXT
                ? VK_BUILD_ACCELERATION_STRUCTURE_PREFER_FAST_BUILD_BIT_KHR
                : 0u) |
           (flags & VK_BUILD_MICROMAP_ALLOW_COMPACTION_BIT_EXT
                ? VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_COMPACTION_BIT_KHR
                : 0u);
}

void harsh_grow_micromap_sizes(VkAccelerationStructureBuildTypeKHR build_type,
                               VkBuildMicromapFlagsEXT flags, VkMicromapBuildSizesInfoEXT *sizes)
{
    VkAccelerationStructureBuildSizesInfoKHR grown = {.accelerationStructureSize =
                                                          sizes->micromapSize,
                                                      .buildScratchSize = sizes->buildScratchSize};
    const struct harsh_build build = {
        .build_type = build_type,
        .type = VK_ACCELERATION_STRUCTURE_TYPE_OPACITY_MICROMAP_KHR,
        .flags = flags_of_micromap(flags),
    };
    harsh_grow_build_sizes(&build, &grown);
    sizes->micromapSize = grown.accelerationStructureSize;
    sizes->buildScratchSize = grown.buildScratchSize;
}

void harsh_grow_requirements(VkAccelerationStructureMemoryRequirementsTypeNV type,
                             VkMemoryRequirements *requirements)
{
    const VkDeviceSize size = requirements->size;
    if (!size || size > SIZE_LIMIT)
        return;
    switch (type) {
    case VK_ACCELERATION_STRUCTURE_MEMORY_REQUIREMENTS_TYPE_BUILD_SCRATCH_NV:
        requirements->size = round_up(size + size / 2 + 4 * UNIT);
        break;
    case VK_ACCELERATION_STRUCTURE_MEMORY_REQUIREMENTS_TYPE_UPDATE_SCRATCH_NV:
        requirements->size = round_up(size + size / 4 + UNIT);
        break;
    default:
        requirements->size = round_up(2 * size + UNIT);
        raise(&requirements->alignment, OBJECT_ALIGNMENT_NV);
    }
}
