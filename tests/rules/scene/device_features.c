/* SPDX-License-Identifier: Apache-2.0 */
/* Asking for extensions and features. */
#include "tests/rules/scene/device_features.h"
#include "tests/fixture/make.h"

#include <stdlib.h>
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

static void add_extension(struct features *features, const char *name)
{
    for (uint32_t i = 0; i < features->extension_count; i++)
        if (strcmp(features->extensions[i], name) == 0)
            return;
    if (features->extension_count == FEATURES_EXTENSIONS)
        abort();
    features->extensions[features->extension_count++] = name;
}

/* What extensions depend on, and backend cpu does without. */
static bool is_needed(const struct fixture *fixture, const char *extension)
{
    return !fixture->platform->is_cpu ||
           (strcmp(extension, VK_KHR_RAY_TRACING_PIPELINE_EXTENSION_NAME) != 0 &&
            strcmp(extension, VK_KHR_DEVICE_ADDRESS_COMMANDS_EXTENSION_NAME) != 0);
}

static void list_extensions(struct features *features, const struct fixture *fixture)
{
    const struct setup *setup = &fixture->setup;
    features->extension_count = 0;
    add_extension(features, VK_KHR_ACCELERATION_STRUCTURE_EXTENSION_NAME);
    add_extension(features, VK_KHR_DEFERRED_HOST_OPERATIONS_EXTENSION_NAME);
    if (setup->route == ROUTE_EXT) {
        add_extension(features, VK_EXT_BUFFER_DEVICE_ADDRESS_EXTENSION_NAME);
        add_extension(features, VK_KHR_BUFFER_DEVICE_ADDRESS_EXTENSION_NAME);
    }
    for (size_t i = 0;
         setup->route == ROUTE_KHR && i < sizeof(extensions_of_1_1) / sizeof(*extensions_of_1_1);
         i++)
        add_extension(features, extensions_of_1_1[i]);
    for (size_t i = 0; i < sizeof(extensions_of_setup) / sizeof(*extensions_of_setup); i++)
        if ((setup->enable & extensions_of_setup[i].enable) != 0 &&
            is_needed(fixture, extensions_of_setup[i].extension))
            add_extension(features, extensions_of_setup[i].extension);
}

/* A feature of a structure: by which routes it is enabled, by which bits of a setup if any, and
 * unless which. Features of one structure follow one another. */
#define FEATURE(structure, feature, routes_, enable_, disable_)                                    \
    {                                                                                              \
        .type = structure##_sType, .at = offsetof(structure, feature), .size = sizeof(structure),  \
        .routes = (routes_), .enable = (enable_), .disable = (disable_),                           \
    }
#define BY_KHR (1 << ROUTE_KHR)
#define BY_EXT (1 << ROUTE_EXT)
#define BY_CORE (1 << ROUTE_CHAIN | 1 << ROUTE_FEATURES2)
#define BY_ALL (BY_KHR | BY_EXT | BY_CORE)
static const struct feature {
    VkStructureType type;
    size_t at, size;
    uint32_t routes, enable, disable;
} all_features[] = {
    FEATURE(VkPhysicalDeviceBufferDeviceAddressFeatures, bufferDeviceAddress, BY_KHR, 0, 0),
    FEATURE(VkPhysicalDeviceDynamicRenderingFeatures, dynamicRendering, BY_KHR, 0, 0),
    FEATURE(VkPhysicalDeviceBufferDeviceAddressFeaturesEXT, bufferDeviceAddress, BY_EXT, 0, 0),
    FEATURE(VkPhysicalDeviceVulkan12Features, bufferDeviceAddress, BY_CORE, 0, 0),
    FEATURE(VkPhysicalDeviceVulkan12Features, bufferDeviceAddressMultiDevice, BY_CORE, ENABLE_GROUP,
            DISABLE_MULTI_DEVICE_ADDRESS),
    FEATURE(VkPhysicalDeviceVulkan12Features, timelineSemaphore, BY_CORE, 0, 0),
    FEATURE(VkPhysicalDeviceVulkan12Features, hostQueryReset, BY_CORE, 0, 0),
    FEATURE(VkPhysicalDeviceVulkan13Features, dynamicRendering, BY_EXT | BY_CORE, 0, 0),
    FEATURE(VkPhysicalDeviceVulkan13Features, synchronization2, BY_EXT | BY_CORE, 0, 0),
    FEATURE(VkPhysicalDeviceVulkan14Features, indexTypeUint8, BY_EXT | BY_CORE, ENABLE_UINT8_CORE,
            0),
    FEATURE(VkPhysicalDeviceIndexTypeUint8Features, indexTypeUint8, BY_ALL,
            ENABLE_UINT8_KHR | ENABLE_UINT8_EXT, 0),
    FEATURE(VkPhysicalDeviceOpacityMicromapFeaturesEXT, micromap, BY_ALL,
            ENABLE_OPACITY_MICROMAP_EXT | ENABLE_DISPLACEMENT_MICROMAP, DISABLE_MICROMAP_EXT),
    FEATURE(VkPhysicalDeviceOpacityMicromapFeaturesEXT, micromapCaptureReplay, BY_ALL,
            ENABLE_MICROMAP_REPLAY, 0),
    FEATURE(VkPhysicalDeviceOpacityMicromapFeaturesEXT, micromapHostCommands, BY_ALL,
            ENABLE_OPACITY_MICROMAP_EXT | ENABLE_DISPLACEMENT_MICROMAP,
            DISABLE_MICROMAP_HOST_COMMANDS),
    FEATURE(VkPhysicalDeviceOpacityMicromapFeaturesKHR, micromap, BY_ALL,
            ENABLE_OPACITY_MICROMAP_KHR, DISABLE_MICROMAP_KHR),
    FEATURE(VkPhysicalDeviceDeviceAddressCommandsFeaturesKHR, deviceAddressCommands, BY_ALL,
            ENABLE_OPACITY_MICROMAP_KHR, DISABLE_DEVICE_ADDRESS_COMMANDS),
    FEATURE(VkPhysicalDeviceDisplacementMicromapFeaturesNV, displacementMicromap, BY_ALL,
            ENABLE_DISPLACEMENT_MICROMAP, 0),
    FEATURE(VkPhysicalDeviceRayTracingMotionBlurFeaturesNV, rayTracingMotionBlur, BY_ALL,
            ENABLE_MOTION, 0),
    FEATURE(VkPhysicalDeviceRayTracingLinearSweptSpheresFeaturesNV, spheres, BY_ALL, ENABLE_SPHERES,
            DISABLE_SPHERES),
    FEATURE(VkPhysicalDeviceRayTracingLinearSweptSpheresFeaturesNV, linearSweptSpheres, BY_ALL,
            ENABLE_SPHERES, DISABLE_LINEAR_SWEPT_SPHERES),
    FEATURE(VkPhysicalDeviceDenseGeometryFormatFeaturesAMDX, denseGeometryFormat, BY_ALL,
            ENABLE_DENSE, DISABLE_DENSE),
    FEATURE(VkPhysicalDeviceMaintenance5Features, maintenance5, BY_ALL,
            ENABLE_MAINTENANCE5 | ENABLE_DENSE, 0),
    FEATURE(VkPhysicalDeviceMaintenance6Features, maintenance6, BY_ALL, ENABLE_PUSH_DESCRIPTOR, 0),
    FEATURE(VkPhysicalDeviceRayTracingMaintenance1FeaturesKHR, rayTracingMaintenance1, BY_ALL,
            ENABLE_RAY_TRACING_MAINTENANCE_1, 0),
    FEATURE(VkPhysicalDeviceDescriptorBufferFeaturesEXT, descriptorBuffer, BY_ALL,
            ENABLE_DESCRIPTOR_BUFFER, 0),
    FEATURE(VkPhysicalDeviceDescriptorBufferFeaturesEXT, descriptorBufferCaptureReplay, BY_ALL,
            ENABLE_DESCRIPTOR_BUFFER, DISABLE_DESCRIPTOR_CAPTURE),
    FEATURE(VkPhysicalDeviceRobustness2FeaturesEXT, nullDescriptor, BY_ALL, ENABLE_NULL_DESCRIPTOR,
            0),
    FEATURE(VkPhysicalDeviceClusterAccelerationStructureFeaturesNV, clusterAccelerationStructure,
            BY_ALL, ENABLE_CLUSTERS, DISABLE_CLUSTERS),
    FEATURE(VkPhysicalDevicePartitionedAccelerationStructureFeaturesNV,
            partitionedAccelerationStructure, BY_ALL, ENABLE_CLUSTERS, DISABLE_CLUSTERS),
    FEATURE(VkPhysicalDeviceProtectedMemoryFeatures, protectedMemory, BY_ALL, ENABLE_PROTECTED, 0),
    FEATURE(VkPhysicalDeviceAccelerationStructureFeaturesKHR, accelerationStructure, BY_ALL, 0,
            DISABLE_ACCELERATION_STRUCTURE),
    FEATURE(VkPhysicalDeviceAccelerationStructureFeaturesKHR, accelerationStructureCaptureReplay,
            BY_ALL, ENABLE_CAPTURE_REPLAY, 0),
    FEATURE(VkPhysicalDeviceAccelerationStructureFeaturesKHR, accelerationStructureIndirectBuild,
            BY_ALL, 0, DISABLE_INDIRECT_BUILD),
    FEATURE(VkPhysicalDeviceAccelerationStructureFeaturesKHR, accelerationStructureHostCommands,
            BY_ALL, 0, DISABLE_HOST_COMMANDS),
};

/* Prepends a structure to a chain. */
static void chain(const void **head, void *structure, VkStructureType type)
{
    VkBaseOutStructure *base = structure;
    base->sType = type;
    base->pNext = (VkBaseOutStructure *)*head;
    *head = structure;
}

static void chain_features(struct features *features, const struct fixture *fixture,
                           const void **head)
{
    const struct setup *setup = &fixture->setup;
    const uint32_t disable = setup->disable | (fixture->has_indirect ? 0 : DISABLE_INDIRECT_BUILD) |
                             (fixture->has_host ? 0 : DISABLE_HOST_COMMANDS);
    uint32_t count = 0;
    for (size_t i = 0; i < sizeof(all_features) / sizeof(*all_features); i++) {
        const struct feature *feature = &all_features[i];
        if (!(feature->routes & 1u << setup->route) ||
            (feature->enable != 0 && !(feature->enable & setup->enable)))
            continue;
        if (count == 0 || features->structures[count - 1].base.sType != feature->type) {
            if (count == FEATURES_STRUCTURES || feature->size > sizeof(features->structures[0]))
                abort();
            chain(head, &features->structures[count++], feature->type);
        }
        *(VkBool32 *)(void *)(features->structures[count - 1].bytes + feature->at) =
            !(disable & feature->disable);
    }
}

void features_fill(struct features *features, const struct fixture *fixture,
                   VkDeviceCreateInfo *create_info)
{
    const struct setup *setup = &fixture->setup;
    const void **head = &create_info->pNext;

    memset(features, 0, sizeof(*features));
    list_extensions(features, fixture);
    create_info->enabledExtensionCount = features->extension_count;
    create_info->ppEnabledExtensionNames = features->extensions;
    chain_features(features, fixture, head);
    VkPhysicalDeviceFeatures *core = &features->core.features;
    if ((setup->enable & ENABLE_SPARSE) != 0)
        core->sparseBinding = core->sparseResidencyBuffer = core->sparseResidencyAliased = VK_TRUE;
    if (setup->route == ROUTE_FEATURES2)
        chain(head, &features->core, VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2);
    else
        create_info->pEnabledFeatures = core;
}

static bool has_extension(const VkExtensionProperties *offered, uint32_t count, const char *name)
{
    for (uint32_t i = 0; i < count; i++)
        if (strcmp(offered[i].extensionName, name) == 0)
            return true;
    return false;
}

/* Backend cpu and some drivers lack it. */
static bool replays_addresses(const struct fixture *fixture)
{
    const uint32_t enable = fixture->setup.enable;
    STRUCT(VkPhysicalDeviceOpacityMicromapFeaturesEXT, micromaps);
    STRUCT(VkPhysicalDeviceAccelerationStructureFeaturesKHR, features, .pNext = &micromaps);
    STRUCT(VkPhysicalDeviceFeatures2, core, .pNext = &features);
    fixture->vki.GetPhysicalDeviceFeatures2(fixture->physical_device, &core);
    return ((enable & ENABLE_CAPTURE_REPLAY) == 0 || features.accelerationStructureCaptureReplay) &&
           ((enable & ENABLE_MICROMAP_REPLAY) == 0 || micromaps.micromapCaptureReplay);
}

static bool captures_descriptors(const struct fixture *fixture)
{
    STRUCT(VkPhysicalDeviceDescriptorBufferFeaturesEXT, features);
    STRUCT(VkPhysicalDeviceFeatures2, core, .pNext = &features);
    fixture->vki.GetPhysicalDeviceFeatures2(fixture->physical_device, &core);
    return features.descriptorBufferCaptureReplay;
}

static const char *core_missing(const struct fixture *fixture)
{
    STRUCT(VkPhysicalDeviceProtectedMemoryFeatures, protected_memory);
    STRUCT(VkPhysicalDeviceFeatures2, core, .pNext = &protected_memory);
    VkPhysicalDeviceProperties properties;
    const uint32_t enable = fixture->setup.enable;

    fixture->vki.GetPhysicalDeviceFeatures2(fixture->physical_device, &core);
    fixture->vki.GetPhysicalDeviceProperties(fixture->physical_device, &properties);
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
        fixture->vki.EnumeratePhysicalDevices(fixture->instance, &count, NULL);
        if (count < 2)
            return "no group of two physical devices";
    }
    return NULL;
}

const char *features_missing(const struct fixture *fixture)
{
    struct features wanted;
    const char *missing = core_missing(fixture);
    uint32_t count = 0;
    VkExtensionProperties *offered;

    if (missing != NULL)
        return missing;
    list_extensions(&wanted, fixture);
    fixture->vki.EnumerateDeviceExtensionProperties(fixture->physical_device, NULL, &count, NULL);
    offered = calloc(count + 1, sizeof(*offered));
    if (offered == NULL)
        abort();
    fixture->vki.EnumerateDeviceExtensionProperties(fixture->physical_device, NULL, &count,
                                                    offered);
    for (uint32_t i = 0; missing == NULL && i < wanted.extension_count; i++)
        if (!has_extension(offered, count, wanted.extensions[i]))
            missing = wanted.extensions[i];
    free(offered);
    return missing;
}

void features_configure(struct null_driver_config *config, const struct setup *setup)
{
    if ((setup->enable & ENABLE_FUTURE) != 0)
        config->extra_extensions[config->extra_extension_count++] = FUTURE_EXTENSION;
    if (setup->api_version > config->api_version)
        config->api_version = setup->api_version;
}
