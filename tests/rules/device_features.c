/* SPDX-License-Identifier: Apache-2.0 */
/* Asking for extensions and features. */
#include "device_features.h"
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
    {ENABLE_OPACITY_MICROMAP_EXT, VK_EXT_OPACITY_MICROMAP_EXTENSION_NAME},
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
    {ENABLE_SYNCHRONIZATION_2, VK_KHR_SYNCHRONIZATION_2_EXTENSION_NAME},
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

/* Prepends a structure to a chain. */
static void chain(const void **head, void *structure, VkStructureType type)
{
    VkBaseOutStructure *base = structure;
    base->sType = type;
    base->pNext = (VkBaseOutStructure *)*head;
    *head = structure;
}

static void chain_core(struct features *features, const struct setup *setup, const void **head)
{
    if (setup->route == ROUTE_KHR) {
        chain(head, &features->address_khr,
              VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_BUFFER_DEVICE_ADDRESS_FEATURES);
        features->address_khr.bufferDeviceAddress = VK_TRUE;
        chain(head, &features->dynamic_rendering,
              VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DYNAMIC_RENDERING_FEATURES);
        features->dynamic_rendering.dynamicRendering = VK_TRUE;
        return;
    }
    if (setup->route == ROUTE_EXT) {
        chain(head, &features->address_ext,
              VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_BUFFER_DEVICE_ADDRESS_FEATURES_EXT);
        features->address_ext.bufferDeviceAddress = VK_TRUE;
    } else {
        chain(head, &features->vulkan12, VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES);
        features->vulkan12.bufferDeviceAddress = VK_TRUE;
        features->vulkan12.timelineSemaphore = VK_TRUE;
        features->vulkan12.hostQueryReset = VK_TRUE;
    }
    chain(head, &features->vulkan13, VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_FEATURES);
    features->vulkan13.dynamicRendering = VK_TRUE;
    features->vulkan13.synchronization2 = VK_TRUE;
    if ((setup->enable & ENABLE_UINT8_CORE) != 0) {
        chain(head, &features->vulkan14, VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_4_FEATURES);
        features->vulkan14.indexTypeUint8 = VK_TRUE;
    }
}

/* Features of extensions: of which bits of a setup, where in struct features, and unless what. */
#define FEATURE(enable_, structure, feature, type_, disable_)                                      \
    {                                                                                              \
        .enable = (enable_), .disable = (disable_), .at = offsetof(struct features, structure),    \
        .feature_at = offsetof(struct features, structure.feature),                                \
        .type = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_##type_,                                         \
    }
static const struct {
    uint32_t enable, disable;
    size_t at, feature_at;
    VkStructureType type;
} features_of_setup[] = {
    FEATURE(ENABLE_UINT8_KHR | ENABLE_UINT8_EXT, uint8, indexTypeUint8, INDEX_TYPE_UINT8_FEATURES,
            0),
    FEATURE(ENABLE_OPACITY_MICROMAP_EXT | ENABLE_DISPLACEMENT_MICROMAP, micromap_ext, micromap,
            OPACITY_MICROMAP_FEATURES_EXT, DISABLE_MICROMAP_EXT),
    FEATURE(ENABLE_OPACITY_MICROMAP_KHR, micromap_khr, micromap, OPACITY_MICROMAP_FEATURES_KHR,
            DISABLE_MICROMAP_KHR),
    FEATURE(ENABLE_DISPLACEMENT_MICROMAP, displacement, displacementMicromap,
            DISPLACEMENT_MICROMAP_FEATURES_NV, 0),
    FEATURE(ENABLE_MOTION, motion, rayTracingMotionBlur, RAY_TRACING_MOTION_BLUR_FEATURES_NV, 0),
    FEATURE(ENABLE_SPHERES, spheres, spheres, RAY_TRACING_LINEAR_SWEPT_SPHERES_FEATURES_NV,
            DISABLE_SPHERES),
    FEATURE(ENABLE_DENSE, dense, denseGeometryFormat, DENSE_GEOMETRY_FORMAT_FEATURES_AMDX,
            DISABLE_DENSE),
    FEATURE(ENABLE_MAINTENANCE5 | ENABLE_DENSE, maintenance5, maintenance5, MAINTENANCE_5_FEATURES,
            0),
    FEATURE(ENABLE_PROTECTED, protected_memory, protectedMemory, PROTECTED_MEMORY_FEATURES, 0),
};

static void chain_of_setup(struct features *features, const struct setup *setup, const void **head)
{
    unsigned char *bytes = (unsigned char *)features;
    for (size_t i = 0; i < sizeof(features_of_setup) / sizeof(*features_of_setup); i++) {
        if ((setup->enable & features_of_setup[i].enable) == 0)
            continue;
        chain(head, bytes + features_of_setup[i].at, features_of_setup[i].type);
        *(VkBool32 *)(void *)(bytes + features_of_setup[i].feature_at) =
            (setup->disable & features_of_setup[i].disable) == 0;
    }
    features->spheres.linearSweptSpheres = (setup->disable & DISABLE_LINEAR_SWEPT_SPHERES) == 0;
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

    chain_core(features, setup, head);
    chain_of_setup(features, setup, head);
    VkPhysicalDeviceAccelerationStructureFeaturesKHR *as = &features->acceleration_structure;
    chain(head, as, VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_ACCELERATION_STRUCTURE_FEATURES_KHR);
    as->accelerationStructure = (setup->disable & DISABLE_ACCELERATION_STRUCTURE) == 0;
    as->accelerationStructureIndirectBuild =
        fixture->has_indirect && (setup->disable & DISABLE_INDIRECT_BUILD) == 0;
    as->accelerationStructureHostCommands =
        fixture->has_host && (setup->disable & DISABLE_HOST_COMMANDS) == 0;

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
