/* SPDX-License-Identifier: Apache-2.0 */
/* The application's use of micromaps: builds of them, builds that use them, and an update. */
#include "application_parts.h"

enum {
    OBJECT = 4096,
    ACCEL_AT = MICROMAPS * OBJECT,
    SCRATCH_AT = ACCEL_AT + ACCEL_SIZE,
    INPUT_AT = SCRATCH_AT + (1 << 16),
};

/* Of VK_EXT_opacity_micromap. */
static VkMicromapEXT micromaps[MICROMAPS];
/* One of VK_KHR_opacity_micromap, and what uses all of them; all are in one buffer. */
static VkAccelerationStructureKHR micromap, with_micromaps;
static VkBuffer buffer;

static void create_micromap_khr(void)
{
    const STRUCT(VkAccelerationStructureCreateInfo2KHR, info,
                 .addressRange = {.address = address_of(buffer), .size = OBJECT},
                 .addressFlags = VK_ADDRESS_COMMAND_STORAGE_BUFFER_USAGE_BIT_KHR,
                 .type = VK_ACCELERATION_STRUCTURE_TYPE_OPACITY_MICROMAP_KHR);
    CALL(CreateAccelerationStructure2KHR, device, &info, NULL, &micromap);
    OWN(DestroyAccelerationStructureKHR, micromap);
}

void create_micromaps(void)
{
    const VkDeviceSize size = INPUT_AT + (1 << 16);
    buffer = create_bound_buffer(
        size,
        VK_BUFFER_USAGE_MICROMAP_STORAGE_BIT_EXT |
            VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_STORAGE_BIT_KHR |
            VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_BIT_KHR |
            VK_BUFFER_USAGE_MICROMAP_BUILD_INPUT_READ_ONLY_BIT_EXT |
            VK_BUFFER_USAGE_STORAGE_BUFFER_BIT,
        DEVICE_MEMORY);
    for (unsigned i = 1; i < MICROMAPS; i++) {
        micromaps[i] =
            create_micromap(buffer, i * OBJECT, OBJECT, VK_MICROMAP_TYPE_OPACITY_MICROMAP_EXT);
        name_object(VK_OBJECT_TYPE_MICROMAP_EXT, (uint64_t)micromaps[i], "micromap", i);
    }
    create_micromap_khr();
    with_micromaps =
        create_accel(buffer, ACCEL_AT, ACCEL_SIZE, VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR);
}

static void build_micromaps(VkCommandBuffer command_buffer)
{
    const VkDeviceAddress address = address_of(buffer);
    VkMicromapBuildInfoEXT infos[MICROMAPS];
    for (unsigned i = 1; i < MICROMAPS; i++)
        infos[i] =
            MAKE(VkMicromapBuildInfoEXT, .type = VK_MICROMAP_TYPE_OPACITY_MICROMAP_EXT,
                 .dstMicromap = micromaps[i], .data.deviceAddress = address + INPUT_AT,
                 .triangleArray.deviceAddress = address + INPUT_AT,
                 .scratchData.deviceAddress = address + SCRATCH_AT + (VkDeviceSize)i * OBJECT / 2);
    vk.CmdBuildMicromapsEXT(command_buffer, MICROMAPS - 1, infos + 1);
}

static void build_micromap_khr(VkCommandBuffer command_buffer)
{
    const VkDeviceAddress address = address_of(buffer);
    const VkMicromapUsageKHR usage = {.count = 4, .format = VK_OPACITY_MICROMAP_FORMAT_2_STATE_KHR};
    const STRUCT(VkAccelerationStructureGeometryMicromapDataKHR, data, .usageCountsCount = 1,
                 .pUsageCounts = &usage, .data = address + INPUT_AT,
                 .triangleArray = address + INPUT_AT,
                 .triangleArrayStride = sizeof(VkMicromapTriangleKHR));
    const STRUCT(VkAccelerationStructureBuildGeometryInfoKHR, info,
                 .type = VK_ACCELERATION_STRUCTURE_TYPE_OPACITY_MICROMAP_KHR,
                 .dstAccelerationStructure = micromap, .geometryCount = 1,
                 .pGeometries = &MAKE(VkAccelerationStructureGeometryKHR, .pNext = &data,
                                      .geometryType = VK_GEOMETRY_TYPE_MICROMAP_KHR),
                 .scratchData.deviceAddress = address + SCRATCH_AT);
    const VkAccelerationStructureBuildRangeInfoKHR *const no_range = NULL;
    vk.CmdBuildAccelerationStructuresKHR(command_buffer, 1, &info, &no_range);
}

/* One geometry for each micromap, and an update of all. */
static void build_with_micromaps(VkCommandBuffer command_buffer)
{
    VkAccelerationStructureTrianglesOpacityMicromapEXT ext[GEOMETRIES];
    VkAccelerationStructureTrianglesOpacityMicromapKHR khr[GEOMETRIES];
    VkAccelerationStructureGeometryKHR geometries[GEOMETRIES];
    VkAccelerationStructureBuildRangeInfoKHR ranges[GEOMETRIES];
    const VkAccelerationStructureBuildRangeInfoKHR *const range_array = ranges;
    for (unsigned i = 0; i < GEOMETRIES; i++) {
        khr[i] = MAKE(VkAccelerationStructureTrianglesOpacityMicromapKHR,
                      .indexType = VK_INDEX_TYPE_NONE_KHR, .micromap = micromap);
        ext[i] = MAKE(VkAccelerationStructureTrianglesOpacityMicromapEXT, .pNext = &khr[i],
                      .indexType = VK_INDEX_TYPE_NONE_KHR, .micromap = micromaps[i + 1]);
        geometries[i] = describe_triangles(
            (VkDeviceOrHostAddressConstKHR){.deviceAddress = app.input_address}, &ext[i]);
        ranges[i] = (VkAccelerationStructureBuildRangeInfoKHR){.primitiveCount = 1};
    }
    for (int i = 0; i < 2; i++) {
        VkAccelerationStructureBuildGeometryInfoKHR info = describe_build(
            with_micromaps, i ? with_micromaps : VK_NULL_HANDLE, GEOMETRIES, geometries);
        info.scratchData.deviceAddress = app.scratch_address;
        vk.CmdBuildAccelerationStructuresKHR(command_buffer, 1, &info, &range_array);
    }
}

void record_micromaps(VkCommandBuffer command_buffer)
{
    build_micromaps(command_buffer);
    build_micromap_khr(command_buffer);
    build_with_micromaps(command_buffer);
}
