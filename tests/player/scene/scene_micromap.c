/* SPDX-License-Identifier: Apache-2.0 */
/* Builds of micromaps, and geometries that use them. */
#include <string.h>

#include "tests/fixture/copies.h"
#include "tests/player/scene/scene.h"

enum { SERIALIZED_SIZE = 1 << 16 };
enum { MICROMAP_SIZE = 16 * 1024 }; /* suffices for harsh limits, too */

VkAccelerationStructureKHR scene_micromap_structure(struct scene *scene,
                                                    VkAccelerationStructureTypeKHR type)
{
    const struct device_buffer buffer = scene_buffer(scene, 4 * MICROMAP_SIZE, ACCEL_USAGE);
    /* Without the feature, a micromap cannot be created. */
    if (setup_has(&scene->fixture->setup, WITHOUT_MICROMAP_KHR))
        type = VK_ACCELERATION_STRUCTURE_TYPE_GENERIC_KHR;
    return scene_accel_in(scene, &buffer, 0, buffer.size, type);
}

/* As many as there may be. */
static void fill_triangles(VkMicromapTriangleKHR *triangles)
{
    for (size_t i = 0; i < SCENE_MICROMAP_INPUT_SIZE / sizeof(*triangles); i++)
        triangles[i] = (VkMicromapTriangleKHR){.format = VK_OPACITY_MICROMAP_FORMAT_2_STATE_KHR};
}

void scene_build_micromap(struct scene *scene)
{
    struct scene_micromaps *micromaps = &scene->micromaps;
    VkAccelerationStructureBuildGeometryInfoKHR *info = &scene->infos[AABBS];
    const struct device_buffer data = scene_input(scene, SCENE_MICROMAP_INPUT_SIZE, INPUT_USAGE);
    const struct device_buffer triangles =
        scene_input(scene, SCENE_MICROMAP_INPUT_SIZE, INPUT_USAGE);

    micromaps->triangles = (VkMicromapTriangleKHR *)(void *)triangles.bytes;
    micromaps->triangle_buffer = triangles;
    fill_triangles(micromaps->triangles);
    for (uint32_t i = 0; i < SCENE_USAGES; i++) {
        micromaps->usages[i] =
            (VkMicromapUsageKHR){.count = 1, .format = VK_OPACITY_MICROMAP_FORMAT_2_STATE_KHR};
        micromaps->usage_pointers[i] = &micromaps->usages[i];
    }
    micromaps->data = MAKE(VkAccelerationStructureGeometryMicromapDataKHR, .usageCountsCount = 1,
                           .pUsageCounts = micromaps->usages, .data = data.address,
                           .triangleArray = triangles.address,
                           .triangleArrayStride = sizeof(VkMicromapTriangleKHR));
    info->type = VK_ACCELERATION_STRUCTURE_TYPE_OPACITY_MICROMAP_KHR;
    info->flags = 0;
    info->geometryCount = 1;
    info->dstAccelerationStructure = scene_micromap_structure(
        scene, command_is_on_host(scene->command)
                   ? VK_ACCELERATION_STRUCTURE_TYPE_GENERIC_KHR /* which is created in a buffer */
                   : VK_ACCELERATION_STRUCTURE_TYPE_OPACITY_MICROMAP_KHR);
    for (uint32_t i = 0; i < 2; i++)
        scene->geometries[AABBS][i] =
            MAKE(VkAccelerationStructureGeometryKHR, .pNext = &micromaps->data,
                 .geometryType = VK_GEOMETRY_TYPE_MICROMAP_KHR);
    if (!command_is_on_host(scene->command)) /* which requires a pointer */
        scene->range_pointers[AABBS] = NULL;
}

VkAccelerationStructureKHR scene_record_micromap(struct scene *scene, uint32_t triangle_count)
{
    const VkAccelerationStructureKHR micromap =
        scene_micromap_structure(scene, VK_ACCELERATION_STRUCTURE_TYPE_OPACITY_MICROMAP_KHR);
    const struct device_buffer input = scene_input(scene, SCENE_MICROMAP_INPUT_SIZE, INPUT_USAGE);
    const struct device_buffer scratch = scene_buffer(scene, MICROMAP_SIZE, SCRATCH_USAGE);
    fill_triangles((VkMicromapTriangleKHR *)(void *)input.bytes);
    const VkMicromapUsageKHR usage = {.count = triangle_count,
                                      .format = VK_OPACITY_MICROMAP_FORMAT_2_STATE_KHR};
    const STRUCT(VkAccelerationStructureGeometryMicromapDataKHR, data, .usageCountsCount = 1,
                 .pUsageCounts = &usage, .data = input.address, .triangleArray = input.address,
                 .triangleArrayStride = sizeof(VkMicromapTriangleKHR));
    const STRUCT(VkAccelerationStructureGeometryKHR, geometry, .pNext = &data,
                 .geometryType = VK_GEOMETRY_TYPE_MICROMAP_KHR);
    const STRUCT(VkAccelerationStructureBuildGeometryInfoKHR, info,
                 .type = VK_ACCELERATION_STRUCTURE_TYPE_OPACITY_MICROMAP_KHR,
                 .dstAccelerationStructure = micromap, .geometryCount = 1, .pGeometries = &geometry,
                 .scratchData.deviceAddress = scratch.address);
    const VkAccelerationStructureBuildRangeInfoKHR *const no_range = NULL;
    const VkCommandBuffer command_buffer = scene_begin_before(scene);
    scene->vk->CmdBuildAccelerationStructuresKHR(command_buffer, 1, &info, &no_range);
    scene_end_before(scene, command_buffer);
    return micromap;
}

VkDeviceAddress scene_serialized(struct scene *scene)
{
    const struct device_buffer buffer = scene_buffer(scene, SERIALIZED_SIZE, SCRATCH_USAGE);
    memcpy(buffer.bytes, &NULL_DRIVER_SERIALIZED, sizeof(NULL_DRIVER_SERIALIZED));
    return buffer.address;
}

void scene_deserialize(struct scene *scene, VkAccelerationStructureKHR structure)
{
    const VkCopyMemoryToAccelerationStructureInfoKHR info =
        deserialize_info(scene_serialized(scene), structure);
    scene->vk->CmdCopyMemoryToAccelerationStructureKHR(scene->command_buffer, &info);
    scene_barrier(scene, scene->command_buffer);
}

void scene_use_micromap(struct scene *scene)
{
    struct scene_micromaps *micromaps = &scene->micromaps;
    micromaps->opacity =
        MAKE(VkAccelerationStructureTrianglesOpacityMicromapKHR, .indexType = VK_INDEX_TYPE_UINT32,
             .indexBuffer = scene->indices.address, .indexStride = 4);
    if (!command_is_on_host(scene->command))
        micromaps->opacity.micromap =
            scene_micromap_structure(scene, VK_ACCELERATION_STRUCTURE_TYPE_OPACITY_MICROMAP_KHR);
    scene->geometries[INDEXED][0].geometry.triangles.pNext = &micromaps->opacity;
    scene_fit(scene, INDEXED);
}

/* ---- VK_EXT_opacity_micromap and VK_NV_displacement_micromap */

SCENE_CREATES(create, MicromapEXT, VkMicromapEXT, VkMicromapCreateInfoEXT)

VkMicromapEXT scene_micromap_ext(struct scene *scene, VkMicromapTypeEXT type)
{
    const struct device_buffer buffer = scene_buffer(scene, MICROMAP_SIZE,
                                                     VK_BUFFER_USAGE_MICROMAP_STORAGE_BIT_EXT |
                                                         VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT);
    const STRUCT(VkMicromapCreateInfoEXT, create_info, .buffer = buffer.handle, .size = buffer.size,
                 .type = type);
    return create(scene, &create_info);
}

static void set_usages_ext(struct scene_micromaps *micromaps)
{
    for (uint32_t i = 0; i < SCENE_USAGES; i++) {
        micromaps->usages_ext[i] =
            (VkMicromapUsageEXT){.count = 1, .format = VK_OPACITY_MICROMAP_FORMAT_2_STATE_EXT};
        micromaps->usage_pointers_ext[i] = &micromaps->usages_ext[i];
    }
}

void scene_use_micromap_ext(struct scene *scene)
{
    struct scene_micromaps *micromaps = &scene->micromaps;
    set_usages_ext(micromaps);
    micromaps->opacity_ext =
        MAKE(VkAccelerationStructureTrianglesOpacityMicromapEXT, .indexType = VK_INDEX_TYPE_UINT32,
             .indexBuffer.deviceAddress = scene_address(scene, &scene->indices, 0),
             .indexStride = 4, .usageCountsCount = 1, .pUsageCounts = micromaps->usages_ext,
             .micromap = scene_micromap_ext(scene, VK_MICROMAP_TYPE_OPACITY_MICROMAP_EXT));
    scene->geometries[INDEXED][0].geometry.triangles.pNext = &micromaps->opacity_ext;
    scene_fit(scene, INDEXED);
}

static VkDeviceOrHostAddressKHR address_of(const struct device_buffer *buffer, VkDeviceSize offset,
                                           bool is_on_host)
{
    if (is_on_host)
        return (VkDeviceOrHostAddressKHR){.hostAddress = buffer->bytes + offset};
    return (VkDeviceOrHostAddressKHR){.deviceAddress = buffer->address + offset};
}

struct scene_micromap_build scene_build_of_micromap(struct scene *scene, VkMicromapTypeEXT type,
                                                    VkMicromapEXT dst,
                                                    const VkMicromapUsageEXT *usage,
                                                    bool is_on_host)
{
    const struct device_buffer input =
        scene_buffer(scene, SCENE_MICROMAP_INPUT_SIZE,
                     VK_BUFFER_USAGE_MICROMAP_BUILD_INPUT_READ_ONLY_BIT_EXT |
                         VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT);
    const struct device_buffer scratch = scene_buffer(scene, MICROMAP_SIZE, SCRATCH_USAGE);
    const VkMicromapTriangleEXT triangle = {.format = (uint16_t)usage->format};
    const VkDeviceSize at = input.size / 2;
    memset(input.bytes, 0, input.size);
    for (VkDeviceSize i = at; i < input.size; i += sizeof(triangle))
        memcpy(input.bytes + i, &triangle, sizeof(triangle));
    return (struct scene_micromap_build){
        .input = input,
        .scratch = scratch,
        .info =
            MAKE(VkMicromapBuildInfoEXT, .type = type, .mode = VK_BUILD_MICROMAP_MODE_BUILD_EXT,
                 .dstMicromap = dst, .usageCountsCount = 1, .pUsageCounts = usage,
                 .data.deviceAddress = address_of(&input, 0, is_on_host).deviceAddress,
                 .scratchData = address_of(&scratch, 0, is_on_host),
                 .triangleArray.deviceAddress = address_of(&input, at, is_on_host).deviceAddress,
                 .triangleArrayStride = sizeof(triangle))};
}

/* Builds a displacement of one undivided triangle; builds on the host read it at once. */
static void build_displacement(struct scene *scene, VkMicromapEXT micromap)
{
    const VkMicromapBuildInfoEXT info =
        scene_build_of_micromap(scene, VK_MICROMAP_TYPE_DISPLACEMENT_MICROMAP_NV, micromap,
                                scene->micromaps.usages_ext, true)
            .info;
    GET(scene->vk->BuildMicromapsEXT(scene->fixture->device, VK_NULL_HANDLE, 1, &info));
}

void scene_use_displacement(struct scene *scene)
{
    struct scene_micromaps *micromaps = &scene->micromaps;
    set_usages_ext(micromaps);
    micromaps->displacement = (VkAccelerationStructureTrianglesDisplacementMicromapNV){
        .sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_TRIANGLES_DISPLACEMENT_MICROMAP_NV,
        .displacementBiasAndScaleFormat = VK_FORMAT_R32G32_SFLOAT,
        .displacementVectorFormat = VK_FORMAT_R32G32B32_SFLOAT,
        .displacementBiasAndScaleBuffer.deviceAddress = scene_address(scene, &scene->vertices, 0),
        .displacementBiasAndScaleStride = 8,
        .displacementVectorBuffer.deviceAddress = scene_address(scene, &scene->vertices, 0),
        .displacementVectorStride = 12,
        .displacedMicromapPrimitiveFlags.deviceAddress = scene_address(scene, &scene->indices, 0),
        .displacedMicromapPrimitiveFlagsStride = 1,
        .indexType = VK_INDEX_TYPE_UINT32,
        .indexBuffer.deviceAddress = scene_address(scene, &scene->indices, 0),
        .indexStride = 0, /* the first, which is 0, for all triangles */
        .usageCountsCount = 1,
        .pUsageCounts = micromaps->usages_ext,
        .micromap = scene_micromap_ext(scene, VK_MICROMAP_TYPE_DISPLACEMENT_MICROMAP_NV),
    };
    build_displacement(scene, micromaps->displacement.micromap);
    scene->geometries[INDEXED][0].geometry.triangles.pNext = &micromaps->displacement;
    scene_fit(scene, INDEXED);
}
