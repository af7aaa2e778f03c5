/* SPDX-License-Identifier: Apache-2.0 */
/* Instances and devices with the layer over one driver, for tests of backend cpu. */
#ifndef CPU_BACKEND_KIT_H
#define CPU_BACKEND_KIT_H

#include "messages.h"
#include "platform.h"

enum { KIT_EXTENSIONS_MAX = 512, KIT_ENABLED_MAX = 32 };

struct kit_setup {
    const char *backend;  /* assay_validation.backend; NULL: cpu */
    uint32_t api_version; /* that the application asks for; 0: 1.3 */
    bool driver_traces;   /* the null driver keeps its ray tracing; lavapipe always does */
    void (*configure)(struct null_driver_config *config); /* NULL: as it is */
};

struct kit {
    const struct platform *platform;
    struct messages messages;
    VkInstance instance;
    VkDebugUtilsMessengerEXT messenger;
    VkuInstanceDispatchTable vk;
    PFN_vkGetDeviceProcAddr get_device_proc_addr;
    VkPhysicalDevice physical;
    VkExtensionProperties extensions[KIT_EXTENSIONS_MAX]; /* of the physical device */
    uint32_t extension_count;
};

/* Whatever fails ends the test. */
void kit_open(struct kit *kit, const struct platform *platform, const struct kit_setup *setup);
void kit_close(struct kit *kit);

/* How often the physical device names an extension. */
unsigned kit_count_extension(const struct kit *kit, const char *name);

/* Whether devices have conditional rendering. */
bool kit_has_conditions(const struct kit *kit);

/* A device of one queue that enables bufferDeviceAddress, timelineSemaphore and, where there is
 * any, conditional rendering beside what `chain` says. */
VkResult kit_create_device(const struct kit *kit, const void *chain, const char *const *extensions,
                           uint32_t extension_count, VkDevice *device, VkuDeviceDispatchTable *vk);

/* The same with the backend's extensions and all of its features. */
VkDevice kit_open_device(const struct kit *kit, VkuDeviceDispatchTable *vk);

#endif
