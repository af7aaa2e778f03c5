/* SPDX-License-Identifier: Apache-2.0 */
/* The null driver through the installed loader: configuration, memory, acceleration structures. */
#include "smoke.h"
#include "tests/fixture/make.h"

#define FEATURE(config, sType, type, member, value)                                                \
    null_driver_set_feature(config, VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_##sType,                     \
                            offsetof(VkPhysicalDevice##type, member), value)

/* ---- physical devices */

static bool device_offers(struct fixture *f, const char *name)
{
    static VkExtensionProperties extensions[256];
    uint32_t count = 256;
    CHECK(f->vki.EnumerateDeviceExtensionProperties(f->physical[0], NULL, &count, extensions));
    for (uint32_t i = 0; i < count; i++) {
        if (strcmp(extensions[i].extensionName, name) == 0)
            return true;
    }
    return false;
}

static void test_configuration(void **state)
{
    struct fixture *f = *state;
    struct null_driver_config config = driver.default_config();
    config.api_version = VK_API_VERSION_1_2;
    config.as_properties.maxInstanceCount = 7;
    null_driver_hide_extension(&config, VK_KHR_RAY_QUERY_EXTENSION_NAME);
    config.extra_extensions[config.extra_extension_count++] = "VK_TEST_extra";
    FEATURE(&config, BUFFER_DEVICE_ADDRESS_FEATURES, BufferDeviceAddressFeatures,
            bufferDeviceAddressCaptureReplay, VK_FALSE);
    FEATURE(&config, FEATURES_2, Features2, features.sparseBinding, VK_FALSE);
    driver.configure(&config);
    make_instance(f);
    driver.configure(NULL);

    assert_false(device_offers(f, VK_KHR_RAY_QUERY_EXTENSION_NAME));
    assert_true(device_offers(f, "VK_TEST_extra"));
    assert_true(device_offers(f, VK_KHR_ACCELERATION_STRUCTURE_EXTENSION_NAME));

    VkPhysicalDeviceAccelerationStructurePropertiesKHR as =
        MAKE(VkPhysicalDeviceAccelerationStructurePropertiesKHR);
    VkPhysicalDeviceProperties2 properties = MAKE(VkPhysicalDeviceProperties2, .pNext = &as);
    f->vki.GetPhysicalDeviceProperties2(f->physical[0], &properties);
    assert_int_equal(properties.properties.apiVersion, VK_API_VERSION_1_2);
    assert_int_equal(as.maxInstanceCount, 7);
    assert_int_equal(as.minAccelerationStructureScratchOffsetAlignment, 256);
    assert_null(as.pNext);

    VkPhysicalDeviceVulkan12Features features12 = MAKE(VkPhysicalDeviceVulkan12Features);
    VkPhysicalDeviceRayQueryFeaturesKHR query =
        MAKE(VkPhysicalDeviceRayQueryFeaturesKHR, .pNext = &features12);
    VkPhysicalDeviceFeatures2 features = MAKE(VkPhysicalDeviceFeatures2, .pNext = &query);
    f->vki.GetPhysicalDeviceFeatures2(f->physical[0], &features);
    assert_false(query.rayQuery);
    assert_false(features12.bufferDeviceAddressCaptureReplay);
    assert_true(features12.bufferDeviceAddress);
    assert_true(features12.subgroupBroadcastDynamicId);
    assert_false(features.features.sparseBinding);
    assert_true(features.features.sparseResidencyAliased);

    features12.pNext = NULL;
    features12.bufferDeviceAddressCaptureReplay = VK_TRUE;
    assert_int_equal(make_device(f, &features12), VK_ERROR_FEATURE_NOT_PRESENT);
    query = (VkPhysicalDeviceRayQueryFeaturesKHR){.sType = query.sType, .rayQuery = VK_TRUE};
    assert_int_equal(make_device(f, &query), VK_ERROR_FEATURE_NOT_PRESENT);
    CHECK(make_device(f, NULL));
    assert_null(f->vk.QueueSubmit2); /* is of 1.3 */
    assert_null(f->vk.CreateRayTracingPipelinesKHR);
    assert_non_null(f->vk.CreateAccelerationStructure2KHR);
}

static void test_versions(void **state)
{
    struct fixture *f = *state;
    for (uint32_t minor = 0; minor <= 4; minor++) {
        struct null_driver_config config = driver.default_config();
        config.api_version = VK_MAKE_API_VERSION(0, 1, minor, 0);
        driver.configure(&config);
        make_instance(f);
        VkPhysicalDeviceProperties properties;
        f->vki.GetPhysicalDeviceProperties(f->physical[0], &properties);
        assert_int_equal(properties.apiVersion, config.api_version);
        CHECK(make_device(f, NULL));
        assert_int_equal(f->vk.GetBufferDeviceAddress != NULL, minor >= 2);
        assert_int_equal(f->vk.CmdBeginRendering != NULL, minor >= 3);
        assert_int_equal(f->vk.MapMemory2 != NULL, minor >= 4);
        tear_down(state);
    }
    driver.configure(NULL);
    make_instance(f);
    f->device = VK_NULL_HANDLE;
}

static void test_formats(void **state)
{
    struct fixture *f = *state;
    VkFormatProperties3 three = MAKE(VkFormatProperties3);
    VkFormatProperties2 properties = MAKE(VkFormatProperties2, .pNext = &three);
    f->vki.GetPhysicalDeviceFormatProperties2(f->physical[0], VK_FORMAT_R32G32B32_SFLOAT,
                                              &properties);
    assert_true(properties.formatProperties.bufferFeatures &
                VK_FORMAT_FEATURE_ACCELERATION_STRUCTURE_VERTEX_BUFFER_BIT_KHR);
    f->vki.GetPhysicalDeviceFormatProperties2(f->physical[0], VK_FORMAT_R32_SFLOAT, &properties);
    assert_true(three.bufferFeatures &
                VK_FORMAT_FEATURE_2_ACCELERATION_STRUCTURE_RADIUS_BUFFER_BIT_NV);
    f->vki.GetPhysicalDeviceFormatProperties2(f->physical[0], VK_FORMAT_R8_UNORM, &properties);
    assert_int_equal(three.bufferFeatures, 0);
}

static void test_device_group(void **state)
{
    struct fixture *f = *state;
    VkPhysicalDeviceGroupProperties group = MAKE(VkPhysicalDeviceGroupProperties);
    uint32_t count = 1;
    CHECK(f->vki.EnumeratePhysicalDeviceGroups(f->instance, &count, &group));
    assert_int_equal(count, 1);
    assert_int_equal(group.physicalDeviceCount, 2);

    VkPhysicalDeviceMemoryProperties memory;
    f->vki.GetPhysicalDeviceMemoryProperties(f->physical[0], &memory);
    assert_true(memory.memoryHeaps[0].flags & VK_MEMORY_HEAP_MULTI_INSTANCE_BIT);
    CHECK(make_device(f, &MAKE(VkDeviceGroupDeviceCreateInfo, .physicalDeviceCount = 2,
                               .pPhysicalDevices = group.physicalDevices)));
}

/* ---- memory and addresses */

static void test_addresses(void **state)
{
    struct fixture *f = *state;
    const VkBuffer unbound = make_buffer(f, 0, 4096), a = make_buffer(f, 0, 4096),
                   b = make_buffer(f, 0, 4096);
    const VkDeviceMemory memory = make_memory(f, 1, 65536);
    assert_int_not_equal(address_of(f, unbound), 0);
    CHECK(f->vk.BindBufferMemory(f->device, a, memory, 256));
    const VkBindBufferMemoryInfo bind =
        MAKE(VkBindBufferMemoryInfo, .buffer = b, .memory = memory, .memoryOffset = 512);
    CHECK(f->vk.BindBufferMemory2(f->device, 1, &bind));
    assert_int_equal(address_of(f, a) % 65536, 256);
    assert_int_equal(address_of(f, b), address_of(f, a) + 256);

    char *data;
    CHECK(f->vk.MapMemory(f->device, memory, 16, VK_WHOLE_SIZE, 0, (void **)&data));
    memset(data, 1, 65536 - 16);
    f->vk.UnmapMemory(f->device, memory);
    CHECK(f->vk.MapMemory(f->device, memory, 0, VK_WHOLE_SIZE, 0, (void **)&data));
    assert_int_equal(data[15], 0);
    assert_int_equal(data[16], 1);

    const VkDeviceMemory local = make_memory(f, 0, 65536);
    assert_int_equal(f->vk.MapMemory(f->device, local, 0, VK_WHOLE_SIZE, 0, (void **)&data),
                     VK_ERROR_MEMORY_MAP_FAILED);

    f->vk.DestroyBuffer(f->device, a, NULL);
    assert_int_equal(address_of(f, a), 0);
    assert_int_equal(address_of(f, (VkBuffer)(uintptr_t)0xdeadbeef), 0);
    assert_int_not_equal(make_buffer(f, 0, 4096), a);
}

static void test_recycling(void **state)
{
    struct fixture *f = *state;
    struct null_driver_config config = driver.default_config();
    config.recycle_handles = true;
    config.recycle_addresses = true;
    driver.configure(&config);
    make_instance(f);
    CHECK(make_device(f, NULL));
    VkDeviceAddress address = 0;
    VkBuffer before = VK_NULL_HANDLE;
    VkCommandBuffer commands_before = VK_NULL_HANDLE;
    const VkCommandPool pool = make_pool(f);
    for (int i = 0; i < 3; i++) {
        const VkDeviceMemory memory = make_memory(f, 1, 65536);
        const VkBuffer buffer = make_buffer(f, 0, 65536);
        const VkCommandBuffer commands = make_command_buffer(f, pool);
        CHECK(f->vk.BindBufferMemory(f->device, buffer, memory, 0));
        assert_true(i == 0 || buffer == before);
        assert_true(i == 0 || address_of(f, buffer) == address);
        assert_true(i == 0 || commands == commands_before);
        before = buffer;
        commands_before = commands;
        address = address_of(f, buffer);
        f->vk.FreeCommandBuffers(f->device, pool, 1, &commands);
        f->vk.DestroyBuffer(f->device, buffer, NULL);
        f->vk.FreeMemory(f->device, memory, NULL);
    }
}

static void test_sparse(void **state)
{
    struct fixture *f = *state;
    const VkBuffer buffer = make_buffer(f, VK_BUFFER_CREATE_SPARSE_BINDING_BIT, 131072);
    const VkDeviceAddress address = address_of(f, buffer);
    assert_int_not_equal(address, 0);
    VkMemoryRequirements requirements;
    f->vk.GetBufferMemoryRequirements(f->device, buffer, &requirements);
    assert_int_equal(requirements.alignment, 65536);
    const VkSparseMemoryBind bind = {.size = 65536, .memory = make_memory(f, 0, 65536)};
    const VkSparseBufferMemoryBindInfo buffer_bind = {
        .buffer = buffer, .bindCount = 1, .pBinds = &bind};
    const VkBindSparseInfo info =
        MAKE(VkBindSparseInfo, .bufferBindCount = 1, .pBufferBinds = &buffer_bind);
    CHECK(f->vk.QueueBindSparse(f->queue, 1, &info, VK_NULL_HANDLE));
    assert_int_equal(address_of(f, buffer), address);
}

/* ---- acceleration structures */

static VkAccelerationStructureKHR make_as(struct fixture *f, VkBuffer buffer, VkDeviceSize offset)
{
    const VkAccelerationStructureCreateInfoKHR info =
        MAKE(VkAccelerationStructureCreateInfoKHR, .buffer = buffer, .offset = offset, .size = 4096,
             .type = VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR);
    VkAccelerationStructureKHR as;
    CHECK(f->vk.CreateAccelerationStructureKHR(f->device, &info, NULL, &as));
    return as;
}

static VkDeviceAddress as_address(struct fixture *f, VkAccelerationStructureKHR as)
{
    return f->vk.GetAccelerationStructureDeviceAddressKHR(
        f->device, &MAKE(VkAccelerationStructureDeviceAddressInfoKHR, .accelerationStructure = as));
}

static void test_acceleration_structure(void **state)
{
    struct fixture *f = *state;
    const VkBuffer buffer = make_buffer(f, 0, 65536);
    const VkAccelerationStructureKHR as = make_as(f, buffer, 512); /* not bound yet */
    CHECK(f->vk.BindBufferMemory(f->device, buffer, make_memory(f, 0, 65536), 0));
    assert_int_equal(as_address(f, as), address_of(f, buffer) + 512);

    const uint32_t counts[] = {10, 20};
    VkAccelerationStructureBuildSizesInfoKHR sizes = MAKE(VkAccelerationStructureBuildSizesInfoKHR);
    f->vk.GetAccelerationStructureBuildSizesKHR(
        f->device, VK_ACCELERATION_STRUCTURE_BUILD_TYPE_DEVICE_KHR,
        &MAKE(VkAccelerationStructureBuildGeometryInfoKHR, .geometryCount = 2), counts, &sizes);
    assert_int_equal(sizes.accelerationStructureSize, 4096 + 30 * 64);
    assert_int_equal(driver.calls("vkGetAccelerationStructureBuildSizesKHR"), 1);

    uint64_t compacted[2] = {0};
    const VkAccelerationStructureKHR both[] = {as, as};
    CHECK(f->vk.WriteAccelerationStructuresPropertiesKHR(
        f->device, 2, both, VK_QUERY_TYPE_ACCELERATION_STRUCTURE_COMPACTED_SIZE_KHR,
        sizeof(compacted), compacted, sizeof(compacted[0])));
    assert_int_equal(compacted[1], 2048);
    f->vk.DestroyAccelerationStructureKHR(f->device, as, NULL);
    assert_int_equal(as_address(f, as), 0);
}

static void test_deferred(void **state)
{
    struct fixture *f = *state;
    VkDeferredOperationKHR operation;
    CHECK(f->vk.CreateDeferredOperationKHR(f->device, NULL, &operation));
    assert_int_equal(f->vk.BuildAccelerationStructuresKHR(f->device, operation, 0, NULL, NULL),
                     VK_OPERATION_DEFERRED_KHR);
    assert_int_equal(f->vk.GetDeferredOperationResultKHR(f->device, operation), VK_NOT_READY);
    assert_int_equal(f->vk.GetDeferredOperationMaxConcurrencyKHR(f->device, operation), 1);
    CHECK(f->vk.DeferredOperationJoinKHR(f->device, operation));
    CHECK(f->vk.GetDeferredOperationResultKHR(f->device, operation));
}

static void test_nv(void **state)
{
    struct fixture *f = *state;
    const VkAccelerationStructureCreateInfoNV info = MAKE(
        VkAccelerationStructureCreateInfoNV,
        .info = MAKE(VkAccelerationStructureInfoNV,
                     .type = VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_NV, .instanceCount = 10));
    VkAccelerationStructureNV as;
    CHECK(f->vk.CreateAccelerationStructureNV(f->device, &info, NULL, &as));
    const VkAccelerationStructureMemoryRequirementsInfoNV requirements_info =
        MAKE(VkAccelerationStructureMemoryRequirementsInfoNV, .accelerationStructure = as);
    VkMemoryRequirements2 requirements = MAKE(VkMemoryRequirements2);
    f->vk.GetAccelerationStructureMemoryRequirementsNV(f->device, &requirements_info,
                                                       &requirements);
    assert_true(requirements.memoryRequirements.size >= 4096 + 640);
    const VkBindAccelerationStructureMemoryInfoNV bind =
        MAKE(VkBindAccelerationStructureMemoryInfoNV, .accelerationStructure = as,
             .memory = make_memory(f, 0, 65536));
    CHECK(f->vk.BindAccelerationStructureMemoryNV(f->device, 1, &bind));
    uint64_t handle = 0;
    CHECK(f->vk.GetAccelerationStructureHandleNV(f->device, as, sizeof(handle), &handle));
    assert_int_not_equal(handle, 0);
    f->vk.DestroyAccelerationStructureNV(f->device, as, NULL);
}

int main(void)
{
    void *library = null_driver_load(NULL_DRIVER_LIBRARY, &driver);
    if (library == NULL) {
        print_error("%s\n", dlerror());
        return 1;
    }
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_configuration, set_up, tear_down),
        cmocka_unit_test_setup_teardown(test_versions, set_up, tear_down),
        cmocka_unit_test_setup_teardown(test_formats, set_up_device, tear_down),
        cmocka_unit_test_setup_teardown(test_device_group, set_up_device, tear_down),
        cmocka_unit_test_setup_teardown(test_addresses, set_up_device, tear_down),
        cmocka_unit_test_setup_teardown(test_recycling, set_up, tear_down),
        cmocka_unit_test_setup_teardown(test_sparse, set_up_device, tear_down),
        cmocka_unit_test_setup_teardown(test_acceleration_structure, set_up_device, tear_down),
        cmocka_unit_test_setup_teardown(test_deferred, set_up_device, tear_down),
        cmocka_unit_test_setup_teardown(test_nv, set_up_device, tear_down),
    };
    int failed = cmocka_run_group_tests_name("null_driver", tests, NULL, NULL);
    failed += run_command_tests();
    failed += run_transfer_tests();
    dlclose(library);
    return failed;
}
