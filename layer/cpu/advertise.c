/* SPDX-License-Identifier: Apache-2.0 */
/* Extensions, features, limits and formats of a physical device: the driver's, with its ray tracing
 * replaced by the backend's. */
#include "layer/cpu/overlay.h"

#include <stdlib.h>
#include <string.h>

#include "layer/physical_device.h"
#include "observers.h"
#include "src/bvh/input/displacement.h"
#include "src/bvh/input/formats.h"
#include "src/bvh/micromap.h"
#include "vuid-tables/registry.h"

bool cpu_advertises(struct layer_instance *instance, VkPhysicalDevice physical_device)
{
    VkPhysicalDeviceProperties properties;
    PFN_vkGetPhysicalDeviceFeatures2 get_features =
        physical_device_features2(instance, &instance->down, physical_device);
    instance->down.GetPhysicalDeviceProperties(physical_device, &properties);
    if (properties.apiVersion < VK_API_VERSION_1_1 || !get_features)
        return false;
    VkPhysicalDeviceBufferDeviceAddressFeatures addresses = {
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_BUFFER_DEVICE_ADDRESS_FEATURES};
    VkPhysicalDeviceFeatures2 features = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2,
                                          .pNext = &addresses};
    get_features(physical_device, &features);
    return addresses.bufferDeviceAddress;
}

/* ---- extensions */

static const VkExtensionProperties advertised[] = {
    {VK_KHR_ACCELERATION_STRUCTURE_EXTENSION_NAME, VK_KHR_ACCELERATION_STRUCTURE_SPEC_VERSION},
    {VK_KHR_DEFERRED_HOST_OPERATIONS_EXTENSION_NAME, VK_KHR_DEFERRED_HOST_OPERATIONS_SPEC_VERSION},
    {VK_NV_RAY_TRACING_EXTENSION_NAME, VK_NV_RAY_TRACING_SPEC_VERSION},
    {VK_NV_RAY_TRACING_MOTION_BLUR_EXTENSION_NAME, VK_NV_RAY_TRACING_MOTION_BLUR_SPEC_VERSION},
    {VK_NV_RAY_TRACING_LINEAR_SWEPT_SPHERES_EXTENSION_NAME,
     VK_NV_RAY_TRACING_LINEAR_SWEPT_SPHERES_SPEC_VERSION},
    {VK_AMDX_DENSE_GEOMETRY_FORMAT_EXTENSION_NAME, VK_AMDX_DENSE_GEOMETRY_FORMAT_SPEC_VERSION},
    {VK_EXT_OPACITY_MICROMAP_EXTENSION_NAME, VK_EXT_OPACITY_MICROMAP_SPEC_VERSION},
    {VK_KHR_OPACITY_MICROMAP_EXTENSION_NAME, VK_KHR_OPACITY_MICROMAP_SPEC_VERSION},
    {VK_NV_DISPLACEMENT_MICROMAP_EXTENSION_NAME, VK_NV_DISPLACEMENT_MICROMAP_SPEC_VERSION},
};

enum { ADVERTISED = sizeof(advertised) / sizeof(advertised[0]) };

bool cpu_advertises_extension(const char *name)
{
    for (size_t i = 0; i < ADVERTISED; i++)
        if (strcmp(advertised[i].extensionName, name) == 0)
            return true;
    return false;
}

/* Lists the driver's extensions, with room for the backend's. The caller frees the list. */
static VkResult list_driver_extensions(PFN_vkEnumerateDeviceExtensionProperties enumerate,
                                       VkPhysicalDevice physical_device, uint32_t *count,
                                       VkExtensionProperties **list)
{
    VkResult result;
    *list = NULL;
    do {
        result = enumerate(physical_device, NULL, count, NULL);
        if (result != VK_SUCCESS)
            break;
        free(*list);
        *list = calloc(*count + ADVERTISED, sizeof(**list));
        result =
            *list ? enumerate(physical_device, NULL, count, *list) : VK_ERROR_OUT_OF_HOST_MEMORY;
    } while (result == VK_INCOMPLETE);
    return result;
}

static uint32_t exchange_ray_tracing(VkExtensionProperties *list, uint32_t count)
{
    uint32_t kept = 0;
    for (uint32_t i = 0; i < count; i++)
        if (!registry_is_ray_tracing(list[i].extensionName))
            list[kept++] = list[i];
    memcpy(&list[kept], advertised, sizeof(advertised));
    return kept + ADVERTISED;
}

VkResult cpu_list_extensions(struct layer_instance *instance,
                             PFN_vkEnumerateDeviceExtensionProperties down,
                             VkPhysicalDevice physical_device, const char *layer_name,
                             uint32_t *property_count, VkExtensionProperties *properties)
{
    if (layer_name || !cpu_advertises(instance, physical_device))
        return down(physical_device, layer_name, property_count, properties);

    uint32_t count, room = properties ? *property_count : 0;
    VkExtensionProperties *list;
    VkResult result = list_driver_extensions(down, physical_device, &count, &list);
    if (result == VK_SUCCESS) {
        count = exchange_ray_tracing(list, count);
        *property_count = !properties || count < room ? count : room;
        if (properties) {
            memcpy(properties, list, *property_count * sizeof(*list));
            result = room < count ? VK_INCOMPLETE : VK_SUCCESS;
        }
    }
    free(list);
    return result;
}

/* ---- features and limits */

static const VkPhysicalDeviceAccelerationStructureFeaturesKHR structures = {
    .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_ACCELERATION_STRUCTURE_FEATURES_KHR,
    .accelerationStructure = VK_TRUE,
    .accelerationStructureIndirectBuild = VK_TRUE,
    .accelerationStructureHostCommands = VK_TRUE,
};

static const VkPhysicalDeviceRayTracingMotionBlurFeaturesNV motion = {
    .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_RAY_TRACING_MOTION_BLUR_FEATURES_NV,
    .rayTracingMotionBlur = VK_TRUE,
};

static const VkPhysicalDeviceRayTracingLinearSweptSpheresFeaturesNV spheres = {
    .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_RAY_TRACING_LINEAR_SWEPT_SPHERES_FEATURES_NV,
    .spheres = VK_TRUE,
    .linearSweptSpheres = VK_TRUE,
};

static const VkPhysicalDeviceDenseGeometryFormatFeaturesAMDX dense = {
    .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DENSE_GEOMETRY_FORMAT_FEATURES_AMDX,
    .denseGeometryFormat = VK_TRUE,
};

static const VkPhysicalDeviceOpacityMicromapFeaturesEXT micromap_ext = {
    .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_OPACITY_MICROMAP_FEATURES_EXT,
    .micromap = VK_TRUE,
    .micromapHostCommands = VK_TRUE,
};

static const VkPhysicalDeviceOpacityMicromapFeaturesKHR micromap_khr = {
    .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_OPACITY_MICROMAP_FEATURES_KHR,
    .micromap = VK_TRUE,
};

static const VkPhysicalDeviceDisplacementMicromapFeaturesNV displacement = {
    .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DISPLACEMENT_MICROMAP_FEATURES_NV,
    .displacementMicromap = VK_TRUE,
};

const struct cpu_features cpu_features[CPU_FEATURES] = {
    {(const VkBaseInStructure *)&structures,
     "accelerationStructureCaptureReplay or "
     "descriptorBindingAccelerationStructureUpdateAfterBind"},
    {(const VkBaseInStructure *)&motion, "rayTracingMotionBlurPipelineTraceRaysIndirect"},
    {(const VkBaseInStructure *)&spheres, NULL},
    {(const VkBaseInStructure *)&dense, NULL},
    {(const VkBaseInStructure *)&micromap_ext, "micromapCaptureReplay"},
    {(const VkBaseInStructure *)&micromap_khr, NULL},
    {(const VkBaseInStructure *)&displacement, NULL},
};

const struct cpu_features *cpu_find_features(VkStructureType type)
{
    for (size_t i = 0; i < CPU_FEATURES; i++)
        if (cpu_features[i].structure->sType == type)
            return &cpu_features[i];
    return NULL;
}

/* Counts are the smallest that the specification allows, so that an application which stays within
 * them runs on every device. The alignment is the largest that the specification allows. There are
 * no descriptors, because shaders cannot access what the host has built. */
enum {
    GEOMETRIES_MAX = (1 << 24) - 1,
    INSTANCES_MAX = (1 << 24) - 1,
    PRIMITIVES_MAX = (1 << 29) - 1,
};

static VkPhysicalDeviceAccelerationStructurePropertiesKHR limits(void)
{
    return (VkPhysicalDeviceAccelerationStructurePropertiesKHR){
        .maxGeometryCount = GEOMETRIES_MAX,
        .maxInstanceCount = INSTANCES_MAX,
        .maxPrimitiveCount = PRIMITIVES_MAX,
        .minAccelerationStructureScratchOffsetAlignment = 256,
    };
}

/* The limits of VK_NV_ray_tracing. Recursion is 0, because there are no pipelines. The sizes of a
 * shader binding table are those that the specification allows, because applications compute with
 * them. */
static VkPhysicalDeviceRayTracingPropertiesNV limits_nv(void)
{
    return (VkPhysicalDeviceRayTracingPropertiesNV){
        .shaderGroupHandleSize = 16,
        .maxShaderGroupStride = 4096,
        .shaderGroupBaseAlignment = 64,
        .maxGeometryCount = GEOMETRIES_MAX,
        .maxInstanceCount = INSTANCES_MAX,
        .maxTriangleCount = PRIMITIVES_MAX,
    };
}

/* Overwrites the members of the application's structure with `ours`, or with zeros if `ours` is
 * NULL. */
static void replace_members(VkBaseOutStructure *structure, size_t size, const void *ours)
{
    const size_t head = sizeof(*structure);
    if (ours)
        memcpy((char *)structure + head, (const char *)ours + head, size - head);
    else
        memset((char *)structure + head, 0, size - head);
}

/* Everything that the builder supports. */
static VkPhysicalDeviceOpacityMicromapPropertiesEXT limits_of_micromaps_ext(void)
{
    return (VkPhysicalDeviceOpacityMicromapPropertiesEXT){
        .maxOpacity2StateSubdivisionLevel = MICROMAP_MAX_LEVEL,
        .maxOpacity4StateSubdivisionLevel = MICROMAP_MAX_LEVEL,
    };
}

static VkPhysicalDeviceOpacityMicromapPropertiesKHR limits_of_micromaps_khr(void)
{
    return (VkPhysicalDeviceOpacityMicromapPropertiesKHR){
        .maxOpacity2StateSubdivisionLevel = MICROMAP_MAX_LEVEL,
        .maxOpacity4StateSubdivisionLevel = MICROMAP_MAX_LEVEL,
        .maxOpacityLossy4StateSubdivisionLevel = MICROMAP_MAX_LEVEL,
        .maxMicromapTriangles = PRIMITIVES_MAX,
    };
}

static VkPhysicalDeviceDisplacementMicromapPropertiesNV limits_of_displacement(void)
{
    return (VkPhysicalDeviceDisplacementMicromapPropertiesNV){
        .maxDisplacementMicromapSubdivisionLevel = DISPLACEMENT_MAX_LEVEL};
}

/* Overwrites a structure of ray tracing in a chain of features or properties, because the driver's
 * values do not apply. */
static void replace_structure(VkBaseOutStructure *out, size_t size)
{
    const VkPhysicalDeviceAccelerationStructurePropertiesKHR structure = limits();
    const VkPhysicalDeviceRayTracingPropertiesNV nv = limits_nv();
    const VkPhysicalDeviceOpacityMicromapPropertiesEXT ext = limits_of_micromaps_ext();
    const VkPhysicalDeviceOpacityMicromapPropertiesKHR khr = limits_of_micromaps_khr();
    const VkPhysicalDeviceDisplacementMicromapPropertiesNV nv_displacement =
        limits_of_displacement();
    const struct cpu_features *features = cpu_find_features(out->sType);
    switch (out->sType) {
    case VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_ACCELERATION_STRUCTURE_PROPERTIES_KHR:
        replace_members(out, size, &structure);
        break;
    case VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_RAY_TRACING_PROPERTIES_NV:
        replace_members(out, size, &nv);
        break;
    case VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_OPACITY_MICROMAP_PROPERTIES_EXT:
        replace_members(out, size, &ext);
        break;
    case VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_OPACITY_MICROMAP_PROPERTIES_KHR:
        replace_members(out, size, &khr);
        break;
    case VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DISPLACEMENT_MICROMAP_PROPERTIES_NV:
        replace_members(out, size, &nv_displacement);
        break;
    default:
        replace_members(out, size, features ? features->structure : NULL);
    }
}

void cpu_replace_ray_tracing(void *chain)
{
    for (VkBaseOutStructure *out = chain; out; out = out->pNext) {
        const struct registry_structure *structure = registry_find_structure(out->sType);
        if (structure && structure->ray_tracing)
            replace_structure(out, structure->size);
    }
}

/* ---- formats */

/* The bits of VkFormatFeatureFlags are the lowest ones of VkFormatFeatureFlags2. */
static VkFormatFeatureFlags2 exchange_inputs(VkFormatFeatureFlags2 features, VkFormat format)
{
    features &= ~(VK_FORMAT_FEATURE_2_ACCELERATION_STRUCTURE_VERTEX_BUFFER_BIT_KHR |
                  VK_FORMAT_FEATURE_2_ACCELERATION_STRUCTURE_RADIUS_BUFFER_BIT_NV);
    if (vertex_format_find(format))
        features |= VK_FORMAT_FEATURE_2_ACCELERATION_STRUCTURE_VERTEX_BUFFER_BIT_KHR;
    if (radius_format_size(format))
        features |= VK_FORMAT_FEATURE_2_ACCELERATION_STRUCTURE_RADIUS_BUFFER_BIT_NV;
    return features;
}

void cpu_replace_format(VkFormatProperties *properties, VkFormat format)
{
    properties->bufferFeatures =
        (VkFormatFeatureFlags)exchange_inputs(properties->bufferFeatures, format);
}

void cpu_replace_format_2(VkFormatProperties2 *properties, VkFormat format)
{
    cpu_replace_format(&properties->formatProperties, format);
    for (VkBaseOutStructure *out = properties->pNext; out; out = out->pNext) {
        VkFormatProperties3 *properties3 = (VkFormatProperties3 *)out;
        if (out->sType == VK_STRUCTURE_TYPE_FORMAT_PROPERTIES_3)
            properties3->bufferFeatures = exchange_inputs(properties3->bufferFeatures, format);
    }
}
