/* SPDX-License-Identifier: Apache-2.0 */
/* Instances and devices with the layer over one driver, for tests of backend cpu. */
#ifndef ASSAY_TESTS_CPU_BACKEND_INSTANCE_FIXTURE_H
#define ASSAY_TESTS_CPU_BACKEND_INSTANCE_FIXTURE_H

#include "messages.h"
#include "platform.h"

enum { INSTANCE_FIXTURE_EXTENSIONS_MAX = 512, INSTANCE_FIXTURE_ENABLED_MAX = 32 };

struct instance_fixture_setup {
    const char *backend;  /* assay_validation.backend; NULL: cpu */
    uint32_t api_version; /* that the application asks for; 0: 1.3 */
    bool driver_traces;   /* the null driver keeps its ray tracing; lavapipe always does */
    void (*configure)(struct null_driver_config *config); /* NULL: as it is */
};

struct instance_fixture {
    const struct platform *platform;
    struct messages messages;
    VkInstance instance;
    VkDebugUtilsMessengerEXT messenger;
    VkuInstanceDispatchTable vk;
    PFN_vkGetDeviceProcAddr get_device_proc_addr;
    VkPhysicalDevice physical;
    VkExtensionProperties extensions[INSTANCE_FIXTURE_EXTENSIONS_MAX]; /* of the physical device */
    uint32_t extension_count;
};

/* Whatever fails ends the test. */
void instance_fixture_open(struct instance_fixture *instance_fixture,
                           const struct platform *platform,
                           const struct instance_fixture_setup *setup);
void instance_fixture_close(struct instance_fixture *instance_fixture);

/* How often the physical device names an extension. */
unsigned instance_fixture_count_extension(const struct instance_fixture *instance_fixture,
                                          const char *name);

/* Whether devices have conditional rendering. */
bool instance_fixture_has_conditions(const struct instance_fixture *instance_fixture);

/* A device of one queue that enables bufferDeviceAddress, timelineSemaphore and, where there is
 * any, conditional rendering beside what `chain` says. */
VkResult instance_fixture_create_device(const struct instance_fixture *instance_fixture,
                                        const void *chain, const char *const *extensions,
                                        uint32_t extension_count, VkDevice *device,
                                        VkuDeviceDispatchTable *vk);

/* The same with the backend's extensions and all of its features. */
VkDevice instance_fixture_open_device(const struct instance_fixture *instance_fixture,
                                      VkuDeviceDispatchTable *vk);

#endif
