/* SPDX-License-Identifier: Apache-2.0 */
/* Instances and devices with the layer over one driver, for tests of backend cpu. */
#ifndef ASSAY_TESTS_CPU_BACKEND_INSTANCE_FIXTURE_H
#define ASSAY_TESTS_CPU_BACKEND_INSTANCE_FIXTURE_H

#include "tests/fixture/instance.h"
#include "tests/fixture/make.h"

struct instance_fixture_setup {
    const char *backend;  /* assay_validation.backend; NULL: cpu */
    uint32_t api_version; /* that the application asks for; 0: 1.3 */
    bool driver_traces;   /* the null driver keeps its ray tracing; lavapipe always does */
    void (*configure)(struct null_driver_config *config); /* NULL: as it is */
};

void instance_fixture_open(struct instance_fixture *fixture, const struct platform *platform,
                           const struct instance_fixture_setup *setup);

/* All that the backend offers. The first two are those of acceleration structures. */
enum { BACKEND_EXTENSIONS = 9 };
extern const char *const backend_extensions[BACKEND_EXTENSIONS];

/* A chain of the features of all that, with VK_TRUE for those that the backend
 * doesn't offer. There is one. */
struct backend_features {
    VkPhysicalDeviceAccelerationStructureFeaturesKHR structures; /* the first of the chain */
    VkPhysicalDeviceRayTracingMotionBlurFeaturesNV motion;
    VkPhysicalDeviceRayTracingLinearSweptSpheresFeaturesNV spheres;
    VkPhysicalDeviceDenseGeometryFormatFeaturesAMDX dense;
    VkPhysicalDeviceOpacityMicromapFeaturesEXT micromap_ext;
    VkPhysicalDeviceOpacityMicromapFeaturesKHR micromap_khr;
    VkPhysicalDeviceDisplacementMicromapFeaturesNV displacement;
};
struct backend_features *backend_features_chain(void);

/* A device with the backend's extensions and all of its features. */
VkDevice instance_fixture_open_device(const struct instance_fixture *fixture,
                                      VkuDeviceDispatchTable *vk);

#endif
