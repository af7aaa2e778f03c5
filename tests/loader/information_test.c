/* SPDX-License-Identifier: Apache-2.0 */
/* information_test null|lavapipe: report_flags = info brings a line when an instance is created and
 * one at its end, to the messenger of VkInstanceCreateInfo. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "loader_test.h"

static struct {
    unsigned count;
    char text[4][4096];
} heard;

static VKAPI_ATTR VkBool32 VKAPI_CALL hear(VkDebugUtilsMessageSeverityFlagBitsEXT severity,
                                           VkDebugUtilsMessageTypeFlagsEXT types,
                                           const VkDebugUtilsMessengerCallbackDataEXT *data,
                                           void *user)
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
    const VkDebugUtilsMessengerCreateInfoEXT messenger = {
        .sType = VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT,
        .messageSeverity = VK_DEBUG_UTILS_MESSAGE_SEVERITY_INFO_BIT_EXT,
        .messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT,
        .pfnUserCallback = hear,
    };
    const char *layer = LAYER_NAME, *extension = VK_EXT_DEBUG_UTILS_EXTENSION_NAME;
    const VkInstanceCreateInfo create_info = {
        .sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO,
        .pNext = &messenger,
        .enabledLayerCount = 1,
        .ppEnabledLayerNames = &layer,
        .enabledExtensionCount = 1,
        .ppEnabledExtensionNames = &extension,
    };
    VkInstance instance;
    VkuInstanceDispatchTable vki;
    heard.count = 0;
    expect_success(((PFN_vkCreateInstance)platform.get_instance_proc_addr(
                       NULL, "vkCreateInstance"))(&create_info, NULL, &instance),
                   "vkCreateInstance");
    vkuInitInstanceDispatchTable(instance, &vki, platform.get_instance_proc_addr);
    vki.DestroyInstance(instance, NULL);
}

static void test_two_lines(void **state)
{
    setenv("VK_ASSAY_VALIDATION_REPORT_FLAGS", "error,warn,info", 1);
    setenv("VK_ASSAY_VALIDATION_LEVEL", "content", 1);
    create_and_destroy();
    assert_int_equal(heard.count, 2);
    assert_memory_equal(heard.text[0], "Assay ", 6);
    assert_non_null(strstr(heard.text[0], "level = content, backend = driver."));
    assert_non_null(strstr(heard.text[0],
                           "level = \"content\" (environment variable VK_ASSAY_VALIDATION_LEVEL)"));
    assert_string_equal(heard.text[1], "Assay found no violations in this instance.");
}

static void test_none_by_default(void **state)
{
    unsetenv("VK_ASSAY_VALIDATION_REPORT_FLAGS");
    create_and_destroy();
    assert_int_equal(heard.count, 0);
}

int main(int argc, char **argv)
{
    const int missing = platform_of_arguments(argc, argv);
    if (missing)
        return missing;
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_two_lines),
                                       cmocka_unit_test(test_none_by_default)};
    return cmocka_run_group_tests_name("information", tests, NULL, NULL);
}
