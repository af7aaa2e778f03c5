/* SPDX-License-Identifier: Apache-2.0 */
/* Asking for extensions and features. */
#include "tests/rules/scene/device_features.h"
#include "tests/fixture/make.h"

#include <string.h>

#define FUTURE_EXTENSION "VK_TEST_not_yet_invented"

/* The extensions that a bit of enum setup_enable stands for. */
static const struct {
    uint32_t enable;
    const char *extension;
} extensions_of_setup[] = {
    {ENABLE_UINT8_KHR, VK_KHR_INDEX_TYPE_UINT8_EXTENSION_NAME},
    {ENABLE_UINT8_EXT, VK_EXT_INDEX_TYPE_UINT8_EXTENSION_NAME},
    {ENABLE_OPACITY_MICROMAP_EXT | ENABLE_MICROMAP_REPLAY, VK_EXT_OPACITY_MICROMAP_EXTENSION_NAME},
    {ENABLE_OPACITY_MICROMAP_KHR, VK_KHR_OPACITY_MICROMAP_EXTENSION_NAME},
    {ENABLE_OPACITY_MICROMAP_KHR, VK_KHR_DEVICE_ADDRESS_COMMANDS_EXTENSION_NAME},
    {ENABLE_DISPLACEMENT_MICROMAP, VK_NV_DISPLACEMENT_MICROMAP_EXTENSION_NAME},
    {ENABLE_DISPLACEMENT_MICROMAP, VK_EXT_OPACITY_MICROMAP_EXTENSION_NAME},
    {ENABLE_MOTION, VK_NV_RAY_TRACING_MOTION_BLUR_EXTENSION_NAME},
    {ENABLE_MOTION, VK_KHR_RAY_TRACING_PIPELINE_EXTENSION_NAME},
    {ENABLE_SPHERES, VK_NV_RAY_TRACING_LINEAR_SWEPT_SPHERES_EXTENSION_NAME},
    {ENABLE_SPHERES, VK_KHR_RAY_TRACING_PIPELINE_EXTENSION_NAME},
    {ENABLE_VIDEO, VK_KHR_VIDEO_QUEUE_EXTENSION_NAME},
    {ENABLE_VIDEO, VK_KHR_VIDEO_DECODE_QUEUE_EXTENSION_NAME},
    {ENABLE_VIDEO, VK_KHR_VIDEO_DECODE_H264_EXTENSION_NAME},
    {ENABLE_MAINTENANCE5 | ENABLE_DENSE, VK_KHR_MAINTENANCE_5_EXTENSION_NAME},
    {ENABLE_DENSE, VK_AMDX_DENSE_GEOMETRY_FORMAT_EXTENSION_NAME},
    {ENABLE_FUTURE, FUTURE_EXTENSION},
    {ENABLE_RAY_TRACING_NV, VK_NV_RAY_TRACING_EXTENSION_NAME},
    {ENABLE_PUSH_DESCRIPTOR, VK_KHR_PUSH_DESCRIPTOR_EXTENSION_NAME},
    {ENABLE_PUSH_DESCRIPTOR, VK_KHR_MAINTENANCE_6_EXTENSION_NAME},
    {ENABLE_RAY_TRACING_MAINTENANCE_1, VK_KHR_RAY_TRACING_MAINTENANCE_1_EXTENSION_NAME},
    {ENABLE_DESCRIPTOR_BUFFER, VK_EXT_DESCRIPTOR_BUFFER_EXTENSION_NAME},
    {ENABLE_NULL_DESCRIPTOR, VK_EXT_ROBUSTNESS_2_EXTENSION_NAME},
    {ENABLE_SYNCHRONIZATION_2, VK_KHR_SYNCHRONIZATION_2_EXTENSION_NAME},
    {ENABLE_CLUSTERS, VK_NV_CLUSTER_ACCELERATION_STRUCTURE_EXTENSION_NAME},
    {ENABLE_CLUSTERS, VK_NV_PARTITIONED_ACCELERATION_STRUCTURE_EXTENSION_NAME},
};

static const char *const extensions_of_1_1[] = {
    VK_KHR_BUFFER_DEVICE_ADDRESS_EXTENSION_NAME, VK_EXT_DESCRIPTOR_INDEXING_EXTENSION_NAME,
    VK_KHR_CREATE_RENDERPASS_2_EXTENSION_NAME,   VK_KHR_DEPTH_STENCIL_RESOLVE_EXTENSION_NAME,
    VK_KHR_DYNAMIC_RENDERING_EXTENSION_NAME,     VK_KHR_SPIRV_1_4_EXTENSION_NAME,
    VK_KHR_SHADER_FLOAT_CONTROLS_EXTENSION_NAME,
};

/* What extensions depend on, and backend cpu does without. */
static bool is_needed(const struct fixture *fixture, const char *extension)
{
    return !fixture->instance.platform->is_cpu ||
           (strcmp(extension, VK_KHR_RAY_TRACING_PIPELINE_EXTENSION_NAME) != 0 &&
            strcmp(extension, VK_KHR_DEVICE_ADDRESS_COMMANDS_EXTENSION_NAME) != 0);
}

static void list_extensions(struct device_wish *wish, const struct fixture *fixture)
{
    const struct setup *setup = &fixture->setup;
    device_wish_begin(wish);
    if (setup->route == ROUTE_EXT) {
        device_wish_add(wish, VK_EXT_BUFFER_DEVICE_ADDRESS_EXTENSION_NAME);
        device_wish_add(wish, VK_KHR_BUFFER_DEVICE_ADDRESS_EXTENSION_NAME);
    }
    for (size_t i = 0; setup->route == ROUTE_KHR && i < ARRAY_COUNT(extensions_of_1_1); i++)
        device_wish_add(wish, extensions_of_1_1[i]);
    for (size_t i = 0; i < ARRAY_COUNT(extensions_of_setup); i++)
        if ((setup->enable & extensions_of_setup[i].enable) != 0 &&
            is_needed(fixture, extensions_of_setup[i].extension))
            device_wish_add(wish, extensions_of_setup[i].extension);
}

struct feature {
    VkStructureType type;
    size_t at;
    uint32_t routes, enable, disable;
};
#define FEATURE(structure, feature) .type = structure##_sType, .at = offsetof(structure, feature)

/* Other features: by which routes they are enabled, and by which bits of a setup, if any.
 */
#define BY_KHR (1 << ROUTE_KHR)
#define BY_EXT (1 << ROUTE_EXT)
#define BY_CORE (1 << ROUTE_CHAIN | 1 << ROUTE_FEATURES2)
#define BY_ALL (BY_KHR | BY_EXT | BY_CORE)
static const struct feature core_features[] = {
    {FEATURE(VkPhysicalDeviceBufferDeviceAddressFeatures, bufferDeviceAddress), BY_KHR},
    {FEATURE(VkPhysicalDeviceDynamicRenderingFeatures, dynamicRendering), BY_KHR},
    {FEATURE(VkPhysicalDeviceBufferDeviceAddressFeaturesEXT, bufferDeviceAddress), BY_EXT},
    {FEATURE(VkPhysicalDeviceVulkan12Features, bufferDeviceAddress), BY_CORE},
    {FEATURE(VkPhysicalDeviceVulkan12Features, bufferDeviceAddressMultiDevice), BY_CORE,
     .enable = ENABLE_GROUP},
    {FEATURE(VkPhysicalDeviceVulkan12Features, timelineSemaphore), BY_CORE},
    {FEATURE(VkPhysicalDeviceVulkan12Features, hostQueryReset), BY_CORE},
    {FEATURE(VkPhysicalDeviceVulkan13Features, dynamicRendering), BY_EXT | BY_CORE},
    {FEATURE(VkPhysicalDeviceVulkan13Features, synchronization2), BY_EXT | BY_CORE},
    {FEATURE(VkPhysicalDeviceVulkan14Features, indexTypeUint8), BY_EXT | BY_CORE,
     .enable = ENABLE_UINT8_CORE},
    {FEATURE(VkPhysicalDeviceProtectedMemoryFeatures, protectedMemory), BY_ALL,
     .enable = ENABLE_PROTECTED},
    /* Backend cpu has it without the extension. */
    {FEATURE(VkPhysicalDeviceDeviceAddressCommandsFeaturesKHR, deviceAddressCommands), BY_ALL,
     .enable = ENABLE_OPACITY_MICROMAP_KHR},
};

/* Features that a bit of a setup leaves off; and others, unless a bit enables them. */
static const struct feature features_left_off[] = {
    {FEATURE(VkPhysicalDeviceVulkan12Features, bufferDeviceAddressMultiDevice),
     .disable = DISABLE_MULTI_DEVICE_ADDRESS},
    {FEATURE(VkPhysicalDeviceOpacityMicromapFeaturesEXT, micromap),
     .disable = DISABLE_MICROMAP_EXT},
    {FEATURE(VkPhysicalDeviceOpacityMicromapFeaturesEXT, micromapHostCommands),
     .disable = DISABLE_MICROMAP_HOST_COMMANDS},
    {FEATURE(VkPhysicalDeviceOpacityMicromapFeaturesEXT, micromapCaptureReplay),
     .enable = ENABLE_MICROMAP_REPLAY},
    {FEATURE(VkPhysicalDeviceOpacityMicromapFeaturesKHR, micromap),
     .disable = DISABLE_MICROMAP_KHR},
    {FEATURE(VkPhysicalDeviceDeviceAddressCommandsFeaturesKHR, deviceAddressCommands),
     .disable = DISABLE_DEVICE_ADDRESS_COMMANDS},
    {FEATURE(VkPhysicalDeviceRayTracingLinearSweptSpheresFeaturesNV, spheres),
     .disable = DISABLE_SPHERES},
    {FEATURE(VkPhysicalDeviceRayTracingLinearSweptSpheresFeaturesNV, linearSweptSpheres),
     .disable = DISABLE_LINEAR_SWEPT_SPHERES},
    {FEATURE(VkPhysicalDeviceDenseGeometryFormatFeaturesAMDX, denseGeometryFormat),
     .disable = DISABLE_DENSE},
    {FEATURE(VkPhysicalDeviceDescriptorBufferFeaturesEXT, descriptorBufferCaptureReplay),
     .disable = DISABLE_DESCRIPTOR_CAPTURE},
    {FEATURE(VkPhysicalDeviceRobustness2FeaturesEXT, robustBufferAccess2)},
    {FEATURE(VkPhysicalDeviceClusterAccelerationStructureFeaturesNV, clusterAccelerationStructure),
     .disable = DISABLE_CLUSTERS},
    {FEATURE(VkPhysicalDevicePartitionedAccelerationStructureFeaturesNV,
             partitionedAccelerationStructure),
     .disable = DISABLE_CLUSTERS},
    {FEATURE(VkPhysicalDeviceAccelerationStructureFeaturesKHR, accelerationStructure),
     .disable = DISABLE_ACCELERATION_STRUCTURE},
    {FEATURE(VkPhysicalDeviceAccelerationStructureFeaturesKHR, accelerationStructureCaptureReplay),
     .enable = ENABLE_CAPTURE_REPLAY},
    {FEATURE(VkPhysicalDeviceAccelerationStructureFeaturesKHR, accelerationStructureIndirectBuild),
     .disable = DISABLE_INDIRECT_BUILD},
    {FEATURE(VkPhysicalDeviceAccelerationStructureFeaturesKHR, accelerationStructureHostCommands),
     .disable = DISABLE_HOST_COMMANDS},
};

static void set(void *structure, const struct feature *feature, VkBool32 value)
{
    if (structure)
        memcpy((char *)structure + feature->at, &value, sizeof(value));
}

void features_wish(struct device_wish *wish, const struct fixture *fixture)
{
    const struct setup *setup = &fixture->setup;
    list_extensions(wish, fixture);
    fixture->instance.vk.GetPhysicalDeviceFeatures2(fixture->instance.physical, &wish->features);
    wish->features.features =
        (VkPhysicalDeviceFeatures){.sparseBinding = (setup->enable & ENABLE_SPARSE) != 0,
                                   .sparseResidencyBuffer = (setup->enable & ENABLE_SPARSE) != 0,
                                   .sparseResidencyAliased = (setup->enable & ENABLE_SPARSE) != 0};
    for (size_t i = 0; i < ARRAY_COUNT(core_features); i++) {
        const struct feature *feature = &core_features[i];
        if (feature->routes & 1u << setup->route &&
            (feature->enable == 0 || feature->enable & setup->enable))
            set(device_wish_features(wish, feature->type), feature, VK_TRUE);
    }
    for (size_t i = 0; i < ARRAY_COUNT(features_left_off); i++) {
        const struct feature *feature = &features_left_off[i];
        if (feature->disable ? feature->disable & setup->disable
                             : !(feature->enable & setup->enable))
            set(device_wish_find(wish, feature->type), feature, VK_FALSE);
    }
}

/* Backend cpu and some drivers lack it. */
static bool replays_addresses(const struct fixture *fixture)
{
    const uint32_t enable = fixture->setup.enable;
    STRUCT(VkPhysicalDeviceOpacityMicromapFeaturesEXT, micromaps);
    STRUCT(VkPhysicalDeviceAccelerationStructureFeaturesKHR, features, .pNext = &micromaps);
    STRUCT(VkPhysicalDeviceFeatures2, core, .pNext = &features);
    fixture->instance.vk.GetPhysicalDeviceFeatures2(fixture->instance.physical, &core);
    return ((enable & ENABLE_CAPTURE_REPLAY) == 0 || features.accelerationStructureCaptureReplay) &&
           ((enable & ENABLE_MICROMAP_REPLAY) == 0 || micromaps.micromapCaptureReplay);
}

static bool captures_descriptors(const struct fixture *fixture)
{
    STRUCT(VkPhysicalDeviceDescriptorBufferFeaturesEXT, features);
    STRUCT(VkPhysicalDeviceFeatures2, core, .pNext = &features);
    fixture->instance.vk.GetPhysicalDeviceFeatures2(fixture->instance.physical, &core);
    return features.descriptorBufferCaptureReplay;
}

static const char *core_missing(const struct fixture *fixture)
{
    STRUCT(VkPhysicalDeviceProtectedMemoryFeatures, protected_memory);
    STRUCT(VkPhysicalDeviceFeatures2, core, .pNext = &protected_memory);
    VkPhysicalDeviceProperties properties;
    const uint32_t enable = fixture->setup.enable;

    fixture->instance.vk.GetPhysicalDeviceFeatures2(fixture->instance.physical, &core);
    fixture->instance.vk.GetPhysicalDeviceProperties(fixture->instance.physical, &properties);
    if ((enable & ENABLE_PROTECTED) != 0 && !protected_memory.protectedMemory)
        return "no protected memory";
    if ((enable & ENABLE_DESCRIPTOR_BUFFER) != 0 && !captures_descriptors(fixture))
        return "no capture and replay of descriptors";
    if (!replays_addresses(fixture))
        return "no capture and replay";
    if ((enable & ENABLE_SPARSE) != 0 && !core.features.sparseResidencyAliased)
        return "no sparse buffers that alias";
    if ((enable & ENABLE_UINT8_CORE) != 0 && properties.apiVersion < VK_API_VERSION_1_4)
        return "no Vulkan 1.4";
    if ((enable & ENABLE_GROUP) != 0) {
        uint32_t count = 0;
        fixture->instance.vk.EnumeratePhysicalDevices(fixture->instance.instance, &count, NULL);
        if (count < 2)
            return "no group of two physical devices";
    }
    return NULL;
}

const char *features_missing(const struct fixture *fixture)
{
    struct device_wish wanted;
    const char *missing = core_missing(fixture);
    list_extensions(&wanted, fixture);
    for (uint32_t i = 0; missing == NULL && i < wanted.extension_count; i++)
        if (instance_fixture_count_extension(&fixture->instance, wanted.extensions[i]) == 0)
            missing = wanted.extensions[i];
    return missing;
}

void features_configure(struct null_driver_config *config, const struct setup *setup)
{
    if ((setup->enable & ENABLE_FUTURE) != 0)
        config->extra_extensions[config->extra_extension_count++] = FUTURE_EXTENSION;
    if (setup->api_version > config->api_version)
        config->api_version = setup->api_version;
}
