/* SPDX-License-Identifier: Apache-2.0 */
/* Tests of report_flags = info: where the line about settings has them from, and who gets it.
 * scenes_test.c has what the lines say. */
#include "hearing.h"

/* A messenger of the create info that hears information, too. */
static VkDebugUtilsMessengerCreateInfoEXT informed(struct hearing *hearing)
{
    VkDebugUtilsMessengerCreateInfoEXT info = hearing_messenger(hearing);
    info.messageSeverity |= VK_DEBUG_UTILS_MESSAGE_SEVERITY_INFO_BIT_EXT;
    return info;
}

static struct reporter *announced(struct hearing *hearing, const void *next)
{
    VkDebugUtilsMessengerCreateInfoEXT info = informed(hearing);
    info.pNext = next;
    struct reporter *reporter = reporter_of(&info);
    reporter_announce(reporter, "1.2.3");
    return reporter;
}

static void finish(struct reporter *reporter)
{
    reporter_set_instance_alive(reporter, false);
    reporter_summarize(reporter);
    reporter_destroy(reporter);
}

TEST_OPENED(sources_of_settings, surrounding_set_up)
{
    surrounding_clear(
        "assay_validation.level = state\n"
        "assay_validation.backend = driver\n"     /* the default */
        "assay_validation.vuid_names = retired\n" /* no valid value: the default counts */
        "assay_validation.report_flags = info\n"
        "assay_validation.log_filename = a.txt\n");
    setenv("VK_VALIDATION_SPEC_TEXT", "none", 1); /* the library reads these names, too */
    const char *filter = "03710";
    const uint32_t limit = 3;
    const char *level = "content";
    const VkLayerSettingEXT given[] = {
        {"VK_LAYER_ASSAY_validation", "message_id_filter", VK_LAYER_SETTING_TYPE_STRING_EXT, 1,
         &filter},
        {"VK_LAYER_ASSAY_validation", "duplicate_message_limit", VK_LAYER_SETTING_TYPE_UINT32_EXT,
         1, &limit},
        {"VK_LAYER_ASSAY_validation", "level", VK_LAYER_SETTING_TYPE_STRING_EXT, 1, &level},
    };
    const VkLayerSettingsCreateInfoEXT settings = {VK_STRUCTURE_TYPE_LAYER_SETTINGS_CREATE_INFO_EXT,
                                                   NULL, LENGTH(given), given};
    struct hearing hearing = {0};
    struct reporter *reporter = announced(&hearing, &settings);
    unsetenv("VK_VALIDATION_SPEC_TEXT");
    assert_string_equal(
        hearing.text,
        "Assay 1.2.3 validates acceleration-structure builds: level = state, backend = driver. "
        "Settings that differ from the defaults: level = \"state\" (file "
        "\"vk_layer_settings.txt\"), spec_text = \"none\" (environment variable "
        "VK_VALIDATION_SPEC_TEXT), report_flags = \"info\" (file \"vk_layer_settings.txt\"), "
        "log_filename = \"a.txt\" (file \"vk_layer_settings.txt\"), duplicate_message_limit = "
        "\"3\" (VkLayerSettingsCreateInfoEXT), message_id_filter = \"03710\" "
        "(VkLayerSettingsCreateInfoEXT).");
    finish(reporter);
    remove("a.txt");
}

/* The preset stands for what it sets. A key beside it is named if it changes that. */
TEST_OPENED(preset, surrounding_set_up)
{
    struct hearing hearing = {0};
    environment_set("PRESET=everything REPORT_FLAGS=info HAZARDS=false CALL_SITES=full");
    struct reporter *reporter = announced(&hearing, NULL);
    assert_string_equal(
        hearing.text,
        "Assay 1.2.3 validates acceleration-structure builds: level = content, backend = driver. "
        "Settings that differ from the defaults: preset = \"everything\" (environment variable "
        "VK_ASSAY_VALIDATION_PRESET), report_flags = \"info\" (environment variable "
        "VK_ASSAY_VALIDATION_REPORT_FLAGS), hazards = \"false\" (environment variable "
        "VK_ASSAY_VALIDATION_HAZARDS).");
    finish(reporter);
}

TEST_OPENED(report_callbacks, surrounding_set_up)
{
    struct hearing hearing = {0};
    environment_set("REPORT_FLAGS=info");
    VkDebugReportCallbackCreateInfoEXT info = hearing_report_callback(&hearing);
    capture_begin(STDERR_FILENO);
    struct reporter *reporter = reporter_of(&info);
    reporter_announce(reporter, "1.2.3");
    assert_int_equal(hearing.count, 0); /* it hears errors and warnings */
    reporter_destroy(reporter);
    assert_has(capture_end(), "Assay 1.2.3");

    info.flags = VK_DEBUG_REPORT_INFORMATION_BIT_EXT;
    reporter = reporter_of(&info);
    reporter_announce(reporter, "1.2.3");
    assert_int_equal(hearing.count, 1);
    assert_int_equal(hearing.report_flags, VK_DEBUG_REPORT_INFORMATION_BIT_EXT);
    reporter_destroy(reporter);
}

/* Without memory for the settings, the line is sent without them. */
TEST_OPENED(without_memory, surrounding_set_up)
{
    environment_set("REPORT_FLAGS=info LEVEL=state");
    struct hearing hearing = {0};
    const VkDebugUtilsMessengerCreateInfoEXT info = informed(&hearing);
    const VkInstanceCreateInfo create_info = {.pNext = &info};
    for (int count = 0; memory_is_scarce(count); count++) {
        struct reporter *reporter = NULL;
        VkResult result = reporter_create(&create_info, &reporter);
        hearing.count = 0;
        if (result == VK_SUCCESS) {
            reporter_announce(reporter, "1.2.3");
            reporter_add_unchecked(reporter, "builds", 1);
            finish(reporter);
            assert_int_equal(hearing.count, 2);
        }
        memory_fail_no_more();
    }
}
