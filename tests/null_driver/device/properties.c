/* SPDX-License-Identifier: Apache-2.0 */
/* Properties: those that a test may set come from the configuration, the others are fixed. */
#include "tests/null_driver/internal.h"

static const VkPhysicalDeviceExternalMemoryHostPropertiesEXT external_memory_host = {
    .minImportedHostPointerAlignment = 4096};

static const VkPhysicalDeviceDescriptorBufferPropertiesEXT descriptor_buffer = {
    .accelerationStructureCaptureReplayDescriptorDataSize = 24};

/* From where a structure's members are copied: one of the above, or the configuration at offset. */
struct property_row {
    VkStructureType sType;
    enum guard guard;
    const void *fixed;
    size_t offset;
    size_t size;
};

#define HEADER sizeof(VkBaseOutStructure)
#define ROW(guard, name, fixed)                                                                    \
    {VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_##name, guard, (const char *)&(fixed) + HEADER, 0,          \
     sizeof(fixed) - HEADER},
/* A structure whose members are also those of another one, from first to last. */
#define PART(guard, name, whole, first, last)                                                      \
    {VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_##name, guard, &(whole).first, 0,                           \
     (size_t)((const char *)(&(whole).last + 1) - (const char *)&(whole).first)},
#define CONFIGURED(guard, name, member)                                                            \
    {VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_##name, guard, NULL,                                        \
     offsetof(struct null_driver_config, member) + HEADER,                                         \
     sizeof(((struct null_driver_config *)NULL)->member) - HEADER},

/* clang-format off */
static const struct property_row rows[] = {
    ROW(V1_2, VULKAN_1_1_PROPERTIES, vulkan11)
    ROW(V1_2, VULKAN_1_2_PROPERTIES, vulkan12)
    ROW(V1_3, VULKAN_1_3_PROPERTIES, vulkan13)
    PART(KHR_driver_properties, DRIVER_PROPERTIES, vulkan12, driverID, conformanceVersion)
    PART(V1_0, ID_PROPERTIES, vulkan11, deviceUUID, deviceLUIDValid)
    PART(V1_1, SUBGROUP_PROPERTIES, vulkan11, subgroupSize, subgroupQuadOperationsInAllStages)
    CONFIGURED(V1_1, PROTECTED_MEMORY_PROPERTIES, protected_properties)
    PART(KHR_maintenance3, MAINTENANCE_3_PROPERTIES, vulkan11, maxPerSetDescriptors,
         maxMemoryAllocationSize)
    PART(KHR_maintenance4, MAINTENANCE_4_PROPERTIES, vulkan13, maxBufferSize, maxBufferSize)
    PART(KHR_timeline_semaphore, TIMELINE_SEMAPHORE_PROPERTIES, vulkan12,
         maxTimelineSemaphoreValueDifference, maxTimelineSemaphoreValueDifference)
    PART(KHR_push_descriptor, PUSH_DESCRIPTOR_PROPERTIES, vulkan14, maxPushDescriptors,
         maxPushDescriptors)
    ROW(EXT_external_memory_host, EXTERNAL_MEMORY_HOST_PROPERTIES_EXT, external_memory_host)
    ROW(EXT_descriptor_buffer, DESCRIPTOR_BUFFER_PROPERTIES_EXT, descriptor_buffer)
    CONFIGURED(KHR_acceleration_structure, ACCELERATION_STRUCTURE_PROPERTIES_KHR, as_properties)
    CONFIGURED(NV_ray_tracing, RAY_TRACING_PROPERTIES_NV, nv_properties)
    CONFIGURED(KHR_ray_tracing_pipeline, RAY_TRACING_PIPELINE_PROPERTIES_KHR, pipeline_properties)
    CONFIGURED(EXT_opacity_micromap, OPACITY_MICROMAP_PROPERTIES_EXT, micromap_properties)
    CONFIGURED(KHR_opacity_micromap, OPACITY_MICROMAP_PROPERTIES_KHR, micromap_properties_khr)
#ifdef VK_NV_displacement_micromap
    CONFIGURED(NV_displacement_micromap, DISPLACEMENT_MICROMAP_PROPERTIES_NV,
               displacement_properties)
#endif
    CONFIGURED(NV_cluster_acceleration_structure, CLUSTER_ACCELERATION_STRUCTURE_PROPERTIES_NV,
               cluster_properties)
    CONFIGURED(NV_partitioned_acceleration_structure,
               PARTITIONED_ACCELERATION_STRUCTURE_PROPERTIES_NV, partition_properties)
};
/* clang-format on */

static void fill(const struct null_driver_config *config, const struct property_row *row,
                 VkBaseOutStructure *out)
{
    memcpy(out + 1, row->fixed != NULL ? row->fixed : (const char *)config + row->offset,
           row->size);
}

void properties_fill(const struct null_driver_config *config, uint32_t index,
                     VkPhysicalDeviceProperties2 *properties)
{
    properties->properties = config->properties;
    properties->properties.apiVersion = config->api_version;
    for (VkBaseOutStructure *out = properties->pNext; out != NULL; out = out->pNext) {
        for (size_t i = 0; i < COUNT_OF(rows); i++) {
            if (rows[i].sType == out->sType && guard_is_known(config, rows[i].guard))
                fill(config, &rows[i], out);
        }
        /* Devices of a group differ in nothing else. Both begin with the device's UUID. */
        if (out->sType == VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_ID_PROPERTIES ||
            out->sType == VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_1_PROPERTIES)
            *(uint8_t *)(out + 1) = (uint8_t)(index + 1);
    }
}
