/* SPDX-License-Identifier: Apache-2.0 */
/* Collects what the application enabled for a device, in any of the possible ways, and the device's
 * limits. */
#include <stdlib.h>
#include <string.h>

#include "layer/layer.h"
#include "layer/physical_device.h"
#include "src/base/chain.h"
#include "vuid-tables/registry.h"

static void collect_extensions(struct device_facts *facts, const VkDeviceCreateInfo *create_info)
{
    facts->extension.acceleration_structure =
        enables_extension(create_info, VK_KHR_ACCELERATION_STRUCTURE_EXTENSION_NAME);
    facts->extension.motion_blur_nv =
        enables_extension(create_info, VK_NV_RAY_TRACING_MOTION_BLUR_EXTENSION_NAME);
    facts->extension.opacity_micromap_ext =
        enables_extension(create_info, VK_EXT_OPACITY_MICROMAP_EXTENSION_NAME);
    facts->extension.opacity_micromap_khr =
        enables_extension(create_info, VK_KHR_OPACITY_MICROMAP_EXTENSION_NAME);
    facts->extension.displacement_micromap_nv =
        enables_extension(create_info, VK_NV_DISPLACEMENT_MICROMAP_EXTENSION_NAME);
    facts->extension.linear_swept_spheres_nv =
        enables_extension(create_info, VK_NV_RAY_TRACING_LINEAR_SWEPT_SPHERES_EXTENSION_NAME);
    facts->extension.dense_geometry_format_amdx =
        enables_extension(create_info, VK_AMDX_DENSE_GEOMETRY_FORMAT_EXTENSION_NAME);
    facts->extension.position_fetch_khr =
        enables_extension(create_info, VK_KHR_RAY_TRACING_POSITION_FETCH_EXTENSION_NAME);
    facts->extension.cluster_acceleration_structure_nv =
        enables_extension(create_info, VK_NV_CLUSTER_ACCELERATION_STRUCTURE_EXTENSION_NAME);
    facts->micromap.any = facts->extension.opacity_micromap_ext ||
                          facts->extension.opacity_micromap_khr ||
                          facts->extension.displacement_micromap_nv;
    facts->extension.adds_to_inputs =
        facts->extension.motion_blur_nv || facts->extension.linear_swept_spheres_nv ||
        facts->extension.dense_geometry_format_amdx || facts->micromap.any;
    facts->extension.ray_tracing_nv =
        enables_extension(create_info, VK_NV_RAY_TRACING_EXTENSION_NAME);
    for (uint32_t i = 0; i < create_info->enabledExtensionCount; i++)
        if (!registry_knows_extension(create_info->ppEnabledExtensionNames[i]))
            facts->newer_than_registry = true;
    if (VK_API_VERSION_MINOR(facts->api_version) > VK_API_VERSION_MINOR(VK_HEADER_VERSION_COMPLETE))
        facts->newer_than_registry = true;
}

/* Backend cpu executes the queries of VK_KHR_ray_tracing_maintenance1, whose other parts it lacks,
 * so that it cannot offer the extension. */
static bool owns_values(const VkDeviceCreateInfo *create_info, const char *extension,
                        enum backend_setting backend)
{
    return enables_extension(create_info, extension) ||
           (backend == BACKEND_CPU &&
            strcmp(extension, VK_KHR_RAY_TRACING_MAINTENANCE_1_EXTENSION_NAME) == 0);
}

static void collect_owners(struct device_facts *facts, const VkDeviceCreateInfo *create_info,
                           enum backend_setting backend)
{
    for (uint32_t i = 0; i < create_info->queueCreateInfoCount; i++)
        facts->has_queues |= create_info->pQueueCreateInfos[i].queueCount > 0;
    for (size_t i = 0; i < registry_owner_count; i++)
        facts->owners |= (uint64_t)owns_values(create_info, registry_owners[i], backend) << i;
}

/* Unknown extensions may do anything. */
static bool has_other_builders(const struct device_facts *facts,
                               const VkDeviceCreateInfo *create_info)
{
    return facts->newer_than_registry || facts->extension.cluster_acceleration_structure_nv ||
           enables_extension(create_info, VK_NV_PARTITIONED_ACCELERATION_STRUCTURE_EXTENSION_NAME);
}

static void collect_address_and_descriptor_features(struct device_facts *facts, const void *chain)
{
    const VkPhysicalDeviceVulkan12Features *core =
        chain_find(chain, VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES);
    const VkPhysicalDeviceBufferDeviceAddressFeatures *own =
        chain_find(chain, VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_BUFFER_DEVICE_ADDRESS_FEATURES);
    const VkPhysicalDeviceBufferDeviceAddressFeaturesEXT *ext =
        chain_find(chain, VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_BUFFER_DEVICE_ADDRESS_FEATURES_EXT);
    const VkPhysicalDeviceDescriptorBufferFeaturesEXT *descriptors =
        chain_find(chain, VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DESCRIPTOR_BUFFER_FEATURES_EXT);
    facts->buffer_device_address_multi_device = (core && core->bufferDeviceAddressMultiDevice) ||
                                                (own && own->bufferDeviceAddressMultiDevice) ||
                                                (ext && ext->bufferDeviceAddressMultiDevice);
    const VkPhysicalDeviceDeviceAddressCommandsFeaturesKHR *commands =
        chain_find(chain, VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DEVICE_ADDRESS_COMMANDS_FEATURES_KHR);
    facts->device_address_commands = commands && commands->deviceAddressCommands;
    facts->descriptor_buffer_capture_replay =
        descriptors && descriptors->descriptorBufferCaptureReplay;
    const VkPhysicalDeviceRobustness2FeaturesKHR *robustness =
        chain_find(chain, VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_ROBUSTNESS_2_FEATURES_KHR);
    facts->null_descriptor =
        (robustness && robustness->nullDescriptor) || facts->newer_than_registry;
}

/* A structure that is absent leaves its features off. */
static void collect_features(struct device_facts *facts, const void *chain)
{
    const VkPhysicalDeviceAccelerationStructureFeaturesKHR *accel =
        chain_find(chain, VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_ACCELERATION_STRUCTURE_FEATURES_KHR);
    facts->acceleration_structure = accel && accel->accelerationStructure;
    facts->acceleration_structure_indirect_build =
        accel && accel->accelerationStructureIndirectBuild;
    facts->acceleration_structure_host_commands = accel && accel->accelerationStructureHostCommands;
    facts->accel_capture_replay = accel && accel->accelerationStructureCaptureReplay;

    const VkPhysicalDeviceRayTracingMaintenance1FeaturesKHR *maintenance =
        chain_find(chain, VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_RAY_TRACING_MAINTENANCE_1_FEATURES_KHR);
    const VkPhysicalDeviceSynchronization2Features *synchronization =
        chain_find(chain, VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SYNCHRONIZATION_2_FEATURES);
    const VkPhysicalDeviceVulkan13Features *core_13 =
        chain_find(chain, VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_FEATURES);
    const VkPhysicalDeviceMultiviewFeatures *multiview =
        chain_find(chain, VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MULTIVIEW_FEATURES);
    const VkPhysicalDeviceVulkan11Features *core_11 =
        chain_find(chain, VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_1_FEATURES);
    facts->multiview = (multiview && multiview->multiview) || (core_11 && core_11->multiview);
    facts->ray_tracing_maintenance1 = maintenance && maintenance->rayTracingMaintenance1;
    facts->synchronization2 = (synchronization && synchronization->synchronization2) ||
                              (core_13 && core_13->synchronization2);

    const VkPhysicalDeviceRayTracingLinearSweptSpheresFeaturesNV *spheres = chain_find(
        chain, VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_RAY_TRACING_LINEAR_SWEPT_SPHERES_FEATURES_NV);
    const VkPhysicalDeviceFaultFeaturesEXT *fault =
        chain_find(chain, VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FAULT_FEATURES_EXT);
    facts->device_fault = fault && fault->deviceFault;
    facts->spheres = spheres && spheres->spheres;
    facts->linear_swept_spheres = spheres && spheres->linearSweptSpheres;

    const VkPhysicalDeviceOpacityMicromapFeaturesEXT *ext =
        chain_find(chain, VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_OPACITY_MICROMAP_FEATURES_EXT);
    const VkPhysicalDeviceOpacityMicromapFeaturesKHR *khr =
        chain_find(chain, VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_OPACITY_MICROMAP_FEATURES_KHR);
    facts->micromap.ext = ext && ext->micromap;
    facts->micromap.khr = khr && khr->micromap;
    facts->micromap.host_commands = ext && ext->micromapHostCommands;
    facts->micromap.capture_replay = ext && ext->micromapCaptureReplay;

    const VkPhysicalDeviceDenseGeometryFormatFeaturesAMDX *dense =
        chain_find(chain, VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DENSE_GEOMETRY_FORMAT_FEATURES_AMDX);
    facts->dense_geometry_format = dense && dense->denseGeometryFormat;

    const VkPhysicalDeviceClusterAccelerationStructureFeaturesNV *clusters = chain_find(
        chain, VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_CLUSTER_ACCELERATION_STRUCTURE_FEATURES_NV);
    const VkPhysicalDevicePartitionedAccelerationStructureFeaturesNV *partitions = chain_find(
        chain, VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PARTITIONED_ACCELERATION_STRUCTURE_FEATURES_NV);
    facts->clusters.feature = clusters && clusters->clusterAccelerationStructure;
    facts->partitions.feature = partitions && partitions->partitionedAccelerationStructure;
}

/* The structures of micromap properties that a physical device may support. */
struct micromap_properties {
    VkPhysicalDeviceOpacityMicromapPropertiesEXT ext;
    VkPhysicalDeviceOpacityMicromapPropertiesKHR khr;
    VkPhysicalDeviceDisplacementMicromapPropertiesNV displacement;
};

/* Prepends the structures of enabled extensions. The others keep values that allow everything. */
static void chain_micromap_properties(const struct device_facts *facts, void **chain,
                                      struct micromap_properties *properties)
{
    *properties = (struct micromap_properties){
        .ext = {VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_OPACITY_MICROMAP_PROPERTIES_EXT, NULL, UINT32_MAX,
                UINT32_MAX},
        .khr = {VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_OPACITY_MICROMAP_PROPERTIES_KHR, NULL, UINT32_MAX,
                UINT32_MAX, UINT32_MAX, UINT64_MAX},
        .displacement = {VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DISPLACEMENT_MICROMAP_PROPERTIES_NV,
                         NULL, UINT32_MAX}};
    if (facts->extension.opacity_micromap_ext) {
        properties->ext.pNext = *chain;
        *chain = &properties->ext;
    }
    if (facts->extension.opacity_micromap_khr) {
        properties->khr.pNext = *chain;
        *chain = &properties->khr;
    }
    if (facts->extension.displacement_micromap_nv) {
        properties->displacement.pNext = *chain;
        *chain = &properties->displacement;
    }
}

static void keep_micromap_limits(struct micromap_support *support,
                                 const struct micromap_properties *properties)
{
    support->ext_limits.opacity_2_state_level = properties->ext.maxOpacity2StateSubdivisionLevel;
    support->ext_limits.opacity_4_state_level = properties->ext.maxOpacity4StateSubdivisionLevel;
    support->khr_limits.opacity_2_state_level = properties->khr.maxOpacity2StateSubdivisionLevel;
    support->khr_limits.opacity_4_state_level = properties->khr.maxOpacity4StateSubdivisionLevel;
    support->khr_limits.lossy_4_state_level = properties->khr.maxOpacityLossy4StateSubdivisionLevel;
    support->khr_limits.triangles = properties->khr.maxMicromapTriangles;
    support->displacement_level = properties->displacement.maxDisplacementMicromapSubdivisionLevel;
}

/* Properties which few devices need. */
struct other_properties {
    VkPhysicalDeviceDescriptorBufferPropertiesEXT descriptors;
    VkPhysicalDeviceProtectedMemoryProperties protected_memory;
    VkPhysicalDeviceClusterAccelerationStructurePropertiesNV clusters;
    VkPhysicalDevicePartitionedAccelerationStructurePropertiesNV partitions;
};

static void chain_other_properties(const struct device_facts *facts, void **chain,
                                   struct other_properties *properties)
{
    *properties = (struct other_properties){
        .descriptors = {.sType =
                            VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DESCRIPTOR_BUFFER_PROPERTIES_EXT},
        .protected_memory = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROTECTED_MEMORY_PROPERTIES,
                             .protectedNoFault = VK_TRUE},
        .clusters =
            {.sType =
                 VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_CLUSTER_ACCELERATION_STRUCTURE_PROPERTIES_NV,
             .maxVerticesPerCluster = UINT32_MAX,
             .maxTrianglesPerCluster = UINT32_MAX,
             .maxClusterGeometryIndex = UINT32_MAX},
        .partitions = {
            .sType =
                VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PARTITIONED_ACCELERATION_STRUCTURE_PROPERTIES_NV,
            .maxPartitionCount = UINT32_MAX}};
    if (facts->clusters.feature) {
        properties->clusters.pNext = *chain;
        *chain = &properties->clusters;
    }
    if (facts->partitions.feature) {
        properties->partitions.pNext = *chain;
        *chain = &properties->partitions;
    }
    if (facts->descriptor_buffer_capture_replay) {
        properties->descriptors.pNext = *chain;
        *chain = &properties->descriptors;
    }
    if (facts->device_address_commands) {
        properties->protected_memory.pNext = *chain;
        *chain = &properties->protected_memory;
    }
}

static void keep_other_properties(struct device_facts *facts,
                                  const struct other_properties *properties)
{
    facts->clusters.limits = properties->clusters;
    facts->clusters.limits.pNext = NULL;
    facts->partitions.maximum = properties->partitions.maxPartitionCount;
    facts->accel_capture_size =
        properties->descriptors.accelerationStructureCaptureReplayDescriptorDataSize;
    if (facts->device_address_commands)
        facts->protected_no_fault = properties->protected_memory.protectedNoFault ? YES : NO;
}

/* Limits that cannot be queried allow everything. */
static void collect_limits(struct layer_device *device)
{
    PFN_vkGetPhysicalDeviceProperties2 get_properties = physical_device_properties2(
        device->instance, &device->instance->vk, device->physical_device);
    VkPhysicalDeviceAccelerationStructurePropertiesKHR *limits = &device->facts.limits;
    VkPhysicalDeviceRayTracingPropertiesNV *nv_limits = &device->facts.nv_limits;
    limits->sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_ACCELERATION_STRUCTURE_PROPERTIES_KHR;
    limits->maxGeometryCount = UINT64_MAX;
    limits->maxPrimitiveCount = UINT64_MAX;
    limits->maxInstanceCount = UINT64_MAX;
    nv_limits->sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_RAY_TRACING_PROPERTIES_NV;
    nv_limits->maxGeometryCount = UINT64_MAX;
    nv_limits->maxInstanceCount = UINT64_MAX;
    nv_limits->maxTriangleCount = UINT64_MAX;
    VkPhysicalDeviceProperties2 properties = {.sType =
                                                  VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2};
    struct micromap_properties micromap;
    struct other_properties other;
    chain_micromap_properties(&device->facts, &properties.pNext, &micromap);
    chain_other_properties(&device->facts, &properties.pNext, &other);
    if (device->facts.extension.acceleration_structure) {
        limits->pNext = properties.pNext;
        properties.pNext = limits;
    }
    if (device->facts.extension.ray_tracing_nv) {
        nv_limits->pNext = properties.pNext;
        properties.pNext = nv_limits;
    }
    if (get_properties && properties.pNext)
        get_properties(device->physical_device, &properties);
    keep_other_properties(&device->facts, &other);
    keep_micromap_limits(&device->facts.micromap, &micromap);
    limits->pNext = nv_limits->pNext = NULL;
}

static VkResult collect_queue_families(struct layer_device *device)
{
    const VkuInstanceDispatchTable *vk = &device->instance->vk;
    vk->GetPhysicalDeviceQueueFamilyProperties(device->physical_device, &device->queue_family_count,
                                               NULL);
    device->queue_families =
        calloc(device->queue_family_count + 1, sizeof(*device->queue_families));
    if (!device->queue_families)
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    vk->GetPhysicalDeviceQueueFamilyProperties(device->physical_device, &device->queue_family_count,
                                               device->queue_families);
    return VK_SUCCESS;
}

static bool is_on_processor(const struct layer_device *device)
{
    VkPhysicalDeviceProperties properties;
    device->instance->vk.GetPhysicalDeviceProperties(device->physical_device, &properties);
    return properties.deviceType == VK_PHYSICAL_DEVICE_TYPE_CPU;
}

VkResult layer_collect_device_facts(struct layer_device *device,
                                    const VkDeviceCreateInfo *create_info)
{
    const VkDeviceGroupDeviceCreateInfo *group =
        chain_find(create_info->pNext, VK_STRUCTURE_TYPE_DEVICE_GROUP_DEVICE_CREATE_INFO);
    device->is_on_processor = is_on_processor(device);
    device->facts.handle = device->handle;
    device->facts.api_version =
        physical_device_api_version(device->instance, device->physical_device);
    collect_extensions(&device->facts, create_info);
    collect_owners(&device->facts, create_info, device->instance->backend);
    device->facts.has_other_builders = has_other_builders(&device->facts, create_info);
    collect_features(&device->facts, create_info->pNext);
    collect_address_and_descriptor_features(&device->facts, create_info->pNext);
    device->facts.is_group = group && group->physicalDeviceCount > 1;
    device->may_query_structures =
        device->facts.acceleration_structure &&
        (!device->facts.is_group || device->facts.buffer_device_address_multi_device);
    collect_limits(device);
    device->instance->vk.GetPhysicalDeviceMemoryProperties(device->physical_device,
                                                           &device->memory);
    return collect_queue_families(device);
}
