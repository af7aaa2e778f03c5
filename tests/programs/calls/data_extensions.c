/* SPDX-License-Identifier: Apache-2.0 */
/* The data that builds of extensions read. */
#include <math.h>

#include "tests/player/calls/case.h"

#define MOTION VK_BUILD_ACCELERATION_STRUCTURE_MOTION_BIT_NV

enum { STILL, MATRIX, SRT, INSTANCES_MADE };

static VkAccelerationStructureMotionInstanceNV *motion_instance(struct scene *scene, uint32_t index)
{
    return (void *)(scene->instances.bytes + 160 * (size_t)index);
}

/* One of each type. */
static void moving_instances(struct scene *scene)
{
    scene_give_motion_dst(scene, TLAS);
    scene->infos[TLAS].flags = MOTION;
    memset(scene->instances.bytes, 0, SCENE_BUFFER_SIZE);
    for (uint32_t i = 0; i < INSTANCES_MADE; i++)
        motion_instance(scene, i)->type = (VkAccelerationStructureMotionInstanceTypeNV)i;
    for (uint32_t i = 0; i < 3; i++) {
        motion_instance(scene, STILL)->data.staticInstance.transform.matrix[i][i] = 1;
        motion_instance(scene, MATRIX)->data.matrixMotionInstance.transformT0.matrix[i][i] = 1;
        motion_instance(scene, MATRIX)->data.matrixMotionInstance.transformT1.matrix[i][i] = 1;
    }
    motion_instance(scene, SRT)->data.srtMotionInstance.transformT0 =
        motion_instance(scene, SRT)->data.srtMotionInstance.transformT1 =
            (VkSRTDataNV){.sx = 1, .sy = 1, .sz = 1, .qw = 1};
}

/* Their data alone, by pointers that have the types. */
static void pack(struct scene *scene)
{
    uint64_t *pointers = (void *)(scene->instances.bytes + SCENE_BUFFER_SIZE / 2);
    for (uint32_t i = 0; i < INSTANCES_MADE; i++) {
        const size_t offset = 1024 + 256 * (size_t)i;
        memcpy(scene->instances.bytes + offset, &motion_instance(scene, i)->data,
               sizeof(motion_instance(scene, i)->data));
        pointers[i] = scene_address(scene, &scene->instances, offset) + i;
    }
    scene->INSTANCES(TLAS, 0).arrayOfPointers = VK_TRUE;
    scene->ranges[TLAS][0].primitiveOffset = SCENE_BUFFER_SIZE / 2;
}

/* Behind the boxes, and among the indices. */
enum { RADII = SCENE_BUFFER_SIZE / 2, RADIUS_INDICES = SCENE_BUFFER_SIZE / 4 };

static void set_radius(struct scene *scene, uint32_t index, float radius)
{
    memcpy(scene->boxes.bytes + RADII + index * sizeof(radius), &radius, sizeof(radius));
}

static void set_radii(struct scene *scene)
{
    static const uint32_t indices[4] = {1, 3, 5, 7};
    memcpy(scene->indices.bytes + RADIUS_INDICES, indices, sizeof(indices));
    for (uint32_t i = 0; i < 16; i++)
        set_radius(scene, i, (float)i);
}

static void use_short_indices(struct scene *scene)
{
    static const uint16_t indices[4] = {1, 3, 6, 7};
    memcpy(scene->indices.bytes + RADIUS_INDICES, indices, sizeof(indices));
}

enum { TRIANGLES_BUILT = 4, LEVEL_OF_NONE = 16 };

enum { OPACITY_INDICES = 1024 };

/* Vertex 5 is in the second triangle of the second geometry alone. */
enum { SECOND_BOXES = 1024, VERTEX_5 = 60 };

static VkAccelerationStructureInstanceKHR *nv_instance(struct scene *scene, uint32_t index)
{
    return (VkAccelerationStructureInstanceKHR *)(void *)scene->nv.instances.bytes + index;
}

static uint64_t reference_of(struct scene *scene, VkAccelerationStructureNV accel)
{
    uint64_t reference = 0;
    GET(scene->vk->GetAccelerationStructureHandleNV(scene->fixture->device, accel,
                                                    sizeof(reference), &reference));
    return reference;
}

/* The BLAS that the scene has until it builds instances. */
static uint64_t built_blas(struct scene *scene)
{
    const VkAccelerationStructureNV blas = scene_nv_accel(scene);
    scene_nv_build(scene, blas);
    return reference_of(scene, blas);
}

enum { KEPT = 5 }; /* an instance behind the last, for a reference that a mutation uses */

#include "data_extensions.inc"
