/* SPDX-License-Identifier: Apache-2.0 */
/* Tests of report_flags = info: one line when an instance is created, and one at its end. */
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

TEST_OPENED(test_nothing_without_the_flag, surrounding_set_up)
{
    struct hearing hearing = {0};
    capture_begin(STDERR_FILENO);
    finish(announced(&hearing, NULL));
    assert_string_equal(capture_end(), "");
    assert_int_equal(hearing.count, 0);
}

TEST_OPENED(test_creation, surrounding_set_up)
{
    struct hearing hearing = {0};
    environment_set("REPORT_FLAGS=error,warn,info");
    struct reporter *reporter = announced(&hearing, NULL);
    assert_int_equal(hearing.count, 1);
    assert_int_equal(hearing.severity, VK_DEBUG_UTILS_MESSAGE_SEVERITY_INFO_BIT_EXT);
    assert_string_equal(hearing.id, "ASSAY-info");
    assert_string_equal(hearing.text,
                        "Assay 1.2.3 validates acceleration-structure builds: level = execution, "
                        "backend = driver. Settings that differ from the defaults: report_flags = "
                        "\"error,warn,info\" (environment variable "
                        "VK_ASSAY_VALIDATION_REPORT_FLAGS).");
    finish(reporter);

    /* An application with no other messenger reads it in the log. */
    capture_begin(STDERR_FILENO);
    reporter = reporter_of(NULL);
    reporter_announce(reporter, "1.2.3");
    const char *log = capture_end();
    assert_has(log, "Validation Information: [ ASSAY-info ] | MessageID = 0x");
    reporter_destroy(reporter);
}

TEST_OPENED(test_sources_of_settings, surrounding_set_up)
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

static void send_warning(struct reporter *reporter)
{
    struct finding finding;
    violated_plainly(&finding, "instanceData", "is odd");
    reporter_send(reporter, RULE_nv_instance_references_are_of_live_structures,
                  &(struct location){.command = COMMAND_NV}, &(struct call_origin){0}, &finding);
}

TEST_OPENED(test_end, surrounding_set_up)
{
    struct hearing hearing = {0};
    environment_set("REPORT_FLAGS=error,warn,info DUPLICATE_MESSAGE_LIMIT=2 LEVEL=content");
    struct reporter *reporter = announced(&hearing, NULL);
    for (unsigned i = 0; i < 5000; i++) {
        send_one(reporter);
        assert_true(reporter_wants(reporter, SENT_VUID)); /* all are counted */
    }
    assert_int_equal(hearing.count, 3);
    assert_has(hearing.text, "Further ones are only counted.");
    send_warning(reporter);
    finish(reporter);
    assert_int_equal(hearing.count, 5);
    assert_int_equal(hearing.severity, VK_DEBUG_UTILS_MESSAGE_SEVERITY_INFO_BIT_EXT);
    assert_string_equal(hearing.id, "ASSAY-info");
    assert_string_equal(hearing.text, "Assay found 5001 violations in this instance: " SENT_ID
                                      " 5000 times (4998 held back by duplicate_message_limit), "
                                      "ASSAY-instance-destroyed 1 time.");
}

TEST_OPENED(test_end_without_findings, surrounding_set_up)
{
    struct hearing hearing = {0};
    environment_set("REPORT_FLAGS=info LEVEL=content");
    finish(announced(&hearing, NULL));
    assert_string_equal(hearing.text,
                        "Assay reported no violations, because report_flags leaves out errors and "
                        "warnings.");
    environment_set("REPORT_FLAGS=warn,info");
    finish(announced(&hearing, NULL));
    assert_non_null(strstr(hearing.text, "Assay found no violations in this instance"));
}

TEST_OPENED(test_what_was_not_checked, surrounding_set_up)
{
    struct hearing hearing = {0};
    environment_set("REPORT_FLAGS=error,warn,info LEVEL=parameters");
    setenv("VK_ASSAY_VALIDATION_MESSAGE_ID_FILTER", SENT_ID, 1);
    struct reporter *reporter = announced(&hearing, NULL);
    reporter_add_unchecked(reporter, "builds without memory for copies", 3);
    reporter_add_unchecked(reporter, "executions on a lost device", 1);
    reporter_add_unchecked(reporter, "builds without memory for copies", 4);
    finish(reporter);
    assert_has(hearing.text, "Assay found no violations in this instance. Not checked: ");
    assert_has(hearing.text, " VUIDs of higher levels (level = parameters)");
    assert_has(hearing.text, "; 1 VUID that message_id_filter names");
    assert_has(hearing.text, "; builds without memory for copies (7)");
    assert_has(hearing.text, "; executions on a lost device (1).");
    environment_set("LEVEL=execution");
    finish(announced(&hearing, NULL));
    assert_has(hearing.text, " VUIDs of higher levels (level = execution)");
    environment_set("LEVEL=content");
    finish(announced(&hearing, NULL));
    assert_null(strstr(hearing.text, "of higher levels"));
}

TEST_OPENED(test_report_callbacks, surrounding_set_up)
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
TEST_OPENED(test_without_memory, surrounding_set_up)
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
