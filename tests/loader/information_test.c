/* SPDX-License-Identifier: Apache-2.0 */
/* information_test null|lavapipe|cpu_null: report_flags = info brings a line when an instance is
 * created and one at its end, to the messenger of VkInstanceCreateInfo, and
 * vkGetPhysicalDeviceToolProperties lists the layer. The null driver lacks the command. */
#include "loader_test.h"

static struct {
    unsigned count;
    char text[4][4096];
} heard;

MESSENGER_CALLBACK(hear)
{
    if (data->pMessageIdName && strcmp(data->pMessageIdName, "ASSAY-info") == 0 &&
        heard.count < LENGTH(heard.text)) {
        assert_int_equal(severity, VK_DEBUG_UTILS_MESSAGE_SEVERITY_INFO_BIT_EXT);
        snprintf(heard.text[heard.count++], sizeof(heard.text[0]), "%s", data->pMessage);
    }
    return VK_FALSE;
}

static void create_and_destroy(void)
{
    const STRUCT(VkDebugUtilsMessengerCreateInfoEXT, messenger,
                 .messageSeverity = VK_DEBUG_UTILS_MESSAGE_SEVERITY_INFO_BIT_EXT,
                 .messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT,
                 .pfnUserCallback = hear);
    const char *layer = LAYER_NAME, *extension = VK_EXT_DEBUG_UTILS_EXTENSION_NAME;
    const STRUCT(VkInstanceCreateInfo, create_info, .pNext = &messenger, .enabledLayerCount = 1,
                 .ppEnabledLayerNames = &layer, .enabledExtensionCount = 1,
                 .ppEnabledExtensionNames = &extension);
    VkInstance instance;
    heard.count = 0;
    GET(GLOBAL(CreateInstance)(&create_info, NULL, &instance));
    COMMAND_OF(instance, DestroyInstance)(instance, NULL);
}

TEST(test_two_lines)
{
    setenv("VK_ASSAY_VALIDATION_REPORT_FLAGS", "error,warn,info", 1);
    setenv("VK_ASSAY_VALIDATION_LEVEL", "content", 1);
    create_and_destroy();
    assert_int_equal(heard.count, 2);
    assert_memory_equal(heard.text[0], "Assay ", 6);
    assert_has(heard.text[0], platform.is_cpu ? "level = content, backend = cpu."
                                              : "level = content, backend = driver.");
    assert_has(heard.text[0],
               "level = \"content\" (environment variable VK_ASSAY_VALIDATION_LEVEL)");
    assert_string_equal(heard.text[1], "Assay found no violations in this instance.");
}

TEST(test_none_by_default)
{
    unsetenv("VK_ASSAY_VALIDATION_REPORT_FLAGS");
    create_and_destroy();
    assert_int_equal(heard.count, 0);
}

/* ---- tools */

enum { TOOLS_MAX = 8 };

static void check_tool(const VkPhysicalDeviceToolProperties *tool, const void *chain)
{
    assert_int_equal(tool->sType, VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_TOOL_PROPERTIES);
    assert_ptr_equal(tool->pNext, chain);
    assert_string_equal(tool->name, "Assay");
    assert_string_equal(tool->layer, LAYER_NAME);
    const VkToolPurposeFlags modifies =
        VK_TOOL_PURPOSE_ADDITIONAL_FEATURES_BIT | VK_TOOL_PURPOSE_MODIFYING_FEATURES_BIT;
    assert_int_equal(tool->purposes, VK_TOOL_PURPOSE_VALIDATION_BIT |
                                         VK_TOOL_PURPOSE_DEBUG_REPORTING_BIT_EXT |
                                         (platform.is_cpu ? modifies : 0));
    assert_int_not_equal(tool->version[0], '\0');
    assert_int_not_equal(tool->description[0], '\0');
}

static void check_list(VkPhysicalDevice physical_device, PFN_vkGetPhysicalDeviceToolProperties get)
{
    VkPhysicalDeviceToolProperties tools[TOOLS_MAX];
    VkBaseOutStructure chained = {0};
    uint32_t count = 77;
    assert_int_equal(get(physical_device, &count, NULL), VK_SUCCESS);
    assert_in_range(count, 1, TOOLS_MAX);
    const uint32_t all = count;
    for (uint32_t room = 0; room < TOOLS_MAX; room++) {
        memset(tools, 0xee, sizeof(tools));
        for (uint32_t i = 0; i < TOOLS_MAX; i++) {
            tools[i].sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_TOOL_PROPERTIES;
            tools[i].pNext = i == 0 ? &chained : NULL;
        }
        count = room;
        assert_int_equal(get(physical_device, &count, tools),
                         room < all ? VK_INCOMPLETE : VK_SUCCESS);
        assert_int_equal(count, room < all ? room : all);
        if (room)
            check_tool(&tools[0], &chained);
        assert_int_equal((unsigned char)tools[count].name[0], 0xee);
    }
}

TEST(test_the_layer_is_listed)
{
    static struct fixture fixture;
    const struct setup setup = {0};
    assert_null(fixture_open(&fixture, &platform, &setup));
    static const char *const names[] = {"vkGetPhysicalDeviceToolProperties",
                                        "vkGetPhysicalDeviceToolPropertiesEXT"};
    for (size_t i = 0; i < LENGTH(names); i++) {
        const PFN_vkGetPhysicalDeviceToolProperties get =
            (PFN_vkGetPhysicalDeviceToolProperties)platform.get_instance_proc_addr(
                fixture.instance.instance, names[i]);
        assert_non_null(get);
        check_list(fixture.instance.physical, get);
    }
    fixture_close(&fixture);
}
