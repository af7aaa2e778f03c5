/* SPDX-License-Identifier: Apache-2.0 */
/* The data that builds read. */
#include <math.h>

#include "tests/player/calls/case.h"
#include "tests/player/scene/placing.h"

enum { MIN_X, MIN_Y, MIN_Z, MAX_X, MAX_Y, MAX_Z };

enum { SHORTS = SCENE_BUFFER_SIZE / 2 };

static uint16_t *short_indices(struct scene *scene)
{
    return (uint16_t *)(void *)(scene->indices.bytes + SHORTS);
}

static void wide_indices(struct scene *scene, uint32_t last)
{
    const uint32_t indices[6] = {0, 1, 2, 3, 2, last};
    memcpy(short_indices(scene), indices, sizeof(indices));
    scene->TRIANGLES(UNINDEXED, 1).indexType = VK_INDEX_TYPE_UINT32;
}

static void byte_index_beyond(struct scene *scene)
{
    const uint8_t indices[6] = {0, 1, 2, 3, 2, 255};
    memcpy(short_indices(scene), indices, sizeof(indices));
    scene->TRIANGLES(UNINDEXED, 1).indexType = VK_INDEX_TYPE_UINT8_KHR;
}

/* A few vertices far apart are no more than there are. */
static void few_vertices_far_apart(struct scene *scene)
{
    const uint16_t indices[6] = {0, 1, 900, 1, 0, 900};
    memcpy(short_indices(scene), indices, sizeof(indices));
}

static void use_transform(struct scene *scene, const float matrix[3][4])
{
    scene->ranges[INDEXED][0].transformOffset = SCENE_TRANSFORM_OFFSET;
    memcpy(scene->transforms.bytes + SCENE_TRANSFORM_OFFSET, matrix, 12 * sizeof(float));
}

#define TRANSFORM(name, ...)                                                                       \
    static void name(struct scene *scene)                                                          \
    {                                                                                              \
        static const float matrix[3][4] = {__VA_ARGS__};                                           \
        use_transform(scene, matrix);                                                              \
    }

TRANSFORM(zero_transform, {0})
TRANSFORM(tiny_transform, {1e-20f}, {0, 1e-20f}, {0, 0, 1e-20f})
TRANSFORM(small_transform, {1e-12f, 0, 0, 5}, {0, 1e-12f}, {0, 0, 1e-12f})
TRANSFORM(huge_transform, {1e15f}, {0, -1e15f}, {0, 0, 1e15f})
TRANSFORM(flat_transform, {1, 2, 3}, {4, 5, 6}, {7, 8, 9})
/* The last number is one float more than 9. */
TRANSFORM(almost_flat_transform, {1, 2, 3}, {4, 5, 6}, {7, 8, 9.00000095f})
TRANSFORM(undefined_transform, {NAN}, {0, 1}, {0, 0, 1})
TRANSFORM(infinite_transform, {1}, {0, INFINITY}, {0, 0, 1})
/* The fourth column moves, and is no part of it. */
TRANSFORM(flat_and_infinite, {1, 2, 3, INFINITY}, {4, 5, 6}, {7, 8, 9})
TRANSFORM(infinite_move, {1, 0, 0, INFINITY}, {0, 1, 0, 0}, {0, 0, 1, 0})

#define ALLOW_UPDATE VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_UPDATE_BIT_KHR

/* Adds a build like `model` that allows updates, builds it as it is now, and makes it an update of
 * itself. Returns its index. */
static uint32_t update_of_itself(struct scene *scene, uint32_t model)
{
    const VkBuildAccelerationStructureFlagsKHR flags = scene->infos[model].flags;
    scene->infos[model].flags |= ALLOW_UPDATE;
    const uint32_t build = scene_add_build(scene, model);
    scene->infos[model].flags = flags;
    scene_build_before(scene, build, 1);
    scene->infos[build].mode = VK_BUILD_ACCELERATION_STRUCTURE_MODE_UPDATE_KHR;
    scene->infos[build].srcAccelerationStructure = scene->infos[build].dstAccelerationStructure;
    return build;
}

/* Vertex 3 is in the second triangle of the first geometry, and in the first and second of the
 * other, vertex 5 in the first geometry alone.
 * BOX_2 is the last box of the second geometry. */
enum { BOX_2 = 1024 + 64 };

/* One primitive less than the second geometry has. */
static void allow_fewer(struct scene *scene)
{
    static const uint32_t fewer[SCENE_GEOMETRIES] = {2, 1};
    scene->count_pointers[UNINDEXED] = fewer;
}

/* More than any device takes, and than the call says. */
enum { TOO_MANY = 1 << 29 };

#define READS_TOO_MANY(build)                                                                      \
    static void read_too_many_of_##build(struct scene *scene)                                      \
    {                                                                                              \
        static const uint32_t counts[SCENE_GEOMETRIES] = {2, 3};                                   \
        scene->count_pointers[build] = counts;                                                     \
        scene->ranges[build][0].primitiveCount = TOO_MANY;                                         \
    }
READS_TOO_MANY(INDEXED)
READS_TOO_MANY(AABBS)

static uint64_t device_address(const struct scene *scene, VkAccelerationStructureKHR accel)
{
    const STRUCT(VkAccelerationStructureDeviceAddressInfoKHR, info, .accelerationStructure = accel);
    return scene->vk->GetAccelerationStructureDeviceAddressKHR(scene->fixture->device, &info);
}

#define ALLOW_DISABLING VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_DISABLE_OPACITY_MICROMAPS_BIT_KHR

/* A BLAS that is like INDEXED; its index behind the builds, where the next one will be, too. */
static uint32_t build_blas(struct scene *scene, VkBuildAccelerationStructureFlagsKHR flags)
{
    const uint32_t build = scene_reserve_build(scene, INDEXED);
    scene->infos[build].flags = flags;
    scene_build_before(scene, build, 1);
    return build;
}

/* 0 of a BLAS that doesn't allow it, 2 of one that does and has it disabled. */
static void use_instances(struct scene *scene)
{
    const VkAccelerationStructureKHR plain =
        scene->infos[build_blas(scene, 0)].dstAccelerationStructure;
    const VkAccelerationStructureKHR allowing =
        scene->infos[build_blas(scene, ALLOW_DISABLING)].dstAccelerationStructure;
    scene_refer(scene, 0, plain);
    scene_refer(scene, 2, allowing);
    scene_instance(scene, 2)->flags = VK_GEOMETRY_INSTANCE_DISABLE_OPACITY_MICROMAPS_BIT_KHR;
}

#include "data.inc"
