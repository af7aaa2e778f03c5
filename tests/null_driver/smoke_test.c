/* SPDX-License-Identifier: Apache-2.0 */
/* The null driver through the installed loader: configuration, memory, acceleration structures. */
#include "smoke.h"

#define FEATURE(config, sType, type, member, value)                                                \
    null_driver_set_feature(config, VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_##sType,                     \
                            offsetof(VkPhysicalDevice##type, member), value)

/* ---- physical devices */

static bool device_offers(const char *name)
{
    static VkExtensionProperties extensions[256];
    uint32_t count = 256;
    GET(vki.EnumerateDeviceExtensionProperties(physical[0], NULL, &count, extensions));
    for (uint32_t i = 0; i < count; i++) {
        if (strcmp(extensions[i].extensionName, name) == 0)
            return true;
    }
    return false;
}

INSTANCE_TEST(test_configuration)
{
    struct null_driver_config config = driver.default_config();
    config.api_version = VK_API_VERSION_1_2;
    config.as_properties.maxInstanceCount = 7;
    null_driver_hide_extension(&config, VK_KHR_RAY_QUERY_EXTENSION_NAME);
    config.extra_extensions[config.extra_extension_count++] = "VK_TEST_extra";
    FEATURE(&config, BUFFER_DEVICE_ADDRESS_FEATURES, BufferDeviceAddressFeatures,
            bufferDeviceAddressCaptureReplay, VK_FALSE);
    FEATURE(&config, FEATURES_2, Features2, features.sparseBinding, VK_FALSE);
    driver.configure(&config);
    make_instance();
    driver.configure(NULL);

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

INSTANCE_TEST(test_versions)
{
    for (uint32_t minor = 0; minor <= 4; minor++) {
        struct null_driver_config config = driver.default_config();
        config.api_version = VK_MAKE_API_VERSION(0, 1, minor, 0);
        driver.configure(&config);
        make_instance();
        VkPhysicalDeviceProperties properties;
        vki.GetPhysicalDeviceProperties(physical[0], &properties);
        assert_int_equal(properties.apiVersion, config.api_version);
        GET(make_device(NULL));
        assert_int_equal(vk.GetBufferDeviceAddress != NULL, minor >= 2);
        assert_int_equal(vk.CmdBeginRendering != NULL, minor >= 3);
        assert_int_equal(vk.MapMemory2 != NULL, minor >= 4);
        tear_down();
    }
    driver.configure(NULL);
    make_instance();
    device = VK_NULL_HANDLE;
}

DEVICE_TEST(test_formats)
{
    STRUCT(VkFormatProperties3, three);
    STRUCT(VkFormatProperties2, properties, .pNext = &three);
    vki.GetPhysicalDeviceFormatProperties2(physical[0], VK_FORMAT_R32G32B32_SFLOAT, &properties);
    assert_true(properties.formatProperties.bufferFeatures &
                VK_FORMAT_FEATURE_ACCELERATION_STRUCTURE_VERTEX_BUFFER_BIT_KHR);
    vki.GetPhysicalDeviceFormatProperties2(physical[0], VK_FORMAT_R32_SFLOAT, &properties);
    assert_true(three.bufferFeatures &
                VK_FORMAT_FEATURE_2_ACCELERATION_STRUCTURE_RADIUS_BUFFER_BIT_NV);
    vki.GetPhysicalDeviceFormatProperties2(physical[0], VK_FORMAT_R8_UNORM, &properties);
    assert_int_equal(three.bufferFeatures, 0);
}

DEVICE_TEST(test_device_group)
{
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

/* ---- memory and addresses */

DEVICE_TEST(test_addresses)
{
    const VkBuffer unbound = make_buffer(0, 4096), a = make_buffer(0, 4096),
                   b = make_buffer(0, 4096);
    const VkDeviceMemory memory = make_memory(1, 65536);
    assert_int_not_equal(address_of(unbound), 0);
    GET(vk.BindBufferMemory(device, a, memory, 256));
    const STRUCT(VkBindBufferMemoryInfo, bind, .buffer = b, .memory = memory, .memoryOffset = 512);
    GET(vk.BindBufferMemory2(device, 1, &bind));
    assert_int_equal(address_of(a) % 65536, 256);
    assert_int_equal(address_of(b), address_of(a) + 256);

    char *data;
    GET(vk.MapMemory(device, memory, 16, VK_WHOLE_SIZE, 0, (void **)&data));
    memset(data, 1, 65536 - 16);
    vk.UnmapMemory(device, memory);
    GET(vk.MapMemory(device, memory, 0, VK_WHOLE_SIZE, 0, (void **)&data));
    assert_int_equal(data[15], 0);
    assert_int_equal(data[16], 1);

    const VkDeviceMemory local = make_memory(0, 65536);
    assert_int_equal(vk.MapMemory(device, local, 0, VK_WHOLE_SIZE, 0, (void **)&data),
                     VK_ERROR_MEMORY_MAP_FAILED);

    vk.DestroyBuffer(device, a, NULL);
    assert_int_equal(address_of(a), 0);
    assert_int_equal(address_of((VkBuffer)(uintptr_t)0xdeadbeef), 0);
    assert_int_not_equal(make_buffer(0, 4096), a);
}

INSTANCE_TEST(test_recycling)
{
    struct null_driver_config config = driver.default_config();
    config.recycle_handles = true;
    config.recycle_addresses = true;
    driver.configure(&config);
    make_instance();
    GET(make_device(NULL));
    VkDeviceAddress address = 0;
    VkBuffer before = VK_NULL_HANDLE;
    VkCommandBuffer commands_before = VK_NULL_HANDLE;
    const VkCommandPool pool = command_pool_create(&vk, device);
    for (int i = 0; i < 3; i++) {
        const VkDeviceMemory memory = make_memory(1, 65536);
        const VkBuffer buffer = make_buffer(0, 65536);
        const VkCommandBuffer commands = make_command_buffer(pool);
        GET(vk.BindBufferMemory(device, buffer, memory, 0));
        assert_true(i == 0 || buffer == before);
        assert_true(i == 0 || address_of(buffer) == address);
        assert_true(i == 0 || commands == commands_before);
        before = buffer;
        commands_before = commands;
        address = address_of(buffer);
        vk.FreeCommandBuffers(device, pool, 1, &commands);
        vk.DestroyBuffer(device, buffer, NULL);
        vk.FreeMemory(device, memory, NULL);
    }
}

DEVICE_TEST(test_sparse)
{
    const VkBuffer buffer = make_buffer(VK_BUFFER_CREATE_SPARSE_BINDING_BIT, 131072);
    const VkDeviceAddress address = address_of(buffer);
    assert_int_not_equal(address, 0);
    VkMemoryRequirements requirements;
    vk.GetBufferMemoryRequirements(device, buffer, &requirements);
    assert_int_equal(requirements.alignment, 65536);
    const VkSparseMemoryBind bind = {.size = 65536, .memory = make_memory(0, 65536)};
    const VkSparseBufferMemoryBindInfo buffer_bind = {
        .buffer = buffer, .bindCount = 1, .pBinds = &bind};
    const STRUCT(VkBindSparseInfo, info, .bufferBindCount = 1, .pBufferBinds = &buffer_bind);
    GET(vk.QueueBindSparse(queue, 1, &info, VK_NULL_HANDLE));
    assert_int_equal(address_of(buffer), address);
}

/* ---- acceleration structures */

static VkAccelerationStructureKHR make_as(VkBuffer buffer, VkDeviceSize offset)
{
    const STRUCT(VkAccelerationStructureCreateInfoKHR, info, .buffer = buffer, .offset = offset,
                 .size = 4096, .type = VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR);
    VkAccelerationStructureKHR as;
    GET(vk.CreateAccelerationStructureKHR(device, &info, NULL, &as));
    return as;
}

DEVICE_TEST(test_acceleration_structure)
{
    const VkBuffer buffer = make_buffer(0, 65536);
    const VkAccelerationStructureKHR as = make_as(buffer, 512); /* not bound yet */
    GET(vk.BindBufferMemory(device, buffer, make_memory(0, 65536), 0));
    assert_int_equal(structure_address(&vk, device, as), address_of(buffer) + 512);

    const uint32_t counts[] = {10, 20};
    STRUCT(VkAccelerationStructureBuildSizesInfoKHR, sizes);
    vk.GetAccelerationStructureBuildSizesKHR(
        device, VK_ACCELERATION_STRUCTURE_BUILD_TYPE_DEVICE_KHR,
        &MAKE(VkAccelerationStructureBuildGeometryInfoKHR, .geometryCount = 2), counts, &sizes);
    assert_int_equal(sizes.accelerationStructureSize, 4096 + 30 * 64);
    assert_int_equal(driver.calls("vkGetAccelerationStructureBuildSizesKHR"), 1);

    uint64_t compacted[2] = {0};
    const VkAccelerationStructureKHR both[] = {as, as};
    GET(vk.WriteAccelerationStructuresPropertiesKHR(
        device, 2, both, VK_QUERY_TYPE_ACCELERATION_STRUCTURE_COMPACTED_SIZE_KHR, sizeof(compacted),
        compacted, sizeof(compacted[0])));
    assert_int_equal(compacted[1], 2048);
    vk.DestroyAccelerationStructureKHR(device, as, NULL);
    assert_int_equal(structure_address(&vk, device, as), 0);
}

DEVICE_TEST(test_deferred)
{
    VkDeferredOperationKHR operation;
    GET(vk.CreateDeferredOperationKHR(device, NULL, &operation));
    assert_int_equal(vk.BuildAccelerationStructuresKHR(device, operation, 0, NULL, NULL),
                     VK_OPERATION_DEFERRED_KHR);
    assert_int_equal(vk.GetDeferredOperationResultKHR(device, operation), VK_NOT_READY);
    assert_int_equal(vk.GetDeferredOperationMaxConcurrencyKHR(device, operation), 1);
    GET(vk.DeferredOperationJoinKHR(device, operation));
    GET(vk.GetDeferredOperationResultKHR(device, operation));
}

DEVICE_TEST(test_nv)
{
    const STRUCT(VkAccelerationStructureCreateInfoNV, info,
                 .info = MAKE(VkAccelerationStructureInfoNV,
                              .type = VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_NV,
                              .instanceCount = 10));
    VkAccelerationStructureNV as;
    GET(vk.CreateAccelerationStructureNV(device, &info, NULL, &as));
    const STRUCT(VkAccelerationStructureMemoryRequirementsInfoNV, requirements_info,
                 .accelerationStructure = as);
    STRUCT(VkMemoryRequirements2, requirements);
    vk.GetAccelerationStructureMemoryRequirementsNV(device, &requirements_info, &requirements);
    assert_true(requirements.memoryRequirements.size >= 4096 + 640);
    const STRUCT(VkBindAccelerationStructureMemoryInfoNV, bind, .accelerationStructure = as,
                 .memory = make_memory(0, 65536));
    GET(vk.BindAccelerationStructureMemoryNV(device, 1, &bind));
    uint64_t handle = 0;
    GET(vk.GetAccelerationStructureHandleNV(device, as, sizeof(handle), &handle));
    assert_int_not_equal(handle, 0);
    vk.DestroyAccelerationStructureNV(device, as, NULL);
}
