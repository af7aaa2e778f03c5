/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Features. A row for each structure: VkBool32 members behind sType and pNext, all on save for what
 * the configuration says. A structure whose features are also members of a VkPhysicalDeviceVulkan1x
 * one names the first of them there (the rest follow in the same order), and shares their values.
 */
#include "internal.h"

struct feature_row {
    VkStructureType sType;
    enum guard guard;
    uint32_t end;         /* of the last member; there may be padding behind it */
    VkStructureType home; /* its own sType where it shares with none */
    uint32_t home_offset;
};

#define FIRST_MEMBER ((uint32_t)sizeof(VkBaseOutStructure))
#define STYPE(name) VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_##name
/* Doesn't compile where the structure has another number of members. */
#define END(type, count)                                                                           \
    (FIRST_MEMBER + (count) * sizeof(VkBool32) +                                                   \
     0 * sizeof(char[((count) + 1) / 2 * 8 == sizeof(type) - FIRST_MEMBER ? 1 : -1]))
#define OWN(guard, type, name, count)                                                              \
    {STYPE(name), guard, END(VkPhysicalDevice##type, count), STYPE(name), FIRST_MEMBER},
#define PART(guard, type, name, count, version, first)                                             \
    {STYPE(name), guard, END(VkPhysicalDevice##type, count), STYPE(VULKAN_1_##version##_FEATURES), \
     offsetof(VkPhysicalDeviceVulkan1##version##Features, first)},

/* clang-format off */
static const struct feature_row rows[] = {
    OWN(V1_0, Features2, FEATURES_2, 55)
    OWN(V1_2, Vulkan11Features, VULKAN_1_1_FEATURES, 12)
    OWN(V1_2, Vulkan12Features, VULKAN_1_2_FEATURES, 47)
    OWN(V1_3, Vulkan13Features, VULKAN_1_3_FEATURES, 15)
    OWN(V1_4, Vulkan14Features, VULKAN_1_4_FEATURES, 21)
    PART(KHR_16bit_storage, 16BitStorageFeatures, 16BIT_STORAGE_FEATURES, 4, 1, storageBuffer16BitAccess)
    PART(KHR_multiview, MultiviewFeatures, MULTIVIEW_FEATURES, 3, 1, multiview)
    PART(KHR_variable_pointers, VariablePointersFeatures, VARIABLE_POINTERS_FEATURES, 2, 1, variablePointersStorageBuffer)
    PART(V1_1, ProtectedMemoryFeatures, PROTECTED_MEMORY_FEATURES, 1, 1, protectedMemory)
    PART(KHR_sampler_ycbcr_conversion, SamplerYcbcrConversionFeatures, SAMPLER_YCBCR_CONVERSION_FEATURES, 1, 1, samplerYcbcrConversion)
    PART(V1_1, ShaderDrawParametersFeatures, SHADER_DRAW_PARAMETERS_FEATURES, 1, 1, shaderDrawParameters)
    PART(KHR_8bit_storage, 8BitStorageFeatures, 8BIT_STORAGE_FEATURES, 3, 2, storageBuffer8BitAccess)
    PART(KHR_shader_float16_int8, ShaderFloat16Int8Features, SHADER_FLOAT16_INT8_FEATURES, 2, 2, shaderFloat16)
    PART(EXT_descriptor_indexing, DescriptorIndexingFeatures, DESCRIPTOR_INDEXING_FEATURES, 20, 2, shaderInputAttachmentArrayDynamicIndexing)
    PART(EXT_scalar_block_layout, ScalarBlockLayoutFeatures, SCALAR_BLOCK_LAYOUT_FEATURES, 1, 2, scalarBlockLayout)
    PART(KHR_imageless_framebuffer, ImagelessFramebufferFeatures, IMAGELESS_FRAMEBUFFER_FEATURES, 1, 2, imagelessFramebuffer)
    PART(KHR_uniform_buffer_standard_layout, UniformBufferStandardLayoutFeatures, UNIFORM_BUFFER_STANDARD_LAYOUT_FEATURES, 1, 2, uniformBufferStandardLayout)
    PART(EXT_host_query_reset, HostQueryResetFeatures, HOST_QUERY_RESET_FEATURES, 1, 2, hostQueryReset)
    PART(KHR_timeline_semaphore, TimelineSemaphoreFeatures, TIMELINE_SEMAPHORE_FEATURES, 1, 2, timelineSemaphore)
    PART(KHR_buffer_device_address, BufferDeviceAddressFeatures, BUFFER_DEVICE_ADDRESS_FEATURES, 3, 2, bufferDeviceAddress)
    PART(KHR_vulkan_memory_model, VulkanMemoryModelFeatures, VULKAN_MEMORY_MODEL_FEATURES, 3, 2, vulkanMemoryModel)
    PART(EXT_private_data, PrivateDataFeatures, PRIVATE_DATA_FEATURES, 1, 3, privateData)
    PART(KHR_synchronization2, Synchronization2Features, SYNCHRONIZATION_2_FEATURES, 1, 3, synchronization2)
    PART(KHR_dynamic_rendering, DynamicRenderingFeatures, DYNAMIC_RENDERING_FEATURES, 1, 3, dynamicRendering)
    PART(KHR_maintenance4, Maintenance4Features, MAINTENANCE_4_FEATURES, 1, 3, maintenance4)
    PART(KHR_index_type_uint8, IndexTypeUint8Features, INDEX_TYPE_UINT8_FEATURES, 1, 4, indexTypeUint8)
    PART(EXT_index_type_uint8, IndexTypeUint8Features, INDEX_TYPE_UINT8_FEATURES, 1, 4, indexTypeUint8)
    PART(KHR_maintenance5, Maintenance5Features, MAINTENANCE_5_FEATURES, 1, 4, maintenance5)
    PART(KHR_maintenance6, Maintenance6Features, MAINTENANCE_6_FEATURES, 1, 4, maintenance6)
    OWN(EXT_buffer_device_address, BufferDeviceAddressFeaturesEXT, BUFFER_DEVICE_ADDRESS_FEATURES_EXT, 3)
    OWN(EXT_opacity_micromap, OpacityMicromapFeaturesEXT, OPACITY_MICROMAP_FEATURES_EXT, 3)
    OWN(KHR_acceleration_structure, AccelerationStructureFeaturesKHR, ACCELERATION_STRUCTURE_FEATURES_KHR, 5)
    OWN(KHR_device_address_commands, DeviceAddressCommandsFeaturesKHR, DEVICE_ADDRESS_COMMANDS_FEATURES_KHR, 1)
    OWN(KHR_opacity_micromap, OpacityMicromapFeaturesKHR, OPACITY_MICROMAP_FEATURES_KHR, 1)
    OWN(KHR_ray_query, RayQueryFeaturesKHR, RAY_QUERY_FEATURES_KHR, 1)
    OWN(KHR_ray_tracing_maintenance1, RayTracingMaintenance1FeaturesKHR, RAY_TRACING_MAINTENANCE_1_FEATURES_KHR, 2)
    OWN(KHR_ray_tracing_pipeline, RayTracingPipelineFeaturesKHR, RAY_TRACING_PIPELINE_FEATURES_KHR, 5)
    OWN(KHR_ray_tracing_position_fetch, RayTracingPositionFetchFeaturesKHR, RAY_TRACING_POSITION_FETCH_FEATURES_KHR, 1)
    OWN(NV_ray_tracing_linear_swept_spheres, RayTracingLinearSweptSpheresFeaturesNV, RAY_TRACING_LINEAR_SWEPT_SPHERES_FEATURES_NV, 2)
    OWN(NV_ray_tracing_motion_blur, RayTracingMotionBlurFeaturesNV, RAY_TRACING_MOTION_BLUR_FEATURES_NV, 2)
#ifdef VK_NV_displacement_micromap
    OWN(NV_displacement_micromap, DisplacementMicromapFeaturesNV, DISPLACEMENT_MICROMAP_FEATURES_NV, 1)
#endif
#ifdef VK_AMDX_dense_geometry_format
    OWN(AMDX_dense_geometry_format, DenseGeometryFormatFeaturesAMDX, DENSE_GEOMETRY_FORMAT_FEATURES_AMDX, 1)
#endif
};
/* clang-format on */

/* NULL where the structure is in no row. Of several rows, one that is known. */
static const struct feature_row *find(const struct null_driver_config *config,
                                      VkStructureType sType)
{
    const struct feature_row *found = NULL;
    for (size_t i = 0; i < COUNT_OF(rows); i++) {
        if (rows[i].sType == sType && (found == NULL || guard_is_known(config, rows[i].guard)))
            found = &rows[i];
    }
    return found;
}

static void go_home(const struct null_driver_config *config, VkStructureType *sType,
                    uint32_t *offset)
{
    const struct feature_row *row = find(config, *sType);
    if (row != NULL && row->home != *sType) {
        *offset = *offset - (uint32_t)FIRST_MEMBER + row->home_offset;
        *sType = row->home;
    }
}

bool feature_is_on(const struct null_driver_config *config, VkStructureType sType, uint32_t offset)
{
    bool on = true;
    go_home(config, &sType, &offset);
    for (uint32_t i = 0; i < config->feature_count; i++) {
        VkStructureType other = config->features[i].sType;
        uint32_t other_offset = config->features[i].offset;
        go_home(config, &other, &other_offset);
        if (other == sType && other_offset == offset)
            on = config->features[i].value;
    }
    return on;
}

void features_fill(const struct null_driver_config *config, VkPhysicalDeviceFeatures2 *features)
{
    for (VkBaseOutStructure *out = (void *)features; out != NULL; out = out->pNext) {
        const struct feature_row *row = find(config, out->sType);
        if (row == NULL || !guard_is_known(config, row->guard))
            continue;
        for (uint32_t at = FIRST_MEMBER; at < row->end; at += sizeof(VkBool32))
            *(VkBool32 *)((char *)out + at) = feature_is_on(config, out->sType, at);
    }
}

static bool members_are_on(const struct null_driver_config *config, const struct feature_row *row,
                           const void *structure)
{
    const bool known = guard_is_known(config, row->guard);
    for (uint32_t at = FIRST_MEMBER; at < row->end; at += sizeof(VkBool32)) {
        // NOLINTNEXTLINE(clang-analyzer-core.*)
        const VkBool32 asked = *(const VkBool32 *)((const char *)structure + at);
        if (asked && !(known && feature_is_on(config, row->sType, at)))
            return false;
    }
    return true;
}

bool features_are_on(const struct null_driver_config *config, const void *pNext,
                     const VkPhysicalDeviceFeatures *pEnabledFeatures)
{
    const VkPhysicalDeviceFeatures2 core = {
        .sType = STYPE(FEATURES_2),
        .pNext = (void *)pNext,
        .features = pEnabledFeatures != NULL ? *pEnabledFeatures : (VkPhysicalDeviceFeatures){0},
    };
    for (const VkBaseInStructure *in = (const void *)&core; in != NULL; in = in->pNext) {
        const struct feature_row *row = find(config, in->sType);
        if (row != NULL && !members_are_on(config, row, in))
            return false;
    }
    return true;
}
