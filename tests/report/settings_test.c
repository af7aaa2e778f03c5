/* SPDX-License-Identifier: Apache-2.0 */
/* Tests of the settings: where they come from, what they take, what is said of the rest. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include <cmocka.h>

#include "hearing.h"
#include "scarce_memory.h"

enum { LINES = 12 };

static struct {
    unsigned count;
    char lines[LINES][1024];
} warned;

static void warn(void *context, const char *line)
{
    assert_ptr_equal(context, &warned);
    assert_true(warned.count < LINES);
    snprintf(warned.lines[warned.count++], sizeof(warned.lines[0]), "%s", line);
}

static VkResult try_load(const void *chain, struct settings *settings)
{
    const VkInstanceCreateInfo create_info = {.pNext = chain};
    warned.count = 0;
    return settings_load(&create_info, warn, &warned, settings);
}

static struct settings load(const void *chain)
{
    struct settings settings;
    assert_int_equal(try_load(chain, &settings), VK_SUCCESS);
    return settings;
}

static unsigned muted_count(const struct settings *settings)
{
    unsigned count = 0;
    for (unsigned i = 0; i < VUID_COUNT; i++)
        count += settings->muted[i];
    return count;
}

static void assert_defaults(const struct settings *settings)
{
    assert_int_equal(settings->level, LEVEL_EXECUTION);
    assert_int_equal(settings->backend, BACKEND_DRIVER);
    assert_int_equal(settings->vuid_names, VUID_NAMES_CURRENT);
    assert_int_equal(settings->report_flags, REPORT_ERROR | REPORT_WARNING);
    assert_int_equal(settings->debug_action, DEBUG_ACTION_DEFAULT);
    assert_int_equal(settings->duplicate_message_limit, 10);
    assert_null(settings->log_filename);
    assert_int_equal(settings->compare_rays, 0);
    assert_int_equal(muted_count(settings), 0);
}

/* One line was said, and it has all these words; NULL ends them. */
static void assert_warned(const char *const *words)
{
    assert_int_equal(warned.count, 1);
    assert_null(strchr(warned.lines[0], '\n'));
    for (; *words; words++)
        if (!strstr(warned.lines[0], *words))
            fail_msg("\"%s\" is not in: %s", *words, warned.lines[0]);
}

#define ASSERT_WARNED(...) assert_warned((const char *const[]){__VA_ARGS__, NULL})

static int clear(void **state)
{
    (void)state;
    surrounding_clear(NULL);
    return 0;
}

static void test_defaults(void **state)
{
    (void)state;
    struct settings settings = load(NULL);
    assert_defaults(&settings);
    assert_int_equal(warned.count, 0);
    settings_release(&settings);
}

/* ---- sources */

static void test_environment(void **state)
{
    (void)state;
    setenv("VK_ASSAY_VALIDATION_LEVEL", "Parameters", 1);
    setenv("VK_ASSAY_VALIDATION_BACKEND", "driver", 1);
    setenv("VK_ASSAY_VALIDATION_VUID_NAMES", "listed", 1);
    setenv("VK_ASSAY_VALIDATION_REPORT_FLAGS", "warn, info", 1);
    setenv("VK_ASSAY_VALIDATION_DEBUG_ACTION", "log", 1);
    setenv("VK_ASSAY_VALIDATION_LOG_FILENAME", "/tmp/12:30:run.txt", 1);
    setenv("VK_ASSAY_VALIDATION_DUPLICATE_MESSAGE_LIMIT", "3", 1);
    setenv("VK_ASSAY_VALIDATION_MESSAGE_ID_FILTER", SENT_ID, 1);
    struct settings settings = load(NULL);
    assert_int_equal(settings.level, LEVEL_PARAMETERS);
    assert_int_equal(settings.vuid_names, VUID_NAMES_LISTED);
    assert_int_equal(settings.report_flags, REPORT_WARNING | REPORT_INFO);
    assert_int_equal(settings.debug_action, DEBUG_ACTION_LOG);
    assert_string_equal(settings.log_filename, "/tmp/12:30:run.txt");
    assert_int_equal(settings.duplicate_message_limit, 3);
    assert_int_equal(muted_count(&settings), 1);
    assert_true(settings.muted[SENT_VUID]);
    assert_int_equal(warned.count, 0);
    settings_release(&settings);
}

static void test_file(void **state)
{
    (void)state;
    surrounding_clear(
        "# a comment with assay_validation.nothing = 1\n"
        "khronos_validation.levle = 7\n"
        "  assay_validation.level = content # and another\n"
        "assay_validation.log_filename = a,b:c\n"
        "assay_validation.backend =\n"
        "assay_validation.enable_message_limit = FALSE\n");
    struct settings settings = load(NULL);
    assert_int_equal(settings.level, LEVEL_CONTENT);
    assert_string_equal(settings.log_filename, "a,b:c");
    assert_int_equal(settings.duplicate_message_limit, 0);
    assert_int_equal(warned.count, 0);
    settings_release(&settings);
}

/* Rays are compared at level content on backend driver; elsewhere one line says why they aren't. */
static void test_compare_rays(void **state)
{
    (void)state;
    surrounding_clear(
        "assay_validation.compare_rays = 64\n"
        "assay_validation.level = content\n"
        "assay_validation.message_id_filter = ASSAY-compare-double\n");
    struct settings settings = load(NULL);
    assert_int_equal(settings.compare_rays, 64);
    assert_int_equal(muted_count(&settings), 0);
    assert_true(settings.muted_differences[DIFFERENCE_DOUBLE]);
    assert_false(settings.muted_differences[DIFFERENCE_MISSED]);
    assert_int_equal(warned.count, 0);
    settings_release(&settings);

    surrounding_clear("assay_validation.compare_rays = 64\n");
    settings = load(NULL);
    assert_int_equal(settings.compare_rays, 0);
    ASSERT_WARNED("compare_rays", "level = content", "backend = driver");
    settings_release(&settings);

    surrounding_clear(
        "assay_validation.compare_rays = 64\n"
        "assay_validation.level = content\n"
        "assay_validation.backend = cpu\n");
    settings = load(NULL);
    assert_int_equal(settings.compare_rays, 0);
    ASSERT_WARNED("compare_rays");
    settings_release(&settings);

    surrounding_clear("assay_validation.compare_rays = 1000001\n");
    settings = load(NULL);
    ASSERT_WARNED("compare_rays", "1000001", "1000000");
    settings_release(&settings);
}

static VkLayerSettingEXT given(const char *key, VkLayerSettingTypeEXT type, const void *values)
{
    return (VkLayerSettingEXT){"VK_LAYER_ASSAY_validation", key, type, 1, values};
}

static void test_instance_extension(void **state)
{
    (void)state;
    const char *level = "state", *flags[] = {"error", "info"}, *no_text = NULL;
    uint32_t limit = 4;
    VkBool32 off = VK_FALSE;
    VkLayerSettingEXT more[] = {
        given("report_flags", VK_LAYER_SETTING_TYPE_STRING_EXT, flags),
        given("level", VK_LAYER_SETTING_TYPE_STRING_EXT, &level),
    };
    const VkLayerSettingsCreateInfoEXT second = {VK_STRUCTURE_TYPE_LAYER_SETTINGS_CREATE_INFO_EXT,
                                                 NULL, 2, more};
    const VkBaseInStructure between = {VK_STRUCTURE_TYPE_APPLICATION_INFO,
                                       (const VkBaseInStructure *)&second};
    VkLayerSettingEXT entries[] = {
        given("duplicate_message_limit", VK_LAYER_SETTING_TYPE_UINT32_EXT, &limit),
        given(NULL, VK_LAYER_SETTING_TYPE_UINT32_EXT, &limit),
        given("level", VK_LAYER_SETTING_TYPE_STRING_EXT, NULL),
        given("level", VK_LAYER_SETTING_TYPE_STRING_EXT, &no_text),
        {NULL, "level", VK_LAYER_SETTING_TYPE_STRING_EXT, 1, &level},
        {"VK_LAYER_KHRONOS_validation", "enable_message_limit", VK_LAYER_SETTING_TYPE_BOOL32_EXT, 1,
         &off},
    };
    VkLayerSettingsCreateInfoEXT first = {VK_STRUCTURE_TYPE_LAYER_SETTINGS_CREATE_INFO_EXT,
                                          &between, 6, entries};
    more[0].valueCount = 2;

    struct settings settings = load(&first);
    assert_int_equal(settings.level, LEVEL_STATE);
    assert_int_equal(settings.report_flags, REPORT_ERROR | REPORT_INFO);
    assert_int_equal(settings.duplicate_message_limit, 4);
    assert_int_equal(warned.count, 0);
    settings_release(&settings);

    entries[1] = given("enable_message_limit", VK_LAYER_SETTING_TYPE_BOOL32_EXT, &off);
    settings = load(&first);
    assert_int_equal(settings.duplicate_message_limit, 0);
    settings_release(&settings);

    first.settingCount = 0;
    first.pSettings = NULL;
    first.pNext = NULL;
    settings = load(&first);
    assert_defaults(&settings);
    settings_release(&settings);
}

static void test_precedence(void **state)
{
    (void)state;
    const char *level = "parameters";
    const VkLayerSettingEXT entry = given("level", VK_LAYER_SETTING_TYPE_STRING_EXT, &level);
    const VkLayerSettingsCreateInfoEXT info = {VK_STRUCTURE_TYPE_LAYER_SETTINGS_CREATE_INFO_EXT,
                                               NULL, 1, &entry};
    struct settings settings = load(&info);
    assert_int_equal(settings.level, LEVEL_PARAMETERS);
    settings_release(&settings);

    surrounding_clear("assay_validation.level = state\n");
    settings = load(&info);
    assert_int_equal(settings.level, LEVEL_STATE);
    settings_release(&settings);

    setenv("VK_ASSAY_VALIDATION_LEVEL", "content", 1);
    settings = load(&info);
    assert_int_equal(settings.level, LEVEL_CONTENT);
    settings_release(&settings);
}

/* ---- values */

static void test_values_that_are_not_understood(void **state)
{
    (void)state;
    static const struct {
        const char *key, *value, *takes, *used;
    } cases[] = {
        {"level", "contents", "parameters, state, execution or content", "execution"},
        {"level", "state,content", "parameters, state, execution or content", "execution"},
        {"backend", "gpu", "driver or cpu", "driver"},
        {"vuid_names", "retired", "current or listed", "current"},
        {"report_flags", "error,warnings", "error, warn, info", "error,warn"},
        {"debug_action", "VK_DBG_LAYER_ACTION_PANIC", "default, ignore, callback, log, break",
         "default"},
        {"duplicate_message_limit", "ten", "a number", "10"},
        {"duplicate_message_limit", "-1", "a number", "10"},
        {"duplicate_message_limit", "4294967296", "a number", "10"},
        {"duplicate_message_limit", "99999999999999999999999", "a number", "10"},
        {"duplicate_message_limit", "3x", "a number", "10"},
        {"enable_message_limit", "perhaps", "true or false", "true"},
    };
    for (size_t i = 0; i < sizeof(cases) / sizeof(cases[0]); i++) {
        char line[256], key[128];
        snprintf(line, sizeof(line), "assay_validation.%s = %s\n", cases[i].key, cases[i].value);
        snprintf(key, sizeof(key), "assay_validation.%s:", cases[i].key);
        surrounding_clear(line);
        struct settings settings = load(NULL);
        assert_defaults(&settings);
        ASSERT_WARNED(key, cases[i].value, cases[i].takes, cases[i].used);
        settings_release(&settings);
    }
}

static void test_debug_actions(void **state)
{
    (void)state;
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
    for (size_t i = 0; i < sizeof(cases) / sizeof(cases[0]); i++) {
        setenv("VK_ASSAY_VALIDATION_DEBUG_ACTION", cases[i].value, 1);
        struct settings settings = load(NULL);
        assert_int_equal(settings.debug_action, cases[i].action);
        assert_int_equal(warned.count, 0);
        settings_release(&settings);
    }
}

static void test_flags_of_the_khronos_layer_are_accepted(void **state)
{
    (void)state;
    setenv("VK_ASSAY_VALIDATION_REPORT_FLAGS", "error,perf,verbose,debug", 1);
    struct settings settings = load(NULL);
    assert_int_equal(settings.report_flags, REPORT_ERROR);
    assert_int_equal(warned.count, 0);
    settings_release(&settings);
}

/* ---- message_id_filter */

static void test_filter_lists(void **state)
{
    (void)state;
    setenv("VK_ASSAY_VALIDATION_MESSAGE_ID_FILTER", " " SENT_ID " , 12258,", 1);
    struct settings settings = load(NULL);
    assert_int_equal(warned.count, 0);
    assert_int_equal(muted_count(&settings), 3);
    assert_true(settings.muted[SENT_VUID]);
    assert_true(settings.muted[VUID_vkCmdBuildAccelerationStructuresKHR_pInfos_12258]);
    settings_release(&settings);
}

static void test_filter_that_names_nothing(void **state)
{
    (void)state;
    static const char *const entries[] = {"VUID-vkCmdDraw-None-02699", "3710", "99999"};
    for (size_t i = 0; i < sizeof(entries) / sizeof(entries[0]); i++) {
        char filter[128];
        snprintf(filter, sizeof(filter), "%s,%s", entries[i], SENT_ID);
        setenv("VK_ASSAY_VALIDATION_MESSAGE_ID_FILTER", filter, 1);
        struct settings settings = load(NULL);
        assert_int_equal(muted_count(&settings), 1);
        assert_true(settings.muted[SENT_VUID]);
        ASSERT_WARNED("assay_validation.message_id_filter:", entries[i], "ignored");
        settings_release(&settings);
    }
}

/* ---- keys that nobody reads */

static void test_unknown_keys(void **state)
{
    (void)state;
    setenv("VK_ASSAY_VALIDATION_LEVLE", "content", 1);
    struct settings settings = load(NULL);
    assert_defaults(&settings);
    ASSERT_WARNED("VK_ASSAY_VALIDATION_LEVLE is not a setting", "level", "message_id_filter");
    settings_release(&settings);

    surrounding_clear("assay_validation.report_flag = error\n");
    settings = load(NULL);
    assert_defaults(&settings);
    ASSERT_WARNED("assay_validation.report_flag is not a setting", "report_flags");
    settings_release(&settings);

    surrounding_clear("Assay_Validation.level = content\n");
    settings = load(NULL);
    assert_defaults(&settings);
    ASSERT_WARNED("Assay_Validation.level is not a setting");
    settings_release(&settings);

    surrounding_clear(NULL);
    VkBool32 on = VK_TRUE;
    const VkLayerSettingEXT entry = given("validate_sync", VK_LAYER_SETTING_TYPE_BOOL32_EXT, &on);
    const VkLayerSettingsCreateInfoEXT info = {VK_STRUCTURE_TYPE_LAYER_SETTINGS_CREATE_INFO_EXT,
                                               NULL, 1, &entry};
    settings = load(&info);
    assert_defaults(&settings);
    ASSERT_WARNED("assay_validation.validate_sync is not a setting");
    settings_release(&settings);
}

/* The library and the search for unknown keys have to find the same file. */
static void assert_file_is_read(const char *path)
{
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    fputs("assay_validation.level = state\nassay_validation.levle = state\n", file);
    fclose(file);
    struct settings settings = load(NULL);
    assert_int_equal(settings.level, LEVEL_STATE);
    ASSERT_WARNED("assay_validation.levle is not a setting");
    settings_release(&settings);
    remove(path);
}

static void test_places_of_the_file(void **state)
{
    (void)state;
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

/* ---- no memory */

static void test_without_memory(void **state)
{
    (void)state;
    setenv("VK_ASSAY_VALIDATION_LEVEL", "contents", 1);
    setenv("VK_ASSAY_VALIDATION_LEVLE", "content", 1);
    setenv("VK_ASSAY_VALIDATION_LOG_FILENAME", "log.txt", 1);
    setenv("VK_ASSAY_VALIDATION_MESSAGE_ID_FILTER", "03710,99999", 1);
    VkBool32 off = VK_FALSE;
    const VkLayerSettingEXT entry =
        given("enable_message_limit", VK_LAYER_SETTING_TYPE_BOOL32_EXT, &off);
    const VkLayerSettingsCreateInfoEXT info = {VK_STRUCTURE_TYPE_LAYER_SETTINGS_CREATE_INFO_EXT,
                                               NULL, 1, &entry};
    bool failed = true;
    int count;
    for (count = 0; failed; count++) {
        struct settings settings;
        memory_fail_after(count);
        VkResult result = try_load(&info, &settings);
        failed = memory_fail_no_more();
        if (result == VK_SUCCESS) {
            assert_int_equal(warned.count, 3);
            settings_release(&settings);
        } else {
            assert_true(failed);
            assert_int_equal(result, VK_ERROR_OUT_OF_HOST_MEMORY);
        }
    }
    assert_true(count > 2); /* memory did run out */
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(test_defaults, clear),
        cmocka_unit_test_setup(test_environment, clear),
        cmocka_unit_test_setup(test_compare_rays, clear),
        cmocka_unit_test_setup(test_file, clear),
        cmocka_unit_test_setup(test_instance_extension, clear),
        cmocka_unit_test_setup(test_precedence, clear),
        cmocka_unit_test_setup(test_values_that_are_not_understood, clear),
        cmocka_unit_test_setup(test_debug_actions, clear),
        cmocka_unit_test_setup(test_flags_of_the_khronos_layer_are_accepted, clear),
        cmocka_unit_test_setup(test_filter_lists, clear),
        cmocka_unit_test_setup(test_filter_that_names_nothing, clear),
        cmocka_unit_test_setup(test_unknown_keys, clear),
        cmocka_unit_test_setup(test_places_of_the_file, clear),
        cmocka_unit_test_setup(test_without_memory, clear),
    };
    return cmocka_run_group_tests_name("settings", tests, NULL, surrounding_remove);
}
