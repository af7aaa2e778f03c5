/* SPDX-License-Identifier: Apache-2.0 */
/* What only host builds have. */
#include <sys/mman.h>
#include <unistd.h>

#include "tests/fixture/copies.h"
#include "tests/rules/calls/placing.h"
#include "tests/rules/case.h"

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

static VkAccelerationStructureKHR accel_in(struct scene *scene, struct device_buffer buffer,
                                           uint32_t build)
{
    return scene_accel_in(scene, &buffer, 0, place_size(scene, build), scene->infos[build].type);
}

#include "host.inc"

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
#include "host_memory.inc"
