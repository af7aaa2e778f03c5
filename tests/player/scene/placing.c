/* SPDX-License-Identifier: Apache-2.0 */
/* Offsets in shared memory, and memory for bad pointers. */
#include "tests/player/scene/placing.h"

#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

enum { ACCEL_ALIGNMENT = 256 };

VkBufferUsageFlags place_usage(const struct scene *scene)
{
    return command_is_of_micromaps(scene->command)
               ? PLACE_USAGE | VK_BUFFER_USAGE_MICROMAP_STORAGE_BIT_EXT
               : PLACE_USAGE;
}

struct device_buffer place_buffer(struct scene *scene)
{
    return scene_buffer(scene, PLACE_SIZE, place_usage(scene));
}

VkDeviceSize place_size(const struct scene *scene, uint32_t build)
{
    return scene_sizes(scene, build).accelerationStructureSize;
}

static VkDeviceSize offset_of(VkDeviceSize size, VkDeviceSize alignment, enum place place)
{
    if (place == AT_BEGINNING)
        return 0;
    return (place == WITHIN ? size - 1 : size + alignment - 1) / alignment * alignment;
}

VkDeviceSize place_offset(VkDeviceSize size, enum place place)
{
    return offset_of(size, ACCEL_ALIGNMENT, place);
}

VkDeviceSize place_scratch_offset(const struct scene *scene, VkDeviceSize size, enum place place)
{
    return offset_of(size, scene->fixture->limits.minAccelerationStructureScratchOffsetAlignment,
                     place);
}

static VkAccelerationStructureKHR place(struct scene *scene, uint32_t build,
                                        const struct device_buffer *buffer, VkDeviceSize offset)
{
    return scene_accel_in(scene, buffer, offset, place_size(scene, build),
                          scene->infos[build].type);
}

void place_dst(struct scene *scene, uint32_t build, const struct device_buffer *buffer,
               VkDeviceSize offset)
{
    scene->infos[build].dstAccelerationStructure = place(scene, build, buffer, offset);
}

void place_src(struct scene *scene, uint32_t build, const struct device_buffer *buffer,
               VkDeviceSize offset)
{
    scene->infos[build].srcAccelerationStructure = place(scene, build, buffer, offset);
    if (scene->infos[build].mode == VK_BUILD_ACCELERATION_STRUCTURE_MODE_UPDATE_KHR)
        scene_build_source(scene, build);
}

void place_scratch(struct scene *scene, uint32_t build, const struct device_buffer *buffer,
                   VkDeviceSize offset)
{
    scene->infos[build].scratchData.deviceAddress = scene_address(scene, buffer, offset);
}

/* As many indices or boxes as there are primitives, all zeros: they may be looked at. */
static void grow_input(struct scene *scene, uint32_t build)
{
    VkAccelerationStructureGeometryKHR *geometry = &scene->geometries[build][0];
    const VkDeviceSize size = (VkDeviceSize)scene->ranges[build][0].primitiveCount * 32;
    const struct device_buffer input = scene_buffer(scene, size, INPUT_USAGE);
    memset(input.bytes, 0, size);
    if (geometry->geometryType == VK_GEOMETRY_TYPE_AABBS_KHR)
        geometry->geometry.aabbs.data.deviceAddress = scene_address(scene, &input, 0);
    else
        geometry->geometry.triangles.indexData.deviceAddress = scene_address(scene, &input, 0);
}

void place_grow(struct scene *scene, uint32_t build, VkDeviceSize size)
{
    if (scene->command == COMMAND_HOST && scene->fixture->instance.platform->is_cpu)
        scene_skip(scene, "its input isn't there, and the backend reads it");
    while (place_size(scene, build) <= size)
        scene->ranges[build][0].primitiveCount *= 2;
    grow_input(scene, build);
    const VkDeviceSize scratch_size = scene_scratch_size(scene, build);
    const struct device_buffer scratch = scene_buffer(scene, scratch_size, SCRATCH_USAGE);
    place_scratch(scene, build, &scratch, 0);
}

/* ---- memory of other kinds ---- */

SCENE_DESTROYS(free_memory, FreeMemory, VkDeviceMemory)

/* Memory that is not mapped, of so many instances. */
static struct test_memory allocate(struct scene *scene, VkMemoryPropertyFlags with,
                                   VkMemoryPropertyFlags without, uint32_t device_mask)
{
    const VkPhysicalDeviceMemoryProperties *types = &scene->fixture->memory;
    const STRUCT(VkMemoryAllocateFlagsInfo, flags,
                 .flags =
                     VK_MEMORY_ALLOCATE_DEVICE_ADDRESS_BIT | VK_MEMORY_ALLOCATE_DEVICE_MASK_BIT,
                 .deviceMask = device_mask);
    STRUCT(VkMemoryAllocateInfo, info, .pNext = &flags, .allocationSize = PLACE_SIZE);
    struct test_memory memory = {.size = PLACE_SIZE};
    while (info.memoryTypeIndex < types->memoryTypeCount &&
           ((types->memoryTypes[info.memoryTypeIndex].propertyFlags & with) != with ||
            (types->memoryTypes[info.memoryTypeIndex].propertyFlags & without) != 0))
        info.memoryTypeIndex++;
    if (info.memoryTypeIndex == types->memoryTypeCount) {
        scene_skip(scene, "no memory type of the wanted kind");
        return memory;
    }
    GET(scene->vk->AllocateMemory(scene->fixture->device, &info, NULL, &memory.handle));
    scene_defer(scene, scene->fixture->device, (uint64_t)memory.handle, free_memory);
    return memory;
}

static struct device_buffer buffer_in(struct scene *scene, const struct test_memory *memory)
{
    struct device_buffer buffer = scene_create_buffer(scene, PLACE_SIZE, place_usage(scene));
    scene_bind(scene, &buffer, memory, 0);
    return buffer;
}

struct device_buffer place_device_local_buffer(struct scene *scene)
{
    const struct test_memory memory = allocate(scene, VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT,
                                               VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT, 1);
    return buffer_in(scene, &memory);
}

struct device_buffer place_buffer_of_instances(struct scene *scene, uint32_t device_mask)
{
    const struct test_memory memory =
        allocate(scene, VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT, 0, device_mask);
    return buffer_in(scene, &memory);
}

VkAccelerationStructureKHR place_accel_by_address(struct scene *scene, uint32_t build)
{
    const struct device_buffer buffer = place_buffer(scene);
    const STRUCT(VkAccelerationStructureCreateInfo2KHR, info,
                 .addressRange = {.address = buffer.address, .size = place_size(scene, build)},
                 .addressFlags = VK_ADDRESS_COMMAND_STORAGE_BUFFER_USAGE_BIT_KHR,
                 .type = scene->infos[build].type);
    return scene_accel_at(scene, &info);
}

/* ---- bad pointers ---- */

void *unreadable_page(void)
{
    static void *page;
    if (page == NULL)
        page = mmap(NULL, (size_t)sysconf(_SC_PAGESIZE), PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS, -1,
                    0);
    if (page == MAP_FAILED)
        abort();
    return page;
}

enum { RESERVED = 1 << 28 };

/* The unreadable pages never were anything else: for some milliseconds the layer believes that a
 * page is still readable which was (src/base/readable.h). */
void *bytes_before_unreadable_page(size_t size)
{
    static unsigned char *reserved;
    static size_t left;
    const size_t page = (size_t)sysconf(_SC_PAGESIZE);
    const size_t readable = (size + page - 1) / page * page;
    if (left < readable + page) {
        left = RESERVED;
        reserved = mmap(NULL, left, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    }
    unsigned char *pages = reserved;
    if (reserved == MAP_FAILED || mprotect(pages, readable, PROT_READ | PROT_WRITE) != 0)
        abort();
    reserved += readable + page;
    left -= readable + page;
    return pages + readable - size;
}

void put_at_edge(struct scene *scene, void *pointer, size_t size)
{
    (void)scene;
    void *copy = bytes_before_unreadable_page(size);
    const void *from;
    memcpy(&from, pointer, sizeof(from));
    memcpy(copy, from, size);
    memcpy(pointer, &copy, sizeof(copy));
}
