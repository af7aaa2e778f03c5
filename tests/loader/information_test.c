/* SPDX-License-Identifier: Apache-2.0 */
/* information_test null|lavapipe: report_flags = info brings a line when an instance is created and
 * one at its end, to the messenger of VkInstanceCreateInfo. */
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
    assert_has(heard.text[0], "level = content, backend = driver.");
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
