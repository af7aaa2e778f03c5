/* SPDX-License-Identifier: Apache-2.0 */
/* Commands that build no structures, creation of structures and micromaps, and builds of clusters
 * and of partitioned structures. */
#include <stdlib.h>

#include "tests/player/calls/case.h"
#include "tests/player/scene/placing.h"

/* ---- descriptors */

static VkAccelerationStructureNV nv_blas(struct scene *scene)
{
    scene->nv.info.type = VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_NV;
    scene->nv.info.instanceCount = 0;
    scene->nv.info.geometryCount = 1;
    scene->nv.info.pGeometries = scene->nv.geometries;
    return scene_nv_accel(scene);
}

/* Has the call write descriptors of VK_KHR_acceleration_structure, with both structures. */
static void chain_both_descriptors(struct scene *scene)
{
    static VkAccelerationStructureKHR structures[2];
    struct scene_life *life = &scene->life;
    structures[0] = structures[1] = scene->infos[TLAS].dstAccelerationStructure;
    life->descriptor.pAccelerationStructures = structures;
    life->descriptor.pNext = &life->descriptor_nv;
    life->write.pNext = &life->descriptor;
    life->write.descriptorType = VK_DESCRIPTOR_TYPE_ACCELERATION_STRUCTURE_KHR;
}

/* ---- creation */

/* Creates the object of the call in another buffer. */
static void create_in(struct scene *scene, const struct device_buffer *buffer)
{
    scene->life.create.buffer = scene->life.create_micromap.buffer = buffer->handle;
    scene->life.create_at.addressRange.address = buffer->address;
}

static void chain_captured_data(struct scene *scene)
{
    static const uint64_t data[8];
    static const VkOpaqueCaptureDescriptorDataCreateInfoEXT captured = {
        .sType = VK_STRUCTURE_TYPE_OPAQUE_CAPTURE_DESCRIPTOR_DATA_CREATE_INFO_EXT,
        .opaqueCaptureDescriptorData = data};
    scene->life.create.pNext = scene->life.create_at.pNext = &captured;
}

/* ---- destruction */

VKAPI_ATTR static void *VKAPI_CALL allocate(void *user, size_t size, size_t alignment,
                                            VkSystemAllocationScope scope)
{
    (void)user, (void)scope;
    return aligned_alloc(alignment, (size + alignment - 1) / alignment * alignment);
}

/* No Vulkan command on structures reallocates. */
VKAPI_ATTR static void *VKAPI_CALL reallocate(void *user, void *original, size_t size,
                                              size_t alignment, VkSystemAllocationScope scope)
{
    return original ? NULL : allocate(user, size, alignment, scope);
}

VKAPI_ATTR static void VKAPI_CALL release(void *user, void *memory)
{
    (void)user;
    free(memory);
}

static const VkAllocationCallbacks callbacks = {
    .pfnAllocation = allocate, .pfnReallocation = reallocate, .pfnFree = release};

static void destroy_with_callbacks(struct scene *scene, VkDevice device, uint64_t handle)
{
    if (scene->life.object_type == VK_OBJECT_TYPE_MICROMAP_EXT)
        scene->vk->DestroyMicromapEXT(device, (VkMicromapEXT)handle, &callbacks);
    else if (scene->life.object_type == VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_NV)
        scene->vk->DestroyAccelerationStructureNV(device, (VkAccelerationStructureNV)handle,
                                                  &callbacks);
    else
        scene->vk->DestroyAccelerationStructureKHR(device, (VkAccelerationStructureKHR)handle,
                                                   &callbacks);
}

/* Has the call destroy an object that was created with callbacks. */
static void use_created_with_callbacks(struct scene *scene)
{
    struct scene_life *life = &scene->life;
    const VkDevice device = scene->device;
    void *created = &life->destroyed;
    if (life->object_type == VK_OBJECT_TYPE_MICROMAP_EXT)
        GET(scene->vk->CreateMicromapEXT(device, &life->create_micromap, &callbacks,
                                         (VkMicromapEXT *)created));
    else if (life->object_type == VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_NV)
        GET(scene->vk->CreateAccelerationStructureNV(device, &life->create_nv, &callbacks,
                                                     (VkAccelerationStructureNV *)created));
    else
        GET(scene->vk->CreateAccelerationStructureKHR(device, &life->create, &callbacks,
                                                      (VkAccelerationStructureKHR *)created));
    scene_defer(scene, device, life->destroyed, destroy_with_callbacks);
}

#include "clusters.inc"
#include "life.inc"
#include "life_create.inc"
