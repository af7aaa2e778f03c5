/* SPDX-License-Identifier: Apache-2.0 */
/* The configuration of the null driver, through the installed loader: what tests of the layer ask
 * for, and do not notice if it is missing. All else that the driver does is shown by them. */
#include "tests/fixture/instance.h"
#include "tests/fixture/make.h"
#include "tests/unit/unit_test.h"

#define FEATURE(config, sType, type, member, value)                                                \
    null_driver_set_feature(config, VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_##sType,                     \
                            offsetof(VkPhysicalDevice##type, member), value)

#define OFFERED(extension) instance_fixture_count_extension(&fixture, extension)

static struct platform platform;
static struct instance_fixture fixture;
static VkuDeviceDispatchTable vk;
static VkDevice device;

const char *unit_test_open(const char *argument)
{
    return platform_open(&platform, "null");
}

static void make_instance(const struct null_driver_config *config)
{
    static const struct instance_settings plain = {.without_layer = true};
    platform.null_driver.reset();
    platform.null_driver.configure(config);
    instance_fixture_create(&fixture, &platform, &plain);
    platform.null_driver.configure(NULL);
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
    const VkResult result = fixture.vk.CreateDevice(fixture.physical, &info, NULL, &device);
    if (result == VK_SUCCESS)
        vkuInitDeviceDispatchTable(device, &vk, fixture.get_device_proc_addr);
    return result;
}

static void destroy(void)
{
    vk.DestroyDevice(device, NULL);
    instance_fixture_close(&fixture);
}

TEST_CLOSED(configuration, destroy)
{
    struct null_driver_config config = platform.null_driver.default_config();
    config.api_version = VK_API_VERSION_1_2;
    config.as_properties.maxInstanceCount = 7;
    null_driver_hide_extension(&config, VK_KHR_RAY_QUERY_EXTENSION_NAME);
    config.extra_extensions[config.extra_extension_count++] = "VK_TEST_extra";
    FEATURE(&config, BUFFER_DEVICE_ADDRESS_FEATURES, BufferDeviceAddressFeatures,
            bufferDeviceAddressCaptureReplay, VK_FALSE);
    FEATURE(&config, FEATURES_2, Features2, features.sparseBinding, VK_FALSE);
    make_instance(&config);

    assert_int_equal(OFFERED(VK_KHR_RAY_QUERY_EXTENSION_NAME), 0);
    assert_int_equal(OFFERED("VK_TEST_extra"), 1);
    assert_int_equal(OFFERED(VK_KHR_ACCELERATION_STRUCTURE_EXTENSION_NAME), 1);

    STRUCT(VkPhysicalDeviceAccelerationStructurePropertiesKHR, as);
    STRUCT(VkPhysicalDeviceProperties2, properties, .pNext = &as);
    fixture.vk.GetPhysicalDeviceProperties2(fixture.physical, &properties);
    assert_int_equal(properties.properties.apiVersion, VK_API_VERSION_1_2);
    assert_int_equal(as.maxInstanceCount, 7);
    assert_int_equal(as.minAccelerationStructureScratchOffsetAlignment, 256);
    assert_null(as.pNext);

    STRUCT(VkPhysicalDeviceVulkan12Features, features12);
    STRUCT(VkPhysicalDeviceRayQueryFeaturesKHR, query, .pNext = &features12);
    STRUCT(VkPhysicalDeviceFeatures2, features, .pNext = &query);
    fixture.vk.GetPhysicalDeviceFeatures2(fixture.physical, &features);
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
        struct null_driver_config config = platform.null_driver.default_config();
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
    GET(fixture.vk.EnumeratePhysicalDeviceGroups(fixture.instance, &count, &group));
    assert_int_equal(count, 1);
    assert_int_equal(group.physicalDeviceCount, 2);

    VkPhysicalDeviceMemoryProperties memory;
    fixture.vk.GetPhysicalDeviceMemoryProperties(fixture.physical, &memory);
    assert_true(memory.memoryHeaps[0].flags & VK_MEMORY_HEAP_MULTI_INSTANCE_BIT);
    GET(make_device(&MAKE(VkDeviceGroupDeviceCreateInfo, .physicalDeviceCount = 2,
                          .pPhysicalDevices = group.physicalDevices)));
}
