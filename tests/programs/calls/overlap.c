/* SPDX-License-Identifier: Apache-2.0 */
/* Memory that builds of one call share. */
#include "tests/player/calls/case.h"
#include "tests/player/scene/placing.h"

enum { ADDED = SCENE_BASE_BUILDS };

enum { MANY = 8 };

/* MANY builds more, in `groups` groups of one dst each. */
static void share_dst_in_groups(struct scene *scene, uint32_t groups)
{
    VkAccelerationStructureKHR dst[MANY];
    for (uint32_t i = 0; i < MANY; i++) {
        const uint32_t build = scene_add_build(scene, INDEXED);
        dst[i] = scene->infos[build].dstAccelerationStructure;
        scene->infos[build].dstAccelerationStructure = dst[i % groups];
    }
}

/* Two buffers of the scene that is played, in one memory, the second at an offset of it. */
static struct device_buffer buffers[2];
static void make_two_buffers(struct scene *scene, VkDeviceSize offset)
{
    const struct test_memory memory = scene_allocate(scene, 2 * PLACE_SIZE);
    for (int i = 0; i < 2; i++) {
        buffers[i] = scene_create_buffer(scene, PLACE_SIZE, PLACE_USAGE);
        scene_bind(scene, &buffers[i], &memory, i == 0 ? 0 : offset);
    }
}

/* vkBindBufferMemory2 of two buffers at once, with these structures in their chains. */
static VkResult bind2_with(struct scene *scene, VkDeviceSize second_offset,
                           const VkBindMemoryStatus *status)
{
    VkBindBufferMemoryInfo infos[2];
    const struct test_memory memory = scene_allocate(scene, 2 * PLACE_SIZE);

    for (int i = 0; i < 2; i++) {
        buffers[i] = scene_create_buffer(scene, PLACE_SIZE, PLACE_USAGE);
        infos[i] = MAKE(VkBindBufferMemoryInfo, .pNext = status ? &status[i] : NULL,
                        .buffer = buffers[i].handle, .memory = memory.handle,
                        .memoryOffset = i == 0 ? 0 : second_offset);
    }
    const VkResult result = scene->vk->BindBufferMemory2(scene->fixture->device, 2, infos);
    place_dst(scene, INDEXED, &buffers[0], 0);
    place_dst(scene, AABBS, &buffers[1], 0);
    return result;
}

static VkResult bind2(struct scene *scene, VkDeviceSize second_offset)
{
    return bind2_with(scene, second_offset, NULL);
}

/* Binds both buffers in a call that fails. The first bind succeeds; the second one has the result
 * `second`. */
static void bind2_failing(struct scene *scene, VkResult second)
{
    VkResult results[] = {VK_SUCCESS, second};
    const VkBindMemoryStatus status[] = {MAKE(VkBindMemoryStatus, .pResult = &results[0]),
                                         MAKE(VkBindMemoryStatus, .pResult = &results[1])};
    scene->fixture->instance.platform->null_driver.fail_at("vkBindBufferMemory2", 1,
                                                           VK_ERROR_OUT_OF_DEVICE_MEMORY);
    bind2_with(scene, 0, status);
}

/* Two structures at one offset of memory that each physical device has an instance of. */
static void use_instances(struct scene *scene, const uint32_t first[2], const uint32_t second[2])
{
    const uint32_t *const indices[2] = {first, second};
    const struct test_memory memory =
        scene_allocate_with(scene, PLACE_SIZE, VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT, NULL);

    for (int i = 0; i < 2; i++) {
        const STRUCT(VkBindBufferMemoryDeviceGroupInfo, group,
                     .deviceIndexCount = indices[i] != NULL ? 2 : 0, .pDeviceIndices = indices[i]);
        buffers[i] = scene_create_buffer(scene, PLACE_SIZE, ACCEL_USAGE);
        const STRUCT(VkBindBufferMemoryInfo, info, .pNext = &group, .buffer = buffers[i].handle,
                     .memory = memory.handle);
        GET(scene->vk->BindBufferMemory2(scene->fixture->device, 1, &info));
    }
    place_dst(scene, INDEXED, &buffers[0], 0);
    place_dst(scene, AABBS, &buffers[1], 0);
}

static void use_different_instances(struct scene *scene)
{
    static const uint32_t first[] = {0, 0}, second[] = {1, 1};
    use_instances(scene, first, second);
}

#include "overlap.inc"
