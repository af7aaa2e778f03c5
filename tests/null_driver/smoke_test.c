/* SPDX-License-Identifier: Apache-2.0 */
/* The configuration of the null driver, through the installed loader: what tests of the layer ask
 * for, and do not notice if it is missing. All else that the driver does is shown by them. */
#include "null_driver.h"
#include "tests/fixture/make.h"
#include "tests/fixture/objects.h"
#include "tests/unit/unit_test.h"

#include <string.h>

#define FEATURE(config, sType, type, member, value)                                                \
    null_driver_set_feature(config, VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_##sType,                     \
                            offsetof(VkPhysicalDevice##type, member), value)

PFN_vkVoidFunction vkGetInstanceProcAddr(VkInstance instance, const char *pName); /* the loader's */

static struct null_driver_api driver;
static VkuInstanceDispatchTable vki;
static VkuDeviceDispatchTable vk;
static VkPhysicalDevice physical[NULL_DRIVER_PHYSICAL_DEVICES];
static VkInstance instance;
static VkDevice device;
static void *library;

const char *unit_test_open(const char *argument)
{
    library = null_driver_load(NULL_DRIVER_LIBRARY, &driver);
    return library ? NULL : dlerror();
}

void unit_test_close(void)
{
    dlclose(library);
}

static void make_instance(const struct null_driver_config *config)
{
    PFN_vkCreateInstance create =
        (PFN_vkCreateInstance)vkGetInstanceProcAddr(NULL, "vkCreateInstance");
    const STRUCT(VkApplicationInfo, application, .apiVersion = VK_API_VERSION_1_3);
    uint32_t count = NULL_DRIVER_PHYSICAL_DEVICES;
    driver.reset();
    driver.configure(config);
    GET(create(&MAKE(VkInstanceCreateInfo, .pApplicationInfo = &application), NULL, &instance));
    vkuInitInstanceDispatchTable(instance, &vki, vkGetInstanceProcAddr);
    GET(vki.EnumeratePhysicalDevices(instance, &count, physical));
    driver.configure(NULL);
}

static VkResult make_device(const void *pNext)
{
    static const char *const extensions[] = {VK_KHR_ACCELERATION_STRUCTURE_EXTENSION_NAME,
                                             VK_KHR_DEFERRED_HOST_OPERATIONS_EXTENSION_NAME,
                                             VK_KHR_DEVICE_ADDRESS_COMMANDS_EXTENSION_NAME};
    const float priority = 1;
    const STRUCT(VkDeviceQueueCreateInfo, queue, .queueCount = 1, .pQueuePriorities = &priority);
    const STRUCT(VkDeviceCreateInfo, info, .pNext = pNext, .queueCreateInfoCount = 1,
                 .pQueueCreateInfos = &queue, .enabledExtensionCount = ARRAY_COUNT(extensions),
                 .ppEnabledExtensionNames = extensions);
    PFN_vkCreateDevice create =
        (PFN_vkCreateDevice)vkGetInstanceProcAddr(instance, "vkCreateDevice");
    const VkResult result = create(physical[0], &info, NULL, &device);
    if (result == VK_SUCCESS)
        vkuInitDeviceDispatchTable(
            device, &vk,
            (PFN_vkGetDeviceProcAddr)vkGetInstanceProcAddr(instance, "vkGetDeviceProcAddr"));
    return result;
}

static void destroy(void)
{
    vk.DestroyDevice(device, NULL);
    vki.DestroyInstance(instance, NULL);
}

static bool device_offers(const char *name)
{
    static VkExtensionProperties extensions[256];
    uint32_t count = 256;
    GET(vki.EnumerateDeviceExtensionProperties(physical[0], NULL, &count, extensions));
    for (uint32_t i = 0; i < count; i++)
        if (strcmp(extensions[i].extensionName, name) == 0)
            return true;
    return false;
}

TEST_CLOSED(configuration, destroy)
{
    struct null_driver_config config = driver.default_config();
    config.api_version = VK_API_VERSION_1_2;
    config.as_properties.maxInstanceCount = 7;
    null_driver_hide_extension(&config, VK_KHR_RAY_QUERY_EXTENSION_NAME);
    config.extra_extensions[config.extra_extension_count++] = "VK_TEST_extra";
    FEATURE(&config, BUFFER_DEVICE_ADDRESS_FEATURES, BufferDeviceAddressFeatures,
            bufferDeviceAddressCaptureReplay, VK_FALSE);
    FEATURE(&config, FEATURES_2, Features2, features.sparseBinding, VK_FALSE);
    make_instance(&config);

    assert_false(device_offers(VK_KHR_RAY_QUERY_EXTENSION_NAME));
    assert_true(device_offers("VK_TEST_extra"));
    assert_true(device_offers(VK_KHR_ACCELERATION_STRUCTURE_EXTENSION_NAME));

    STRUCT(VkPhysicalDeviceAccelerationStructurePropertiesKHR, as);
    STRUCT(VkPhysicalDeviceProperties2, properties, .pNext = &as);
    vki.GetPhysicalDeviceProperties2(physical[0], &properties);
    assert_int_equal(properties.properties.apiVersion, VK_API_VERSION_1_2);
    assert_int_equal(as.maxInstanceCount, 7);
    assert_int_equal(as.minAccelerationStructureScratchOffsetAlignment, 256);
    assert_null(as.pNext);

    STRUCT(VkPhysicalDeviceVulkan12Features, features12);
    STRUCT(VkPhysicalDeviceRayQueryFeaturesKHR, query, .pNext = &features12);
    STRUCT(VkPhysicalDeviceFeatures2, features, .pNext = &query);
    vki.GetPhysicalDeviceFeatures2(physical[0], &features);
    assert_false(query.rayQuery);
    assert_false(features12.bufferDeviceAddressCaptureReplay);
    assert_true(features12.bufferDeviceAddress);
    assert_true(features12.subgroupBroadcastDynamicId);
    assert_false(features.features.sparseBinding);
    assert_true(features.features.sparseResidencyAliased);

    features12.pNext = NULL;
    features12.bufferDeviceAddressCaptureReplay = VK_TRUE;
    assert_int_equal(make_device(&features12), VK_ERROR_FEATURE_NOT_PRESENT);
    query = (VkPhysicalDeviceRayQueryFeaturesKHR){.sType = query.sType, .rayQuery = VK_TRUE};
    assert_int_equal(make_device(&query), VK_ERROR_FEATURE_NOT_PRESENT);
    GET(make_device(NULL));
    assert_null(vk.QueueSubmit2); /* is of 1.3 */
    assert_null(vk.CreateRayTracingPipelinesKHR);
    assert_non_null(vk.CreateAccelerationStructure2KHR);
}

TEST(versions)
{
    for (uint32_t minor = 0; minor <= 4; minor++) {
        struct null_driver_config config = driver.default_config();
        config.api_version = VK_MAKE_API_VERSION(0, 1, minor, 0);
        make_instance(&config);
        GET(make_device(NULL));
        assert_int_equal(vk.GetBufferDeviceAddress != NULL, minor >= 2);
        assert_int_equal(vk.CmdBeginRendering != NULL, minor >= 3);
        assert_int_equal(vk.MapMemory2 != NULL, minor >= 4);
        destroy();
    }
}

TEST_CLOSED(device_group, destroy)
{
    make_instance(NULL);
    STRUCT(VkPhysicalDeviceGroupProperties, group);
    uint32_t count = 1;
    GET(vki.EnumeratePhysicalDeviceGroups(instance, &count, &group));
    assert_int_equal(count, 1);
    assert_int_equal(group.physicalDeviceCount, 2);

    VkPhysicalDeviceMemoryProperties memory;
    vki.GetPhysicalDeviceMemoryProperties(physical[0], &memory);
    assert_true(memory.memoryHeaps[0].flags & VK_MEMORY_HEAP_MULTI_INSTANCE_BIT);
    GET(make_device(&MAKE(VkDeviceGroupDeviceCreateInfo, .physicalDeviceCount = 2,
                          .pPhysicalDevices = group.physicalDevices)));
}
