/* SPDX-License-Identifier: Apache-2.0 */
/* Builds of one geometry of an extension, from buffers of their own. */
#include "input_scene.h"

#include <string.h>

void input_scene_open(struct input_scene *scene, VkGeometryTypeKHR type, const void *chain)
{
    memset(scene, 0, sizeof(*scene));
    scene->vertices = device_buffer_create(INPUT_SIZE);
    scene->radii = device_buffer_create(INPUT_SIZE);
    scene->indices = device_buffer_create(INPUT_SIZE);
    scene->build.geometry =
        MAKE(VkAccelerationStructureGeometryKHR, .pNext = chain, .geometryType = type);
    scene->build.info = MAKE(VkAccelerationStructureBuildGeometryInfoKHR,
                             .type = VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR,
                             .geometryCount = 1, .pGeometries = &scene->build.geometry);
}

void input_scene_triangles(struct input_scene *scene, const void *chain, uint32_t count,
                           VkDeviceAddress vertices)
{
    scene->build.geometry.geometry.triangles =
        MAKE(VkAccelerationStructureGeometryTrianglesDataKHR, .pNext = chain,
             .vertexFormat = VK_FORMAT_R32G32B32_SFLOAT, .vertexData.deviceAddress = vertices,
             .vertexStride = 12, .maxVertex = 3 * count - 1, .indexType = VK_INDEX_TYPE_NONE_KHR);
    scene->build.range.primitiveCount = count;
}

void input_scene_create(struct input_scene *scene)
{
    scene->blas = fixture_create_for(&scene->build);
    scene->build.info.scratchData.deviceAddress = device_scratch_create(&scene->build);
    scene->build.info.dstAccelerationStructure = scene->blas.handle;
}

void input_scene_build(struct input_scene *scene,
                       const VkAccelerationStructureBuildRangeInfoKHR *ranges, bool is_indirect)
{
    VkCommandBuffer commands = device_begin(PRIMARY);
    if (is_indirect)
        device_build_indirect(commands, &scene->build.info, scene->build.range.primitiveCount,
                              ranges);
    else
        vk.CmdBuildAccelerationStructuresKHR(commands, 1, &scene->build.info, &ranges);
    device_barrier(commands);
    device_finish(commands);
    memset(scene->vertices.bytes, 0xff, INPUT_SIZE);
    memset(scene->radii.bytes, 0xff, INPUT_SIZE);
    memset(scene->indices.bytes, 0xff, INPUT_SIZE);
}

AssayHit input_scene_trace(const struct input_scene *scene, float y, float z)
{
    return fixture_trace(scene->blas.handle, y, z);
}

void input_scene_expect_hit(const struct input_scene *scene, float y, float z, float t,
                            uint32_t primitive)
{
    const AssayHit hit = input_scene_trace(scene, y, z);
    expect_hit_at(hit, t, primitive);
    assert_false(hit.isAabb);
}

void input_scene_expect_miss(const struct input_scene *scene, float y, float z)
{
    assert_false(input_scene_trace(scene, y, z).isHit);
}

/* ---- micromaps */

enum { MICROMAP_TRIANGLES = 3 };

const VkMicromapUsageEXT micromap_usages[2] = {
    {.count = 2, .subdivisionLevel = 0, .format = VK_OPACITY_MICROMAP_FORMAT_2_STATE_EXT},
    {.count = 1, .subdivisionLevel = 1, .format = VK_OPACITY_MICROMAP_FORMAT_4_STATE_EXT}};
const VkMicromapUsageEXT micromap_displacement_usages[2] = {
    {1, 1, VK_DISPLACEMENT_MICROMAP_FORMAT_64_TRIANGLES_64_BYTES_NV},
    {1, 0, VK_DISPLACEMENT_MICROMAP_FORMAT_64_TRIANGLES_64_BYTES_NV}};

static void fill_micromap(unsigned char *bytes)
{
    const VkMicromapTriangleEXT triangles[MICROMAP_TRIANGLES] = {
        {.dataOffset = 1, .format = VK_OPACITY_MICROMAP_FORMAT_2_STATE_EXT},
        {.dataOffset = 2, .format = VK_OPACITY_MICROMAP_FORMAT_2_STATE_EXT},
        {.dataOffset = 7, .subdivisionLevel = 1, .format = VK_OPACITY_MICROMAP_FORMAT_4_STATE_EXT}};
    memcpy(bytes, triangles, sizeof(triangles));
    bytes[DATA + 2] = 1;
    bytes[DATA + 7] = 0 | 1 << 2 | 2 << 4 | 3 << 6;
}

static void write_value(unsigned char *block, uint32_t vertex, uint32_t value)
{
    for (uint32_t bit = 0; bit < 11; bit++)
        if (value >> bit & 1)
            block[(11 * vertex + bit) / 8] |= (unsigned char)(1u << (11 * vertex + bit) % 8);
}

void micromap_rise(const struct micromap *micromap, uint32_t rise)
{
    enum { BLOCK = 64 };
    const VkMicromapTriangleEXT triangles[2] = {
        {0, 1, VK_DISPLACEMENT_MICROMAP_FORMAT_64_TRIANGLES_64_BYTES_NV},
        {BLOCK, 0, VK_DISPLACEMENT_MICROMAP_FORMAT_64_TRIANGLES_64_BYTES_NV}};
    unsigned char *bytes = micromap->input.bytes;
    memset(bytes, 0, MICROMAP_SIZE);
    memcpy(bytes, triangles, sizeof(triangles));
    for (uint32_t i = 0; i < 3; i++) {
        write_value(bytes + DATA, 3 + i, rise);
        write_value(bytes + DATA + BLOCK, i, rise);
    }
}

static void prepare(struct micromap *micromap, VkMicromapTypeEXT type,
                    const VkMicromapUsageEXT *usages)
{
    *micromap = (struct micromap){.storage = device_buffer_create(MICROMAP_SIZE),
                                  .input = device_buffer_create(MICROMAP_SIZE),
                                  .type = type,
                                  .usages = usages};
}

static void create_ext(struct micromap *micromap)
{
    const STRUCT(VkMicromapCreateInfoEXT, info, .buffer = micromap->storage.handle,
                 .size = MICROMAP_SIZE, .type = micromap->type);
    GET(vk.CreateMicromapEXT(device, &info, NULL, &micromap->ext));
    OWN(DestroyMicromapEXT, micromap->ext);
}

void micromap_open_displacement(struct micromap *micromap)
{
    prepare(micromap, VK_MICROMAP_TYPE_DISPLACEMENT_MICROMAP_NV, micromap_displacement_usages);
    create_ext(micromap);
}

void micromap_open(struct micromap *micromap, bool is_ext)
{
    prepare(micromap, VK_MICROMAP_TYPE_OPACITY_MICROMAP_EXT, micromap_usages);
    const STRUCT(VkAccelerationStructureCreateInfo2KHR, khr,
                 .addressRange = {micromap->storage.address, MICROMAP_SIZE},
                 .type = VK_ACCELERATION_STRUCTURE_TYPE_OPACITY_MICROMAP_KHR);
    if (is_ext) {
        create_ext(micromap);
    } else {
        GET(vk.CreateAccelerationStructure2KHR(device, &khr, NULL, &micromap->khr));
        OWN(DestroyAccelerationStructureKHR, micromap->khr);
    }
    fill_micromap(micromap->input.bytes);
}

VkMicromapBuildInfoEXT micromap_info(const struct micromap *micromap, uint64_t base)
{
    return MAKE(VkMicromapBuildInfoEXT, .type = micromap->type,
                .flags = VK_BUILD_MICROMAP_ALLOW_COMPACTION_BIT_EXT,
                .mode = VK_BUILD_MICROMAP_MODE_BUILD_EXT, .dstMicromap = micromap->ext,
                .usageCountsCount = 2, .pUsageCounts = micromap->usages,
                .data.deviceAddress = base + DATA, .triangleArray.deviceAddress = base,
                .triangleArrayStride = sizeof(VkMicromapTriangleEXT));
}

VkResult micromap_build_by_host(const struct micromap *micromap)
{
    const VkMicromapBuildInfoEXT info =
        micromap_info(micromap, (uint64_t)(uintptr_t)micromap->input.bytes);
    return vk.BuildMicromapsEXT(device, VK_NULL_HANDLE, 1, &info);
}

static void record_khr(const struct micromap *micromap, VkCommandBuffer commands)
{
    VkMicromapUsageKHR own[2];
    const VkMicromapUsageKHR *const pointers[2] = {&own[0], &own[1]};
    memcpy(own, micromap_usages, sizeof(own));
    const STRUCT(VkAccelerationStructureGeometryMicromapDataKHR, data, .usageCountsCount = 2,
                 .ppUsageCounts = pointers, .data = micromap->input.address + DATA,
                 .triangleArray = micromap->input.address,
                 .triangleArrayStride = sizeof(VkMicromapTriangleKHR));
    const STRUCT(VkAccelerationStructureGeometryKHR, geometry, .pNext = &data,
                 .geometryType = VK_GEOMETRY_TYPE_MICROMAP_KHR);
    const STRUCT(VkAccelerationStructureBuildGeometryInfoKHR, info,
                 .type = VK_ACCELERATION_STRUCTURE_TYPE_OPACITY_MICROMAP_KHR,
                 .dstAccelerationStructure = micromap->khr, .geometryCount = 1,
                 .pGeometries = &geometry, .scratchData.deviceAddress = micromap->storage.address);
    const VkAccelerationStructureBuildRangeInfoKHR *const no_range = NULL;
    vk.CmdBuildAccelerationStructuresKHR(commands, 1, &info, &no_range);
}

void micromap_build_by_device(const struct micromap *micromap)
{
    const VkMicromapBuildInfoEXT info = micromap_info(micromap, micromap->input.address);
    VkCommandBuffer commands = device_begin(PRIMARY);
    if (micromap->ext)
        vk.CmdBuildMicromapsEXT(commands, 1, &info);
    else
        record_khr(micromap, commands);
    device_finish(commands);
    memset(micromap->input.bytes, 0xff, MICROMAP_SIZE);
}

/* ---- copies */

static VkCopyMicromapInfoEXT copy_info(const struct micromap *src, const struct micromap *dst,
                                       VkCopyMicromapModeEXT mode)
{
    return MAKE(VkCopyMicromapInfoEXT, .src = src->ext, .dst = dst->ext, .mode = mode);
}

VkResult micromap_copy_by_host(const struct micromap *src, const struct micromap *dst,
                               VkCopyMicromapModeEXT mode)
{
    const VkCopyMicromapInfoEXT info = copy_info(src, dst, mode);
    return vk.CopyMicromapEXT(device, VK_NULL_HANDLE, &info);
}

void micromap_clone_by_device(VkCommandBuffer commands, const struct micromap *src,
                              const struct micromap *dst)
{
    const VkCopyMicromapInfoEXT info = copy_info(src, dst, VK_COPY_MICROMAP_MODE_CLONE_EXT);
    vk.CmdCopyMicromapEXT(commands, &info);
}

VkResult micromap_save_by_host(const struct micromap *src, void *dst)
{
    const STRUCT(VkCopyMicromapToMemoryInfoEXT, info, .src = src->ext, .dst.hostAddress = dst,
                 .mode = VK_COPY_MICROMAP_MODE_SERIALIZE_EXT);
    return vk.CopyMicromapToMemoryEXT(device, VK_NULL_HANDLE, &info);
}

VkResult micromap_load_by_host(const void *src, const struct micromap *dst)
{
    const STRUCT(VkCopyMemoryToMicromapInfoEXT, info, .src.hostAddress = src, .dst = dst->ext,
                 .mode = VK_COPY_MICROMAP_MODE_DESERIALIZE_EXT);
    return vk.CopyMemoryToMicromapEXT(device, VK_NULL_HANDLE, &info);
}
