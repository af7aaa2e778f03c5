/* SPDX-License-Identifier: Apache-2.0 */
/* Making instances and devices. */
#include "tests/cpu_backend/instance_fixture.h"

#include "vuid-tables/registry.h"

const char *const backend_extensions[BACKEND_EXTENSIONS] = {
    VK_KHR_ACCELERATION_STRUCTURE_EXTENSION_NAME,
    VK_KHR_DEFERRED_HOST_OPERATIONS_EXTENSION_NAME,
    VK_NV_RAY_TRACING_MOTION_BLUR_EXTENSION_NAME,
    VK_NV_RAY_TRACING_EXTENSION_NAME,
    VK_NV_RAY_TRACING_LINEAR_SWEPT_SPHERES_EXTENSION_NAME,
    VK_AMDX_DENSE_GEOMETRY_FORMAT_EXTENSION_NAME,
    VK_EXT_OPACITY_MICROMAP_EXTENSION_NAME,
    VK_KHR_OPACITY_MICROMAP_EXTENSION_NAME,
    VK_NV_DISPLACEMENT_MICROMAP_EXTENSION_NAME,
};

static void configure(const struct platform *platform, const struct instance_fixture_setup *setup)
{
    struct null_driver_config config = platform->null_driver.default_config();
    for (size_t i = 0; !setup->driver_traces && i < registry_ray_tracing_count; i++)
        null_driver_hide_extension(&config, registry_ray_tracing[i]);
    if (setup->configure != NULL)
        setup->configure(&config);
    platform->null_driver.configure(&config);
}

void instance_fixture_open(struct instance_fixture *fixture, const struct platform *platform,
                           const struct instance_fixture_setup *setup)
{
    const struct instance_settings settings = {
        .backend = setup->backend ? setup->backend : "cpu",
        .api_version = setup->api_version,
    };
    if (platform->is_null)
        configure(platform, setup);
    instance_fixture_create(fixture, platform, &settings);
}

struct backend_features *backend_features_chain(void)
{
    static struct backend_features all;
    all = (struct backend_features){
        .displacement = MAKE(VkPhysicalDeviceDisplacementMicromapFeaturesNV),
        .micromap_khr =
            MAKE(VkPhysicalDeviceOpacityMicromapFeaturesKHR, .pNext = &all.displacement),
        .micromap_ext = MAKE(VkPhysicalDeviceOpacityMicromapFeaturesEXT, .pNext = &all.micromap_khr,
                             .micromapCaptureReplay = VK_TRUE),
        .dense = MAKE(VkPhysicalDeviceDenseGeometryFormatFeaturesAMDX, .pNext = &all.micromap_ext),
        .spheres =
            MAKE(VkPhysicalDeviceRayTracingLinearSweptSpheresFeaturesNV, .pNext = &all.dense),
        .motion = MAKE(VkPhysicalDeviceRayTracingMotionBlurFeaturesNV, .pNext = &all.spheres,
                       .rayTracingMotionBlurPipelineTraceRaysIndirect = VK_TRUE),
        .structures = MAKE(VkPhysicalDeviceAccelerationStructureFeaturesKHR, .pNext = &all.motion,
                           .accelerationStructureCaptureReplay = VK_TRUE,
                           .descriptorBindingAccelerationStructureUpdateAfterBind = VK_TRUE)};
    return &all;
}

VkDevice instance_fixture_open_device(const struct instance_fixture *fixture,
                                      VkuDeviceDispatchTable *vk)
{
    VkDevice device;
    STRUCT(VkPhysicalDeviceFeatures2, features, .pNext = backend_features_chain());
    fixture->vk.GetPhysicalDeviceFeatures2(fixture->physical, &features);
    GET(instance_fixture_create_device(fixture, features.pNext, backend_extensions,
                                       BACKEND_EXTENSIONS, &device, vk));
    return device;
}
