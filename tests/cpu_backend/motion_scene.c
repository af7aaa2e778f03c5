/* SPDX-License-Identifier: Apache-2.0 */
/* Making the scene, and where it is. */
#include "motion_scene.h"

#include <stdlib.h>
#include <string.h>

static void *instance_at(struct moving_scene *scene, uint32_t index)
{
    return (char *)scene->instances.data + (size_t)index * MOTION_INSTANCE_STRIDE;
}

static VkTransformMatrixKHR moved(float x, float y)
{
    return (VkTransformMatrixKHR){{{1, 0, 0, x}, {0, 1, 0, y}, {0, 0, 1, 0}}};
}

static VkSRTDataNV srt_moved(float x, float y)
{
    return (VkSRTDataNV){.sx = 1, .sy = 1, .sz = 1, .qw = 1, .tx = x, .ty = y};
}

static void fill_instances(struct moving_scene *scene)
{
    const uint64_t blas = (uint64_t)scene->blas.handle;
    const VkAccelerationStructureMotionInstanceNV still = {
        .type = VK_ACCELERATION_STRUCTURE_MOTION_INSTANCE_TYPE_STATIC_NV,
        .data.staticInstance = {.transform = moved(0, 0),
                                .instanceCustomIndex = 100,
                                .mask = 0xff,
                                .accelerationStructureReference = blas},
    };
    const VkAccelerationStructureMotionInstanceNV matrix = {
        .type = VK_ACCELERATION_STRUCTURE_MOTION_INSTANCE_TYPE_MATRIX_MOTION_NV,
        .data.matrixMotionInstance = {.transformT0 = moved(0, 2),
                                      .transformT1 = moved(8, 2),
                                      .instanceCustomIndex = 101,
                                      .mask = 0xff,
                                      .accelerationStructureReference = blas},
    };
    const VkAccelerationStructureMotionInstanceNV srt = {
        .type = VK_ACCELERATION_STRUCTURE_MOTION_INSTANCE_TYPE_SRT_MOTION_NV,
        .data.srtMotionInstance = {.transformT0 = srt_moved(0, 4),
                                   .transformT1 = srt_moved(16, 4),
                                   .instanceCustomIndex = 102,
                                   .mask = 0xff,
                                   .accelerationStructureReference = blas},
    };
    memcpy(instance_at(scene, 0), &still, sizeof(still));
    memcpy(instance_at(scene, 1), &matrix, sizeof(matrix));
    memcpy(instance_at(scene, 2), &srt, sizeof(srt));
}

void moving_scene_open(struct moving_scene *scene, VkBuildAccelerationStructureFlagsKHR flags)
{
    flags |= VK_BUILD_ACCELERATION_STRUCTURE_MOTION_BIT_NV;
    fixture_triangles(&scene->triangles, MOVING_TRIANGLES, flags);
    fixture_move(&scene->triangles, 4, 0, 0);
    memcpy(scene->then, scene->triangles.data, sizeof(scene->then));
    fixture_move(&scene->triangles, 0, 0, 0);
    scene->motion = MAKE(VkAccelerationStructureGeometryMotionTrianglesDataNV,
                         .vertexData.hostAddress = scene->then);
    scene->triangles.geometry.geometry.triangles.pNext = &scene->motion;
    scene->blas = fixture_create_for(&scene->triangles);

    const VkAccelerationStructureKHR blases[MOVING_INSTANCES] = {0};
    fixture_instances(&scene->instances, blases, MOVING_INSTANCES, flags);
    scene->instances.data = own_block(aligned_alloc(16, MOVING_INSTANCES * MOTION_INSTANCE_STRIDE));
    scene->instances.size = MOTION_INSTANCES_SIZE;
    memset(scene->instances.data, 0xff, MOVING_INSTANCES * MOTION_INSTANCE_STRIDE);
    scene->instances.geometry.geometry.instances.data.hostAddress = scene->instances.data;
    fill_instances(scene);
    scene->tlas = fixture_create_for(&scene->instances);
}

void moving_scene_build(struct moving_scene *scene)
{
    GET(host_build(&scene->triangles, scene->blas.handle, VK_NULL_HANDLE));
    GET(host_build(&scene->instances, scene->tlas.handle, VK_NULL_HANDLE));
}

static const float times[] = {0, 0.5f, 1};

enum { TIMES = sizeof(times) / sizeof(times[0]) };

/* The nearest triangle's plane goes from x = 0 to `way`; the ray begins at x = -1. */
static void expect_on_the_way(VkAccelerationStructureKHR structure, float y, float way,
                              uint32_t number, uint32_t custom_index)
{
    for (int i = 0; i < TIMES; i++) {
        const AssayHit hit = fixture_trace_at(structure, y + 0.25f, 0.25f, times[i]);
        expect_hit_at(hit, 1 + way * times[i], 0);
        assert_float_equal(hit.u, 0.25, 1e-6);
        assert_int_equal(hit.instance, number);
        assert_int_equal(hit.customIndex, custom_index);
        assert_false(fixture_trace_at(structure, y + 1.5f, 0.25f, times[i]).isHit);
    }
}

void expect_moving_blas(VkAccelerationStructureKHR blas, float way)
{
    expect_on_the_way(blas, 0, way, 0, 0);
}

void expect_moving_tlas(VkAccelerationStructureKHR tlas)
{
    expect_on_the_way(tlas, 0, 4, 0, 100);
    expect_on_the_way(tlas, 2, 4 + 8, 1, 101);
    expect_on_the_way(tlas, 4, 4 + 16, 2, 102);
}
