/* SPDX-License-Identifier: Apache-2.0 */
/* An instance and a device made as a setup asks, with the layer between. Cases of the same setup
 * share one world. */
#ifndef ASSAY_TESTS_PLAYER_SCENE_FIXTURE_H
#define ASSAY_TESTS_PLAYER_SCENE_FIXTURE_H

#include "tests/fixture/instance.h"
#include "tests/fixture/objects.h"

/* What a device has beside what every world's has, in words with spaces between them:
 *
 *     VK_...      an extension, with its features, except those of capture and replay
 *     +FEATURE    a feature that the driver must have; see device_wish_set()
 *     -FEATURE    a feature that is off though its extension is there
 *     group       it is a logical device of two physical ones
 *     queueless   it has no queues
 *
 * These are parts of such texts; tests/programs/calls/common.cases has those of programs. */
#define WITH_MICROMAP_KHR "VK_KHR_opacity_micromap VK_KHR_device_address_commands "
#define WITHOUT_MICROMAP_KHR "-VkPhysicalDeviceOpacityMicromapFeaturesKHR.micromap"
#define WITH_DESCRIPTOR_CAPTURE "VK_EXT_descriptor_buffer +descriptorBufferCaptureReplay "
#define WITH_MOTION "VK_NV_ray_tracing_motion_blur VK_KHR_ray_tracing_pipeline "
#define WITH_SPHERES "VK_NV_ray_tracing_linear_swept_spheres VK_KHR_ray_tracing_pipeline "
#define WITH_CLUSTERS                                                                              \
    "VK_NV_cluster_acceleration_structure VK_NV_partitioned_acceleration_structure "
#define PROTECTED_FEATURE "+VkPhysicalDeviceProtectedMemoryFeatures.protectedMemory"
#define FUTURE_EXTENSION "VK_TEST_not_yet_invented" /* which no registry knows */

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
    const char *with, *needs; /* words, of the case and of its command; NULL: none */
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
 * none, the program ends with status 3. `with`: of the setup. */
void fixture_open_by_environment(struct fixture *fixture, const char *with);

/* Whether the word is one of the setup's. */
bool setup_has(const struct setup *setup, const char *word);

/* Another device like the world's own. */
VkDevice fixture_create_device(struct fixture *fixture);

/* The first queue family that has all of `with` and none of `without`; UINT32_MAX: there is none.
 */
uint32_t fixture_find_family(const struct fixture *fixture, VkQueueFlags with,
                             VkQueueFlags without);

#endif
