/* SPDX-License-Identifier: Apache-2.0 */
/* Tests of the settings: what they take, and what is said of the rest. */
#include <sys/stat.h>

#include "reading.h"
#include "src/report/ids/message_filter.h"

TEST_OPENED(test_values_that_are_not_understood, surrounding_set_up)
{
    static const struct {
        const char *key, *value, *takes, *used;
    } cases[] = {
        {"level", "contents", "parameters, state, execution or content", "execution"},
        {"level", "state,content", "parameters, state, execution or content", "execution"},
        {"backend", "gpu", "driver or cpu", "driver"},
        {"content_budget_mib", "-1", "a number", "256"},
        {"content_when_full", "drop", "wait or skip", "wait"},
        {"guard", "on", "off or references", "off"},
        {"vuid_names", "retired", "current or listed", "current"},
        {"spec_text", "brief", "full, short or none", "full"},
        {"report_flags", "error,warnings", "error, warn, info", "error,warn"},
        {"debug_action", "VK_DBG_LAYER_ACTION_PANIC", "default, ignore, callback, log, break, fail",
         "default"},
        {"log_format", "xml", "text or json", "text"},
        {"call_sites", "true", "off, frames or full", "off"},
        {"hazards", "some", "true or false", "false"},
        {"record_builds", "all", "true or false", "false"},
        {"duplicate_message_limit", "ten", "a number", "10"},
        {"duplicate_message_limit", "-1", "a number", "10"},
        {"duplicate_message_limit", "4294967296", "a number", "10"},
        {"duplicate_message_limit", "99999999999999999999999", "a number", "10"},
        {"duplicate_message_limit", "3x", "a number", "10"},
        {"enable_message_limit", "perhaps", "true or false", "true"},
        {"hang_seconds", "-1", "a number of seconds", "10"},
        {"crash_report", "perhaps", "true or false", "false"},
    };
    for (size_t i = 0; i < LENGTH(cases); i++) {
        char line[256], key[128];
        snprintf(line, sizeof(line), "assay_validation.%s = %s\n", cases[i].key, cases[i].value);
        snprintf(key, sizeof(key), "assay_validation.%s:", cases[i].key);
        surrounding_clear(line);
        struct settings settings = settings_read(NULL);
        assert_default_settings(&settings);
        ASSERT_WARNED(key, cases[i].value, cases[i].takes, cases[i].used);
    }
}

TEST_OPENED(test_debug_actions, surrounding_set_up)
{
    static const struct {
        const char *value;
        uint32_t action;
    } cases[] = {
        {"default", DEBUG_ACTION_DEFAULT},
        {"VK_DBG_LAYER_ACTION_DEFAULT", DEBUG_ACTION_DEFAULT},
        {"VK_DBG_LAYER_ACTION_IGNORE", DEBUG_ACTION_IGNORE},
        {"ignore,log", DEBUG_ACTION_LOG},
        {"VK_DBG_LAYER_ACTION_CALLBACK,VK_DBG_LAYER_ACTION_LOG_MSG",
         DEBUG_ACTION_CALLBACK | DEBUG_ACTION_LOG},
        {"callback", DEBUG_ACTION_CALLBACK},
        {"VK_DBG_LAYER_ACTION_BREAK", DEBUG_ACTION_BREAK | DEBUG_ACTION_DEFAULT},
        {"break,log", DEBUG_ACTION_BREAK | DEBUG_ACTION_LOG},
    };
    for (size_t i = 0; i < LENGTH(cases); i++) {
        setenv("VK_ASSAY_VALIDATION_DEBUG_ACTION", cases[i].value, 1);
        struct settings settings = settings_read(NULL);
        assert_int_equal(settings.debug_action, cases[i].action);
        assert_int_equal(warned.count, 0);
    }
}

/* The action sends messages to a debugger on Windows. */
TEST_OPENED(test_debug_output_has_no_effect, surrounding_set_up)
{
    setenv("VK_ASSAY_VALIDATION_DEBUG_ACTION",
           "VK_DBG_LAYER_ACTION_LOG_MSG,VK_DBG_LAYER_ACTION_DEBUG_OUTPUT", 1);
    struct settings settings = settings_read(NULL);
    assert_int_equal(settings.debug_action, DEBUG_ACTION_LOG);
    ASSERT_WARNED("assay_validation.debug_action", "VK_DBG_LAYER_ACTION_DEBUG_OUTPUT", "Windows");
    /* Alone, it must not silence the layer. */
    environment_set("DEBUG_ACTION=VK_DBG_LAYER_ACTION_DEBUG_OUTPUT");
    settings = settings_read(NULL);
    assert_int_equal(settings.debug_action, DEBUG_ACTION_DEFAULT);
    assert_int_equal(warned.count, 1);
}

/* A log file that nothing writes looks as if there were no findings. */
TEST_OPENED(test_a_log_file_that_no_action_writes, surrounding_set_up)
{
    static const struct {
        const char *action;
        unsigned warnings;
    } cases[] = {{"callback", 1}, {"callback,fail", 1}, {"ignore", 1}, {"default", 0},
                 {"log", 0},      {"break", 0},         {"fail", 0}};
    environment_set("LOG_FILENAME=assay.log");
    for (size_t i = 0; i < LENGTH(cases); i++) {
        setenv("VK_ASSAY_VALIDATION_DEBUG_ACTION", cases[i].action, 1);
        settings_read(NULL);
        assert_int_equal(warned.count, cases[i].warnings);
        if (cases[i].warnings)
            ASSERT_WARNED("assay_validation.log_filename", "\"assay.log\"", "debug_action");
    }
}

/* Journals begin at level execution, and only lines of JSON have a schema. */
TEST_OPENED(test_record_builds_that_nothing_records, surrounding_set_up)
{
    static const struct {
        const char *level, *format, *action;
        bool is_on;
    } cases[] = {
        {"execution", "json", "default", true}, {"content", "json", "log", true},
        {"state", "json", "default", false},    {"parameters", "json", "default", false},
        {"content", "text", "default", false},  {"execution", "json", "callback", false},
    };
    environment_set("RECORD_BUILDS=true");
    for (size_t i = 0; i < LENGTH(cases); i++) {
        setenv("VK_ASSAY_VALIDATION_LEVEL", cases[i].level, 1);
        setenv("VK_ASSAY_VALIDATION_LOG_FORMAT", cases[i].format, 1);
        setenv("VK_ASSAY_VALIDATION_DEBUG_ACTION", cases[i].action, 1);
        struct settings settings = settings_read(NULL);
        assert_int_equal(settings.record_builds, cases[i].is_on);
        assert_int_equal(warned.count, !cases[i].is_on);
        if (!cases[i].is_on)
            ASSERT_WARNED("assay_validation.record_builds needs level", "log_format = json",
                          "No builds are recorded");
    }
}

TEST_OPENED(test_flags_of_the_khronos_layer_are_accepted, surrounding_set_up)
{
    environment_set("REPORT_FLAGS=error,perf,verbose,debug");
    struct settings settings = settings_read(NULL);
    assert_int_equal(settings.report_flags, REPORT_ERROR);
    assert_int_equal(warned.count, 0);
}

/* ---- message_id_filter */

TEST_OPENED(test_filter_lists, surrounding_set_up)
{
    setenv("VK_ASSAY_VALIDATION_MESSAGE_ID_FILTER", " " SENT_ID " , 12258,", 1);
    struct settings settings = settings_read(NULL);
    assert_int_equal(warned.count, 0);
    assert_int_equal(settings_muted(&settings), 3);
    assert_true(settings.muted[SENT_VUID]);
    assert_true(settings.muted[VUID_vkCmdBuildAccelerationStructuresKHR_pInfos_12258]);
}

/* The utility library splits a text without a comma at its colons; names in C++ have some, too. */
TEST_OPENED(test_separators, surrounding_set_up)
{
    static const struct {
        const char *value;
        unsigned muted, narrow;
        const char *glob;
    } filters[] = {
        {SENT_ID "@scene::rocks", 0, 1, "scene::rocks"},
        {SENT_ID "@a:b, 12258", 2, 1, "a:b"},
        {SENT_ID ":12258", 3, 0, NULL}, /* a list, as elsewhere in the environment */
        {SENT_ID "@scene", 0, 1, "scene"},
    };
    static const char *const names[] = {"a,b.log", "a:b.log", "a:b,c:d.log", "a.log"};
    for (size_t i = 0; i < 2 * LENGTH(filters); i++) {
        char line[256];
        snprintf(line, sizeof(line), "assay_validation.message_id_filter = %s\n",
                 filters[i / 2].value);
        surrounding_clear(i % 2 ? line : NULL);
        if (i % 2 == 0)
            setenv("VK_ASSAY_VALIDATION_MESSAGE_ID_FILTER", filters[i / 2].value, 1);
        struct settings settings = settings_read(NULL);
        assert_int_equal(warned.count, 0);
        assert_int_equal(settings_muted(&settings), filters[i / 2].muted);
        assert_int_equal(settings.narrow_filters != NULL, filters[i / 2].narrow);
        if (filters[i / 2].narrow)
            assert_string_equal(settings.narrow_filters->glob, filters[i / 2].glob);
    }
    for (size_t i = 0; i < LENGTH(names); i++) {
        surrounding_clear(NULL);
        setenv("VK_ASSAY_VALIDATION_LOG_FILENAME", names[i], 1);
        assert_string_equal(settings_read(NULL).log_filename, names[i]);
    }
}

TEST_OPENED(test_filter_that_names_nothing, surrounding_set_up)
{
    static const char *const entries[] = {"VUID-vkCmdDraw-None-02699",
                                          "3710",
                                          "99999",
                                          "VUID-vkCmdDraw-None-02699@scene*",
                                          "12258@",
                                          "@scene*",
                                          "@"};
    for (size_t i = 0; i < LENGTH(entries); i++) {
        char filter[128];
        snprintf(filter, sizeof(filter), "%s,%s", entries[i], SENT_ID);
        setenv("VK_ASSAY_VALIDATION_MESSAGE_ID_FILTER", filter, 1);
        struct settings settings = settings_read(NULL);
        assert_int_equal(settings_muted(&settings), 1);
        assert_true(settings.muted[SENT_VUID]);
        ASSERT_WARNED("assay_validation.message_id_filter:", entries[i], "ignored");
    }
}

/* ---- keys that nobody reads */

TEST_OPENED(test_unknown_keys, surrounding_set_up)
{
    environment_set("LEVLE=content");
    struct settings settings = settings_read(NULL);
    assert_default_settings(&settings);
    ASSERT_WARNED("VK_ASSAY_VALIDATION_LEVLE\" is not a setting", "level", "message_id_filter");

    surrounding_clear("assay_validation.report_flag = error\n");
    settings = settings_read(NULL);
    assert_default_settings(&settings);
    ASSERT_WARNED("assay_validation.report_flag\"", " is not a setting", "report_flags");

    surrounding_clear("Assay_Validation.level = content\n");
    settings = settings_read(NULL);
    assert_default_settings(&settings);
    ASSERT_WARNED("Assay_Validation.level\"", " is not a setting");

    surrounding_clear(NULL);
    VkBool32 on = VK_TRUE;
    const VkLayerSettingEXT entry =
        setting_given("validate_sync", VK_LAYER_SETTING_TYPE_BOOL32_EXT, &on);
    const VkLayerSettingsCreateInfoEXT info = settings_given(&entry, 1);
    settings = settings_read(&info);
    assert_default_settings(&settings);
    ASSERT_WARNED("assay_validation.validate_sync\" is not a setting");
}

/* The library and the search for unknown keys have to find the same file. */
static void assert_file_is_read(const char *path)
{
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    fputs("assay_validation.level = state\nassay_validation.levle = state\n", file);
    fclose(file);
    struct settings settings = settings_read(NULL);
    assert_int_equal(settings.level, LEVEL_STATE);
    assert_has(warned.lines[warned.count - 1], "\"assay_validation.levle\" in ");
    remove(path);
}

TEST_OPENED(test_places_of_the_file, surrounding_set_up)
{
    char folder[256];
    snprintf(folder, sizeof(folder), "%s/.local", getenv("HOME"));
    mkdir(".local", 0700);
    setenv("VK_LAYER_SETTINGS_PATH", "/nonexistent/place", 1);
    assert_file_is_read("vk_layer_settings.txt");
    setenv("VK_LAYER_SETTINGS_PATH", folder, 1);
    assert_file_is_read(".local/vk_layer_settings.txt");
    setenv("VK_LAYER_SETTINGS_PATH", ".local/mine.txt", 1);
    assert_file_is_read(".local/mine.txt");

    mkdir(".local/share", 0700);
    mkdir(".local/share/vulkan", 0700);
    mkdir(".local/share/vulkan/settings.d", 0700);
    assert_file_is_read(".local/share/vulkan/settings.d/vk_layer_settings.txt");
    mkdir(".local/vulkan", 0700);
    mkdir(".local/vulkan/settings.d", 0700);
    setenv("XDG_DATA_HOME", folder, 1);
    assert_file_is_read(".local/vulkan/settings.d/vk_layer_settings.txt");
}
