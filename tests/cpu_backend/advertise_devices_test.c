/* SPDX-License-Identifier: Apache-2.0 */
/* offer_devices_test null|lavapipe: devices made of what backend cpu offers. */

#include "tests/cpu_backend/advertise_fixture.h"

static struct instance_fixture other;

OFFER_TEST(test_commands_by_name)
{
    VkuDeviceDispatchTable vk;
    VkDevice device = instance_fixture_open_device(&fixture, &vk);
    assert_non_null(vk.CreateAccelerationStructureKHR);
    assert_non_null(vk.GetAccelerationStructureDeviceAddressKHR);
    assert_null(vk.CreateRayTracingPipelinesKHR);
    assert_null(fixture.get_device_proc_addr(device, "vkNoSuchCommand"));
    vk.DestroyDevice(device, NULL);

    GET(instance_fixture_create_device(&fixture, NULL, NULL, 0, &device, &vk));
    assert_null(fixture.get_device_proc_addr(device, "vkCreateAccelerationStructureKHR"));
    assert_null(fixture.get_device_proc_addr(device, "vkCreateDeferredOperationKHR"));
    vk.DestroyDevice(device, NULL);
    assert_int_equal(fixture.messages.count, 0);
}

/* Either of the extensions that have structures is enough to trace them. */
OFFER_TEST(test_nv_commands_by_name)
{
    const char *extensions[] = {VK_NV_RAY_TRACING_EXTENSION_NAME};
    VkuDeviceDispatchTable vk;
    VkDevice device;
    GET(instance_fixture_create_device(&fixture, NULL, extensions, 1, &device, &vk));
    assert_non_null(vk.CreateAccelerationStructureNV);
    assert_non_null(vk.CmdBuildAccelerationStructureNV);
    assert_non_null(vk.CmdTraceRaysNV);
    assert_null(vk.CreateAccelerationStructureKHR);
    assert_null(vk.CreateDeferredOperationKHR);
    assert_non_null(fixture.get_device_proc_addr(device, "vkTraceRaysASSAY"));
    vk.DestroyDevice(device, NULL);

    extensions[0] = VK_KHR_DEFERRED_HOST_OPERATIONS_EXTENSION_NAME;
    GET(instance_fixture_create_device(&fixture, NULL, extensions, 1, &device, &vk));
    assert_null(fixture.get_device_proc_addr(device, "vkCreateAccelerationStructureNV"));
    assert_null(fixture.get_device_proc_addr(device, "vkCreateRayTracingPipelinesNV"));
    vk.DestroyDevice(device, NULL);
    assert_int_equal(fixture.messages.count, 0);
}

/* What a driver has of the same extension isn't asked. */
TEST(test_over_a_driver_with_nv)
{
    if (!platform.is_null)
        skip();
    static const struct instance_fixture_setup setup = {.driver_traces = true};
    static const char *const extensions[] = {VK_NV_RAY_TRACING_EXTENSION_NAME};
    VkuDeviceDispatchTable vk;
    VkDevice device;
    VkAccelerationStructureNV structure;
    const STRUCT(VkAccelerationStructureCreateInfoNV, info,
                 .info = MAKE(VkAccelerationStructureInfoNV));
    instance_fixture_open(&other, &platform, &setup);
    assert_int_equal(instance_fixture_count_extension(&other, VK_NV_RAY_TRACING_EXTENSION_NAME), 1);
    GET(instance_fixture_create_device(&other, NULL, extensions, 1, &device, &vk));
    GET(vk.CreateAccelerationStructureNV(device, &info, NULL, &structure));
    vk.DestroyAccelerationStructureNV(device, structure, NULL);
    assert_int_equal(platform.null_driver.calls("vkCreateAccelerationStructureNV"), 0);
    vk.DestroyDevice(device, NULL);
    instance_fixture_close(&other);
}

OFFER_TEST(test_two_devices)
{
    VkuDeviceDispatchTable vk, plain;
    VkDevice with = instance_fixture_open_device(&fixture, &vk), without;
    GET(instance_fixture_create_device(&fixture, NULL, NULL, 0, &without, &plain));
    plain.DestroyDevice(without, NULL);
    assert_non_null(fixture.get_device_proc_addr(with, "vkCreateAccelerationStructureKHR"));
    vk.DestroyDevice(with, NULL);
    assert_int_equal(fixture.messages.count, 0);
}

/* Whatever stands before and behind the features in the chain, also what nobody knows. */
OFFER_TEST(test_chains)
{
    enum { LINKS = 5 };
    for (unsigned place = 0; place < LINKS; place++) {
        struct {
            VkStructureType sType;
            void *pNext;
            uint64_t members[300];
        } unknown[2] = {{.sType = VK_STRUCTURE_TYPE_MAX_ENUM},
                        {.sType = VK_STRUCTURE_TYPE_MAX_ENUM - 1}};
        STRUCT(VkPhysicalDeviceRayQueryFeaturesKHR, none);
        STRUCT(VkPhysicalDeviceAccelerationStructureFeaturesKHR, structures,
               .accelerationStructure = VK_TRUE, .accelerationStructureHostCommands = VK_TRUE);
        STRUCT(VkPhysicalDeviceRayTracingMotionBlurFeaturesNV, motion,
               .rayTracingMotionBlur = VK_TRUE);
        VkBaseOutStructure *links[LINKS], *chain = NULL, heads[LINKS];
        unsigned count = 0;
        void *others[] = {&unknown[0], &none, &motion, &unknown[1]};
        for (unsigned i = 0; i < LINKS; i++)
            links[i] = i == place ? (void *)&structures : others[count++];
        for (unsigned i = LINKS; i-- > 0;) {
            links[i]->pNext = chain;
            chain = links[i];
        }
        for (unsigned i = 0; i < LINKS; i++)
            heads[i] = *links[i];
        VkuDeviceDispatchTable vk;
        VkDevice device;
        GET(instance_fixture_create_device(&fixture, chain, backend_extensions, 3, &device, &vk));
        for (unsigned i = 0; i < LINKS; i++)
            assert_memory_equal(&heads[i], links[i], sizeof(heads[i]));
        vk.DestroyDevice(device, NULL);
    }
    assert_int_equal(fixture.messages.count, 0);
}

OFFER_TEST(test_what_is_not_offered)
{
    static const char *const extensions[] = {VK_KHR_ACCELERATION_STRUCTURE_EXTENSION_NAME,
                                             VK_KHR_DEFERRED_HOST_OPERATIONS_EXTENSION_NAME,
                                             VK_KHR_RAY_QUERY_EXTENSION_NAME};
    VkuDeviceDispatchTable vk;
    VkDevice device;
    STRUCT(VkPhysicalDeviceRayQueryFeaturesKHR, query, .rayQuery = VK_TRUE);
    assert_int_equal(instance_fixture_create_device(&fixture, &query, extensions, 2, &device, &vk),
                     VK_ERROR_FEATURE_NOT_PRESENT);
    assert_int_equal(messages_count(&fixture.messages, "ASSAY-error", "assay_validation.backend"),
                     1);
    assert_int_equal(messages_count(&fixture.messages, "ASSAY-error", "RayQueryFeatures"), 1);
    assert_int_equal(instance_fixture_create_device(&fixture, NULL, extensions, 3, &device, &vk),
                     VK_ERROR_EXTENSION_NOT_PRESENT);
    STRUCT(VkPhysicalDeviceRayTracingMotionBlurFeaturesNV, motion,
           .rayTracingMotionBlurPipelineTraceRaysIndirect = VK_TRUE);
    assert_int_equal(instance_fixture_create_device(&fixture, &motion, extensions, 2, &device, &vk),
                     VK_ERROR_FEATURE_NOT_PRESENT);
    assert_int_equal(messages_count(&fixture.messages, "ASSAY-error", "PipelineTraceRaysIndirect"),
                     1);

    STRUCT(VkPhysicalDeviceAccelerationStructureFeaturesKHR, structures,
           .accelerationStructure = VK_TRUE, .accelerationStructureCaptureReplay = VK_TRUE);
    assert_int_equal(
        instance_fixture_create_device(&fixture, &structures, extensions, 2, &device, &vk),
        VK_ERROR_FEATURE_NOT_PRESENT);
    assert_int_equal(messages_count(&fixture.messages, "ASSAY-error", "CaptureReplay"), 1);
}
