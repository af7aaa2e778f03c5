/* SPDX-License-Identifier: Apache-2.0 */
/* Making the scene. */
#include "scene.h"
#include "tests/fixture/geometry.h"

#include <stdbool.h>
#include <stdlib.h>

enum {
    TRIANGLES = 12, /* a cube */
    VERTICES = 8,
    VERTEX_SIZE = 3 * sizeof(float),
    STRUCTURE_ALIGNMENT = 256 /* VkAccelerationStructureCreateInfoKHR::offset */
};

const char *buffers_name(enum buffers buffers)
{
    return buffers == BUFFERS_SHARED ? "shared" : "separate";
}

const char *order_name(enum order order)
{
    return order == ORDER_CREATED ? "created" : "shuffled";
}

static VkBufferUsageFlags usage_of(enum scene_part part)
{
    switch (part) {
    case PART_STRUCTURE:
        return VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_STORAGE_BIT_KHR;
    case PART_SCRATCH:
        return VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT;
    default:
        return VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_BIT_KHR |
               VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT;
    }
}

/* ---- ranges */

static void find_addresses(const struct side *side, struct scene_ranges *ranges, uint32_t count)
{
    ranges->addresses = tool_alloc(count, sizeof(*ranges->addresses));
    VkDeviceAddress first = gpu_buffer_address(&side->gpu, ranges->buffers[0]);
    for (uint32_t i = 0; i < count; i++)
        ranges->addresses[i] = ranges->buffer_count > 1
                                   ? gpu_buffer_address(&side->gpu, ranges->buffers[i])
                                   : first + i * ranges->stride;
}

static void create_ranges(struct scene *scene, enum scene_part part, enum buffers buffers,
                          VkDeviceSize size)
{
    const struct side *side = scene->side;
    struct scene_ranges *ranges = &scene->parts[part];
    bool shared = buffers == BUFFERS_SHARED;
    ranges->size = size;
    ranges->buffer_count = shared ? 1 : scene->count;
    ranges->buffers = tool_alloc(ranges->buffer_count, sizeof(*ranges->buffers));

    VkDeviceSize alignment = side->gpu.limits.minAccelerationStructureScratchOffsetAlignment;
    if (alignment < STRUCTURE_ALIGNMENT)
        alignment = STRUCTURE_ALIGNMENT;
    ranges->stride = gpu_align(size, alignment);
    for (uint32_t i = 0; i < ranges->buffer_count; i++)
        ranges->buffers[i] = gpu_make_buffer(&side->gpu, usage_of(part),
                                             shared ? scene->count * ranges->stride : size);

    VkMemoryRequirements needs;
    side->gpu.calls.GetBufferMemoryRequirements(side->gpu.device, ranges->buffers[0], &needs);
    if (!shared)
        ranges->stride =
            gpu_align(needs.size, needs.alignment > alignment ? needs.alignment : alignment);
    VkDeviceSize total = shared ? needs.size : scene->count * ranges->stride;
    ranges->memory = gpu_allocate(&side->gpu, total, needs.memoryTypeBits, GPU_PLACE_DEVICE);
    for (uint32_t i = 0; i < ranges->buffer_count; i++)
        TOOL_CALL(side->gpu.calls, BindBufferMemory, side->gpu.device, ranges->buffers[i],
                  ranges->memory, i * ranges->stride);
    if (usage_of(part) & VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT)
        find_addresses(side, ranges, scene->count);
}

static void destroy_ranges(const struct side *side, struct scene_ranges *ranges)
{
    for (uint32_t i = 0; i < ranges->buffer_count; i++)
        side->gpu.calls.DestroyBuffer(side->gpu.device, ranges->buffers[i], NULL);
    side->gpu.calls.FreeMemory(side->gpu.device, ranges->memory, NULL);
    free(ranges->buffers);
    free(ranges->addresses);
}

/* ---- structures */

static VkAccelerationStructureBuildGeometryInfoKHR
info_of(const VkAccelerationStructureGeometryKHR *geometry)
{
    return MAKE(VkAccelerationStructureBuildGeometryInfoKHR,
                .type = VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR,
                .flags = VK_BUILD_ACCELERATION_STRUCTURE_PREFER_FAST_TRACE_BIT_KHR,
                .mode = VK_BUILD_ACCELERATION_STRUCTURE_MODE_BUILD_KHR, .geometryCount = 1,
                .pGeometries = geometry);
}

static VkAccelerationStructureBuildSizesInfoKHR sizes_on(const struct side *side)
{
    const VkAccelerationStructureGeometryKHR geometry =
        triangles_geometry(0, VERTICES - 1, VK_INDEX_TYPE_UINT32, 0);
    const VkAccelerationStructureBuildGeometryInfoKHR info = info_of(&geometry);
    const uint32_t triangles = TRIANGLES;
    VkAccelerationStructureBuildSizesInfoKHR sizes = MAKE(VkAccelerationStructureBuildSizesInfoKHR);
    side->gpu.calls.GetAccelerationStructureBuildSizesKHR(
        side->gpu.device, VK_ACCELERATION_STRUCTURE_BUILD_TYPE_DEVICE_KHR, &info, &triangles,
        &sizes);
    return sizes;
}

static void create_structures(struct scene *scene)
{
    const struct side *side = scene->side;
    const struct scene_ranges *ranges = &scene->parts[PART_STRUCTURE];
    bool shared = ranges->buffer_count != scene->count;
    scene->structures = tool_alloc(scene->count, sizeof(*scene->structures));
    for (uint32_t i = 0; i < scene->count; i++) {
        const VkAccelerationStructureCreateInfoKHR create_info =
            MAKE(VkAccelerationStructureCreateInfoKHR, .buffer = ranges->buffers[shared ? 0 : i],
                 .offset = shared ? i * ranges->stride : 0, .size = ranges->size,
                 .type = VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR);
        TOOL_CALL(side->gpu.calls, CreateAccelerationStructureKHR, side->gpu.device, &create_info,
                  NULL, &scene->structures[i]);
    }
}

/* ---- the arrays of the call */

/* A permutation that is the same in every run, and on both sides. */
static uint32_t *permutation(enum order order, uint32_t count)
{
    uint32_t *at = tool_alloc(count, sizeof(*at));
    uint64_t state = 0x9e3779b97f4a7c15;
    for (uint32_t i = 0; i < count; i++)
        at[i] = i;
    for (uint32_t i = count; order == ORDER_SHUFFLED && i-- > 1;) {
        state = state * 6364136223846793005u + 1442695040888963407u;
        uint32_t j = (uint32_t)((state >> 33) % (i + 1)), kept = at[i];
        at[i] = at[j];
        at[j] = kept;
    }
    return at;
}

static void fill_arrays(struct scene *scene, enum order order)
{
    uint32_t *at = permutation(order, scene->count);
    scene->infos = tool_alloc(scene->count, sizeof(*scene->infos));
    scene->geometries = tool_alloc(scene->count, sizeof(*scene->geometries));
    scene->ranges = tool_alloc(scene->count, sizeof(*scene->ranges));
    scene->range_pointers = tool_alloc(scene->count, sizeof(*scene->range_pointers));
    for (uint32_t i = 0; i < scene->count; i++) {
        scene->geometries[i] =
            triangles_geometry(scene->parts[PART_VERTICES].addresses[at[i]], VERTICES - 1,
                               VK_INDEX_TYPE_UINT32, scene->parts[PART_INDICES].addresses[at[i]]);
        scene->infos[i] = info_of(&scene->geometries[i]);
        scene->infos[i].dstAccelerationStructure = scene->structures[at[i]];
        scene->infos[i].scratchData.deviceAddress = scene->parts[PART_SCRATCH].addresses[at[i]];
        scene->ranges[i].primitiveCount = TRIANGLES;
        scene->range_pointers[i] = &scene->ranges[i];
    }
    free(at);
}

/* ---- the whole */

void scene_create(struct scene *scene, const struct side *side, enum buffers buffers,
                  enum order order, uint32_t count)
{
    *scene = (struct scene){.side = side, .count = count};
    VkAccelerationStructureBuildSizesInfoKHR sizes = sizes_on(side);
    VkDeviceSize scratch = sizes.buildScratchSize ? sizes.buildScratchSize : 1;
    create_ranges(scene, PART_VERTICES, buffers, VERTICES * VERTEX_SIZE);
    create_ranges(scene, PART_INDICES, buffers, TRIANGLES * 3 * sizeof(uint32_t));
    create_ranges(scene, PART_STRUCTURE, buffers, sizes.accelerationStructureSize);
    create_ranges(scene, PART_SCRATCH, buffers, scratch);
    create_structures(scene);
    fill_arrays(scene, order);
}

void scene_destroy(struct scene *scene)
{
    const struct side *side = scene->side;
    for (uint32_t i = 0; i < scene->count; i++)
        side->gpu.calls.DestroyAccelerationStructureKHR(side->gpu.device, scene->structures[i],
                                                        NULL);
    for (int part = 0; part < PART_COUNT; part++)
        destroy_ranges(side, &scene->parts[part]);
    free(scene->structures);
    free(scene->infos);
    free(scene->geometries);
    free(scene->ranges);
    free(scene->range_pointers);
}
