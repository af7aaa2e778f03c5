/* SPDX-License-Identifier: Apache-2.0 */
/* An instance and a device made as a setup asks, with the layer between. Cases of the same setup
 * share one world. */
#ifndef ASSAY_TESTS_RULES_SCENE_FIXTURE_H
#define ASSAY_TESTS_RULES_SCENE_FIXTURE_H

#include "tests/fixture/instance.h"
#include "tests/fixture/objects.h"

/* Extensions with their features, beside those that every world has. */
enum setup_enable {
    ENABLE_UINT8_KHR = 1 << 0,
    ENABLE_UINT8_EXT = 1 << 1,
    ENABLE_UINT8_CORE = 1 << 2, /* by VkPhysicalDeviceVulkan14Features; wants api 1.4 */
    ENABLE_OPACITY_MICROMAP_EXT = 1 << 3,
    ENABLE_OPACITY_MICROMAP_KHR = 1 << 4,
    ENABLE_DISPLACEMENT_MICROMAP = 1 << 5,
    ENABLE_MOTION = 1 << 6,
    ENABLE_SPHERES = 1 << 7,
    ENABLE_VIDEO = 1 << 8,
    ENABLE_PROTECTED = 1 << 9,
    ENABLE_SPARSE = 1 << 10,
    ENABLE_MAINTENANCE5 = 1 << 11,
    ENABLE_FUTURE = 1 << 12, /* an extension that no registry knows */
    ENABLE_GROUP = 1 << 13,  /* a logical device of two physical ones */
    ENABLE_RAY_TRACING_NV = 1 << 14,
    ENABLE_SYNCHRONIZATION_2 = 1 << 15, /* by its extension, too */
    ENABLE_DENSE = 1 << 16,             /* with VK_KHR_maintenance5 */
    ENABLE_DESCRIPTOR_BUFFER = 1 << 17, /* with capture and replay */
    ENABLE_PUSH_DESCRIPTOR = 1 << 18,   /* with VK_KHR_maintenance6 */
    ENABLE_RAY_TRACING_MAINTENANCE_1 = 1 << 19,
    ENABLE_NO_QUEUES = 1 << 20, /* the device has no queues */
    ENABLE_CAPTURE_REPLAY = 1 << 21,
    ENABLE_NULL_DESCRIPTOR = 1 << 23,
    ENABLE_MICROMAP_REPLAY = 1 << 22, /* with VK_EXT_opacity_micromap */
    ENABLE_CLUSTERS = 1 << 24,        /* and partitioned structures */
};

/* Features that are left off though their extension is enabled. */
enum setup_disable {
    DISABLE_ACCELERATION_STRUCTURE = 1 << 0,
    DISABLE_INDIRECT_BUILD = 1 << 1,
    DISABLE_HOST_COMMANDS = 1 << 2,
    DISABLE_BUILDS =
        DISABLE_ACCELERATION_STRUCTURE | DISABLE_INDIRECT_BUILD | DISABLE_HOST_COMMANDS,
    DISABLE_SPHERES = 1 << 3,
    DISABLE_LINEAR_SWEPT_SPHERES = 1 << 4,
    DISABLE_MICROMAP_EXT = 1 << 5,
    DISABLE_MICROMAP_KHR = 1 << 6,
    DISABLE_DENSE = 1 << 7,
    DISABLE_MICROMAP_HOST_COMMANDS = 1 << 8,
    DISABLE_DEVICE_ADDRESS_COMMANDS = 1 << 9,
    DISABLE_DESCRIPTOR_CAPTURE = 1 << 10,
    DISABLE_MULTI_DEVICE_ADDRESS = 1 << 11,
    DISABLE_CLUSTERS = 1 << 12, /* and partitioned structures */
};

/* How features are asked for, and buffer addresses retrieved. */
enum setup_route {
    ROUTE_CHAIN,     /* structures in the chain of VkDeviceCreateInfo; core 1.2 */
    ROUTE_FEATURES2, /* behind a VkPhysicalDeviceFeatures2 */
    ROUTE_KHR,       /* api 1.1 with the extensions of 1.2 and their structures */
    ROUTE_EXT,       /* VK_EXT_buffer_device_address */
};

struct setup {
    void (*configure)(struct null_driver_config *config); /* only the null driver has that */
    const char *level;                                    /* assay_validation.level */
    uint32_t enable;                                      /* enum setup_enable */
    uint32_t disable;                                     /* enum setup_disable */
    enum setup_route route;
    uint32_t api_version; /* that the application asks for; 0: 1.3 */
    const char *muted;    /* NULL, or an id (its last digits) of which nothing is to be said */
    bool by_environment;  /* the instance names no layer: the environment does */
};

enum { FIXTURE_QUEUE_FAMILIES = 8 };

struct fixture {
    struct setup setup;
    struct instance_fixture instance;
    VkDevice device;
    VkuDeviceDispatchTable vk;
    VkPhysicalDeviceAccelerationStructurePropertiesKHR limits;
    VkPhysicalDeviceMemoryProperties memory;
    VkQueueFamilyProperties families[FIXTURE_QUEUE_FAMILIES];
    uint32_t family_count;
    bool has_indirect, has_host; /* features that the driver offers */
    bool copies_inputs;          /* see scene_input() */
    bool fails;                  /* debug_action is fail: calls that break rules are skipped */
    bool misaligns;              /* calls lead to misaligned copies, see scene_misalign() */
    bool records_secondary;      /* the command buffer of the call is a secondary one */
};

/* Returns NULL, or why the platform cannot have such a world. Anything that fails though it should
 * not ends the program. */
const char *fixture_open(struct fixture *fixture, const struct platform *platform,
                         const struct setup *setup);
void fixture_close(struct fixture *fixture);
/* Opens it with the layer and the driver that the environment names, and no others; if there is
 * none, the program ends with status 3. `enable`: of the setup. */
void fixture_open_by_environment(struct fixture *fixture, uint32_t enable);

/* Another device like the world's own. */
VkDevice fixture_create_device(struct fixture *fixture);

/* The first queue family that has all of `with` and none of `without`; UINT32_MAX: there is none.
 */
uint32_t fixture_find_family(const struct fixture *fixture, VkQueueFlags with,
                             VkQueueFlags without);

#endif
