/* SPDX-License-Identifier: Apache-2.0 */
/* The extensions and features of a world's device, by its setup. */
#ifndef RULES_DEVICE_FEATURES_H
#define RULES_DEVICE_FEATURES_H

#include "tests/rules/fixture.h"

enum { FEATURES_EXTENSIONS = 24 };

/* Holds what a VkDeviceCreateInfo points to. */
struct features {
    const char *extensions[FEATURES_EXTENSIONS];
    uint32_t extension_count;
    VkPhysicalDeviceFeatures2 core;
    VkPhysicalDeviceVulkan12Features vulkan12;
    VkPhysicalDeviceVulkan13Features vulkan13;
    VkPhysicalDeviceVulkan14Features vulkan14;
    VkPhysicalDeviceProtectedMemoryFeatures protected_memory;
    VkPhysicalDeviceBufferDeviceAddressFeatures address_khr;
    VkPhysicalDeviceBufferDeviceAddressFeaturesEXT address_ext;
    VkPhysicalDeviceAccelerationStructureFeaturesKHR acceleration_structure;
    VkPhysicalDeviceIndexTypeUint8Features uint8;
    VkPhysicalDeviceOpacityMicromapFeaturesEXT micromap_ext;
    VkPhysicalDeviceOpacityMicromapFeaturesKHR micromap_khr;
    VkPhysicalDeviceDisplacementMicromapFeaturesNV displacement;
    VkPhysicalDeviceRayTracingMotionBlurFeaturesNV motion;
    VkPhysicalDeviceRayTracingLinearSweptSpheresFeaturesNV spheres;
    VkPhysicalDeviceDenseGeometryFormatFeaturesAMDX dense;
    VkPhysicalDeviceMaintenance5Features maintenance5;
    VkPhysicalDeviceDynamicRenderingFeatures dynamic_rendering;
};

/* Chains everything to `create_info`; `features` has to outlive its use. */
void features_fill(struct features *features, const struct fixture *fixture,
                   VkDeviceCreateInfo *create_info);

/* NULL, or which extension or feature of the setup the physical device lacks. */
const char *features_missing(const struct fixture *fixture);

/* What the null driver must be told to offer the setup. */
void features_configure(struct null_driver_config *config, const struct setup *setup);

#endif
