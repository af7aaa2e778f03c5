/* SPDX-License-Identifier: Apache-2.0 */
/* What a physical device answers: features, properties, formats, queue families and extensions. */
#include "tests/null_driver/internal.h"

/* ---- features: all on save for what the configuration says */

#define FIRST_MEMBER ((uint32_t)sizeof(VkBaseOutStructure))

/* NULL where the structure is in no row. Of several rows, one that is known. */
static const struct feature_row *find_feature_row(const struct null_driver_config *config,
                                                  VkStructureType sType)
{
    const struct feature_row *found = NULL;
    for (size_t i = 0; i < feature_row_count; i++) {
        if (feature_rows[i].sType == sType &&
            (found == NULL || guard_is_known(config, feature_rows[i].guard)))
            found = &feature_rows[i];
    }
    return found;
}

static void go_home(const struct null_driver_config *config, VkStructureType *sType,
                    uint32_t *offset)
{
    const struct feature_row *row = find_feature_row(config, *sType);
    if (row != NULL && row->home != *sType) {
        *offset = *offset - FIRST_MEMBER + row->home_offset;
        *sType = row->home;
    }
}

static bool feature_is_on(const struct null_driver_config *config, VkStructureType sType,
                          uint32_t offset)
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

COMMAND(GetPhysicalDeviceFeatures2)
{
    const struct null_driver_config *config = CONFIG(physicalDevice);
    for (VkBaseOutStructure *out = (void *)pFeatures; out != NULL; out = out->pNext) {
        const struct feature_row *row = find_feature_row(config, out->sType);
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
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2,
        .pNext = (void *)pNext,
        .features = pEnabledFeatures != NULL ? *pEnabledFeatures : (VkPhysicalDeviceFeatures){0},
    };
    for (const VkBaseInStructure *in = (const void *)&core; in != NULL; in = in->pNext) {
        const struct feature_row *row = find_feature_row(config, in->sType);
        if (row != NULL && !members_are_on(config, row, in))
            return false;
    }
    return true;
}

/* ---- properties: those that a test may set come from the configuration, the others are fixed */

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

static void fill_properties(const struct null_driver_config *config, const struct property_row *row,
                            VkBaseOutStructure *out)
{
    memcpy(out + 1, row->fixed != NULL ? row->fixed : (const char *)config + row->offset,
           row->size);
}

COMMAND(GetPhysicalDeviceProperties2)
{
    const struct null_driver_config *config = CONFIG(physicalDevice);
    pProperties->properties = config->properties;
    pProperties->properties.apiVersion = config->api_version;
    for (VkBaseOutStructure *out = pProperties->pNext; out != NULL; out = out->pNext) {
        for (size_t i = 0; i < COUNT_OF(rows); i++) {
            if (rows[i].sType == out->sType && guard_is_known(config, rows[i].guard))
                fill_properties(config, &rows[i], out);
        }
        /* Devices of a group differ in nothing else. Both begin with the device's UUID. */
        if (out->sType == VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_ID_PROPERTIES ||
            out->sType == VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_1_PROPERTIES)
            *(uint8_t *)(out + 1) = (uint8_t)(OBJECT(physicalDevice)->physical_device.index + 1);
    }
}

/* ---- formats: buffer features as configured, and images of every format there is */

static bool is_format(VkFormat format)
{
    return format > VK_FORMAT_UNDEFINED && format <= VK_FORMAT_ASTC_12x12_SRGB_BLOCK;
}

static VkFormatFeatureFlags2 image_features(VkFormat format)
{
    if (!is_format(format))
        return 0;
    const VkFormatFeatureFlags2 all = VK_FORMAT_FEATURE_2_SAMPLED_IMAGE_BIT |
                                      VK_FORMAT_FEATURE_2_TRANSFER_SRC_BIT |
                                      VK_FORMAT_FEATURE_2_TRANSFER_DST_BIT;
    if (format >= VK_FORMAT_D16_UNORM && format <= VK_FORMAT_D32_SFLOAT_S8_UINT)
        return all | VK_FORMAT_FEATURE_2_DEPTH_STENCIL_ATTACHMENT_BIT;
    return all | VK_FORMAT_FEATURE_2_COLOR_ATTACHMENT_BIT | VK_FORMAT_FEATURE_2_STORAGE_IMAGE_BIT;
}

static VkFormatProperties3 format_properties(const struct null_driver_config *config,
                                             VkFormat format)
{
    VkFormatProperties3 properties = {.linearTilingFeatures = image_features(format),
                                      .optimalTilingFeatures = image_features(format)};
    for (uint32_t i = 0; i < config->format_count; i++) {
        if (config->formats[i].format == format)
            properties.bufferFeatures =
                config->formats[i].buffer_features | VK_FORMAT_FEATURE_2_VERTEX_BUFFER_BIT;
    }
    return properties;
}

/* The older structure holds the flags that fit it. */
static VkFormatFeatureFlags fitting(VkFormatFeatureFlags2 features)
{
    return (VkFormatFeatureFlags)(features & 0x7fffffff);
}

COMMAND(GetPhysicalDeviceFormatProperties2)
{
    const VkFormatProperties3 properties = format_properties(CONFIG(physicalDevice), format);
    pFormatProperties->formatProperties = (VkFormatProperties){
        fitting(properties.linearTilingFeatures), fitting(properties.optimalTilingFeatures),
        fitting(properties.bufferFeatures)};
    for (VkBaseOutStructure *out = pFormatProperties->pNext; out != NULL; out = out->pNext) {
        if (out->sType == VK_STRUCTURE_TYPE_FORMAT_PROPERTIES_3) {
            VkFormatProperties3 *to = (VkFormatProperties3 *)out;
            to->linearTilingFeatures = properties.linearTilingFeatures;
            to->optimalTilingFeatures = properties.optimalTilingFeatures;
            to->bufferFeatures = properties.bufferFeatures;
        }
    }
}

COMMAND(GetPhysicalDeviceImageFormatProperties2)
{
    const struct null_driver_config *config = CONFIG(physicalDevice);
    VkImageFormatProperties *properties = &pImageFormatProperties->imageFormatProperties;
    const uint32_t side = config->properties.limits.maxImageDimension2D;
    *properties = (VkImageFormatProperties){0};
    if (!is_format(pImageFormatInfo->format))
        return VK_ERROR_FORMAT_NOT_SUPPORTED;
    *properties = (VkImageFormatProperties){
        .maxExtent = {side, side, side},
        .maxMipLevels = 15,
        .maxArrayLayers = config->properties.limits.maxImageArrayLayers,
        .sampleCounts = config->properties.limits.framebufferColorSampleCounts,
        .maxResourceSize = (VkDeviceSize)1 << 38,
    };
    return VK_SUCCESS;
}

/* ---- queue families and extensions */

COMMAND(GetPhysicalDeviceQueueFamilyProperties)
{
    const struct null_driver_config *config = CONFIG(physicalDevice);
    enumerate(pQueueFamilyPropertyCount, pQueueFamilyProperties, config->queue_families,
              config->queue_family_count, sizeof(config->queue_families[0]));
}

COMMAND(GetPhysicalDeviceQueueFamilyProperties2)
{
    const struct null_driver_config *config = CONFIG(physicalDevice);
    if (pQueueFamilyProperties == NULL || *pQueueFamilyPropertyCount > config->queue_family_count)
        *pQueueFamilyPropertyCount = config->queue_family_count;
    if (pQueueFamilyProperties == NULL)
        return;
    for (uint32_t i = 0; i < *pQueueFamilyPropertyCount; i++)
        pQueueFamilyProperties[i].queueFamilyProperties = config->queue_families[i];
}

static void add_extension(VkExtensionProperties *extensions, uint32_t *count, const char *name)
{
    VkExtensionProperties *extension = &extensions[(*count)++];
    *extension = (VkExtensionProperties){.specVersion = 1};
    strncpy(extension->extensionName, name, sizeof(extension->extensionName) - 1);
}

/* Returns how many there are. */
static uint32_t
list_extensions(const struct null_driver_config *config,
                VkExtensionProperties extensions[EXTENSION_COUNT + NULL_DRIVER_MAX_EXTENSIONS])
{
    uint32_t count = 0;
    for (enum guard guard = FIRST_EXTENSION; guard < GUARD_COUNT; guard++) {
        if (guard_is_offered(config, guard))
            add_extension(extensions, &count, guard_extension_name(guard));
    }
    for (uint32_t i = 0; i < config->extra_extension_count; i++)
        add_extension(extensions, &count, config->extra_extensions[i]);
    return count;
}

COMMAND(EnumerateDeviceExtensionProperties)
{
    VkExtensionProperties extensions[EXTENSION_COUNT + NULL_DRIVER_MAX_EXTENSIONS];
    const uint32_t count = list_extensions(CONFIG(physicalDevice), extensions);
    return enumerate(pPropertyCount, pProperties, extensions, count, sizeof(extensions[0]));
}
