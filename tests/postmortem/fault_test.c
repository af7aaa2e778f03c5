/* SPDX-License-Identifier: Apache-2.0 */
/* VK_EXT_device_fault: what the driver says of the loss, if the application has enabled that. */
#include "tests/snapshots/scene.h"

#include <string.h>

enum { BUFFER_SIZE = 1 << 16 };

static struct device_buffer vertices;

/* A device as that of the fixture, with the extension. */
static void open_with(VkBool32 feature)
{
    static const char *const extensions[] = {VK_KHR_ACCELERATION_STRUCTURE_EXTENSION_NAME,
                                             VK_KHR_DEFERRED_HOST_OPERATIONS_EXTENSION_NAME,
                                             VK_EXT_DEVICE_FAULT_EXTENSION_NAME};
    VkPhysicalDeviceFaultFeaturesEXT fault =
        MAKE(VkPhysicalDeviceFaultFeaturesEXT, .deviceFault = feature);
    const VkPhysicalDeviceAccelerationStructureFeaturesKHR structures =
        MAKE(VkPhysicalDeviceAccelerationStructureFeaturesKHR, .pNext = &fault,
             .accelerationStructure = VK_TRUE);
    memset(&fixture, 0, sizeof(fixture));
    instance_fixture_create(&fixture.instance, &platform, &(struct instance_settings){0});
    GET(instance_fixture_create_device(&fixture.instance, &structures, extensions, 3,
                                       &fixture.device, &fixture.vk));
    fixture.memory_type = instance_fixture_memory_type(&fixture.instance);
    fixture.vk.GetDeviceQueue(fixture.device, 0, 0, &fixture.queue);
    fixture.pool = command_pool_create(&fixture.vk, fixture.device);
    const VkDebugUtilsObjectNameInfoEXT name =
        MAKE(VkDebugUtilsObjectNameInfoEXT, .objectType = VK_OBJECT_TYPE_BUFFER,
             .pObjectName = "vertices");
    vertices = fixture_buffer(&fixture, BUFFER_SIZE,
                              VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_STORAGE_BIT_KHR);
    VkDebugUtilsObjectNameInfoEXT own = name;
    own.objectHandle = (uint64_t)vertices.handle;
    GET(fixture.vk.SetDebugUtilsObjectNameEXT(fixture.device, &own));
}

static void close_all(void)
{
    fixture_close(&fixture);
    platform.null_driver.reset();
}

static void lose(VkDeviceAddress address)
{
    platform.null_driver.plan_fault(&(struct null_driver_fault){
        .kind = NULL_DRIVER_LOSE, .at = NULL_DRIVER_AT_WAIT, .address = address, .precision = 64});
    assert_int_equal(fixture.vk.DeviceWaitIdle(fixture.device), VK_ERROR_DEVICE_LOST);
}

TEST_CLOSED(test_live_buffer, close_all)
{
    open_with(VK_TRUE);
    lose(vertices.address + 32);
    assert_int_equal(
        messages_count(&fixture.instance.messages, "ASSAY-device-lost",
                       "The driver reports: \"a page is missing\"\n  invalid read at "),
        1);
    expect_messages(1, " (somewhere in the 64 bytes around it), in VkBuffer ");
}

TEST_CLOSED(test_live_structure, close_all)
{
    open_with(VK_TRUE);
    fixture_structure(&fixture, &vertices, 256, 512,
                      VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR);
    lose(vertices.address + 256 + 511);
    assert_int_equal(messages_count(&fixture.instance.messages, "ASSAY-device-lost",
                                    ", in VkAccelerationStructureKHR 0x"),
                     1);
    expect_messages(1, ", in VkBuffer ");
}

TEST_CLOSED(test_destroyed_buffer, close_all)
{
    open_with(VK_TRUE);
    const VkDeviceAddress address = vertices.address;
    fixture_destroy_buffer(&fixture, &vertices);
    lose(address);
    expect_messages(1, "[\"vertices\"], which was destroyed");
}

TEST_CLOSED(test_address_of_nothing, close_all)
{
    open_with(VK_TRUE);
    lose(16);
    assert_null(strstr(fixture.instance.messages.items[0].text, ", in "));
    expect_messages(1, "  invalid read at 0x10 (somewhere in the 64 bytes around it)");
}

TEST_CLOSED(test_not_enabled, close_all)
{
    open_with(VK_FALSE);
    const uint64_t calls = platform.null_driver.calls("vkGetDeviceFaultInfoEXT");
    lose(vertices.address);
    assert_int_equal(platform.null_driver.calls("vkGetDeviceFaultInfoEXT"), calls);
    fixture_expect_silence(&fixture);
}

TEST_CLOSED(test_driver_has_nothing_to_say, close_all)
{
    open_with(VK_TRUE);
    lose(0);
    fixture_expect_silence(&fixture);
}
