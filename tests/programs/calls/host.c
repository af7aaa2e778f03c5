/* SPDX-License-Identifier: Apache-2.0 */
/* What only host builds have. */
#include <sys/mman.h>
#include <unistd.h>

#include "tests/fixture/copies.h"
#include "tests/player/calls/case.h"
#include "tests/player/scene/placing.h"

static VkDeferredOperationKHR create_operation(struct scene *scene)
{
    VkDeferredOperationKHR operation;
    GET(scene->vk->CreateDeferredOperationKHR(scene->fixture->device, NULL, &operation));
    return operation;
}

SCENE_DESTROYS(destroy_operation, DestroyDeferredOperationKHR, VkDeferredOperationKHR)

static void join(const struct scene *scene, VkDevice device, VkDeferredOperationKHR operation)
{
    while (scene->vk->DeferredOperationJoinKHR(device, operation) == VK_THREAD_IDLE_KHR)
        continue;
}

static void join_and_destroy(struct scene *scene, VkDevice device, uint64_t handle)
{
    join(scene, device, (VkDeferredOperationKHR)handle);
    destroy_operation(scene, device, handle);
}

/* Defines a structure for a build, in a buffer of that memory. */
#define STRUCTURE_IN(name, memory)                                                                 \
    static VkAccelerationStructureKHR name(struct scene *scene, uint32_t build)                    \
    {                                                                                              \
        const struct device_buffer buffer = memory;                                                \
        return scene_accel_in(scene, &buffer, 0, place_size(scene, build),                         \
                              scene->infos[build].type);                                           \
    }

STRUCTURE_IN(in_a_buffer, place_buffer(scene))
STRUCTURE_IN(in_device_memory, place_device_local_buffer(scene))
STRUCTURE_IN(in_visible_memory, place_buffer_of_instances(scene, 1))
STRUCTURE_IN(of_two_instances, place_buffer_of_instances(scene, 3))

static void point_to_instances(struct scene *scene, size_t missing)
{
    const void *pointers[3];
    for (size_t i = 0; i < 3; i++)
        pointers[i] = scene->instances.bytes + i * 64;
    scene->INSTANCES(TLAS, 0).arrayOfPointers = VK_TRUE;
    char *copy = bytes_before_unreadable_page(sizeof(pointers) - missing);
    scene->INSTANCES(TLAS, 0).data.hostAddress = memcpy(copy, pointers, sizeof(pointers) - missing);
}

/* Returns the last `size` bytes of a mapping whose pages are protected, as tools that trace writes
 * protect them. */
static void *bytes_of_protected_mapping(struct scene *scene, size_t size)
{
    const size_t page = (size_t)sysconf(_SC_PAGESIZE);
    const VkDeviceMemory memory = place_buffer(scene).memory;
    char *pages;
    scene->vk->UnmapMemory(scene->fixture->device, memory);
    GET(scene->vk->MapMemory(scene->fixture->device, memory, 0, page, 0, (void **)&pages));
    if (mprotect(pages, 2 * page, PROT_NONE) != 0)
        scene_skip(scene, "the pages cannot be protected");
    return pages + page - size;
}

#include "host.inc"
