/* SPDX-License-Identifier: Apache-2.0 */
/* VK_EXT_device_fault: what the driver says of the loss, if the application has enabled that. */
#include "tests/snapshots/scene.h"

enum { BUFFER_SIZE = 1 << 16 };

static struct device_buffer vertices;

static void open_with(VkBool32 feature)
{
    STRUCT(VkPhysicalDeviceFaultFeaturesEXT, fault, .deviceFault = feature);
    fixture_open_with(&fixture, &platform, &(struct instance_settings){0}, &fault,
                      VK_EXT_DEVICE_FAULT_EXTENSION_NAME);
    vertices = fixture_buffer(&fixture, BUFFER_SIZE,
                              VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_STORAGE_BIT_KHR);
    scene_set_name(VK_OBJECT_TYPE_BUFFER, (uint64_t)vertices.handle, "vertices");
}

static void open_all(void)
{
    open_with(VK_TRUE);
}

static void close_all(void)
{
    fixture_close(&fixture);
    platform.null_driver.reset();
}

#define FAULT_TEST(name) TEST_BETWEEN(name, open_all, close_all)

static void lose(VkDeviceAddress address)
{
    PLAN_FAULT(.kind = NULL_DRIVER_LOSE, .at = NULL_DRIVER_AT_WAIT, .address = address,
               .precision = 64);
    assert_int_equal(fixture.vk.DeviceWaitIdle(fixture.device), VK_ERROR_DEVICE_LOST);
}

FAULT_TEST(test_live_buffer)
{
    lose(vertices.address + 32);
    assert_int_equal(
        messages_count(&fixture.instance.messages, "ASSAY-device-lost",
                       "The driver reports: \"a page is missing\"\n  invalid read at "),
        1);
    expect_messages(1, " (somewhere in the 64 bytes around it), in VkBuffer ");
}

FAULT_TEST(test_live_structure)
{
    fixture_structure(&fixture, &vertices, 256, 512,
                      VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR);
    lose(vertices.address + 256 + 511);
    assert_int_equal(messages_count(&fixture.instance.messages, "ASSAY-device-lost",
                                    ", in VkAccelerationStructureKHR 0x"),
                     1);
    expect_messages(1, ", in VkBuffer ");
}

FAULT_TEST(test_destroyed_buffer)
{
    const VkDeviceAddress address = vertices.address;
    fixture_destroy_buffer(&fixture, &vertices);
    lose(address);
    expect_messages(1, "[\"vertices\"], which was destroyed");
}

FAULT_TEST(test_address_of_nothing)
{
    lose(16);
    assert_lacks(fixture.instance.messages.items[0].text, ", in ");
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

FAULT_TEST(test_driver_has_nothing_to_say)
{
    lose(0);
    fixture_expect_silence(&fixture);
}
