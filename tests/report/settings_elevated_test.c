/* SPDX-License-Identifier: Apache-2.0 */
/* Tests of the settings in a process with elevated privileges: what the application gives counts,
 * and nothing else. getauxval() is wrapped. */
#include <sys/auxv.h>

#include "reading.h"
#include "src/report/settings/source.h"

/* 3 blocks, not yet found out whose. */
bool unit_test_keeps_memory(void)
{
    return true;
}

static bool is_elevated;

unsigned long __real_getauxval(unsigned long type);
unsigned long __wrap_getauxval(unsigned long type);

unsigned long __wrap_getauxval(unsigned long type)
{
    return type == AT_SECURE ? is_elevated : __real_getauxval(type);
}

static void clear(void)
{
    surrounding_clear(NULL);
    is_elevated = true;
}

TEST_OPENED(test_environment_and_file, clear)
{
    surrounding_clear("assay_validation.backend = cpu\nassay_validation.bakcend = cpu\n");
    environment_set("LEVEL=state");
    struct settings settings = settings_read(NULL);
    assert_string_equal(settings_text(&settings), "");
    assert_int_equal(warned.count, 0);

    is_elevated = false; /* the same is read */
    settings = settings_read(NULL);
    assert_int_equal(settings.level, LEVEL_STATE);
    assert_int_equal(settings.backend, BACKEND_CPU);
    assert_int_equal(warned.count, 1);
}

TEST_OPENED(test_what_the_application_gives, clear)
{
    environment_set("LEVEL=content");
    const char *level = "state", *flags[] = {"error", "info"};
    const uint32_t limit = 4;
    VkLayerSettingEXT given[] = {
        text_given("level", &level),
        text_given("report_flags", flags),
        setting_given("duplicate_message_limit", VK_LAYER_SETTING_TYPE_UINT32_EXT, &limit),
        text_given("levle", &level),
    };
    given[1].valueCount = 2;
    const VkLayerSettingsCreateInfoEXT info = settings_given(given, LENGTH(given));
    struct settings settings = settings_read(&info);
    assert_int_equal(settings.level, LEVEL_STATE);
    assert_int_equal(settings.report_flags, REPORT_ERROR | REPORT_INFO);
    assert_int_equal(settings.duplicate_message_limit, 4);
    assert_warned("assay_validation.levle");
}

/* ---- the same text as the utility library's */

static char *read_list(const VkLayerSettingsCreateInfoEXT *info, const char *key, bool elevated)
{
    const VkInstanceCreateInfo create_info = {.pNext = info};
    struct settings_source source;
    char *list;
    is_elevated = elevated;
    assert_int_equal(settings_source_open(&source, &create_info), VK_SUCCESS);
    assert_int_equal(settings_source_list(&source, key, &list), VK_SUCCESS);
    settings_source_close(&source);
    return list;
}

static void assert_same_list(const VkLayerSettingEXT *settings, uint32_t count,
                             const char *expected)
{
    const VkLayerSettingsCreateInfoEXT info = settings_given(settings, count);
    char *plain = read_list(&info, "key", false), *elevated = read_list(&info, "key", true);
    if (expected) {
        assert_string_equal(plain, expected);
        assert_string_equal(elevated, expected);
    } else {
        assert_null(plain);
        assert_null(elevated);
    }
    free(plain);
    free(elevated);
}

TEST_OPENED(test_types, clear)
{
    static const VkBool32 truths[] = {VK_TRUE, VK_FALSE};
    static const int32_t signed32[] = {INT32_MIN, 7};
    static const int64_t signed64[] = {INT64_MIN, 7};
    static const uint32_t unsigned32[] = {UINT32_MAX, 7};
    static const uint64_t unsigned64[] = {UINT64_MAX, 7};
    static const float floats[] = {1.5f, -2.25f};
    static const double doubles[] = {1.5, -2.25};
    static const char *const texts[] = {"one", "two, three"};
    static const struct {
        VkLayerSettingTypeEXT type;
        const void *values;
        const char *text;
    } cases[] = {
        {VK_LAYER_SETTING_TYPE_BOOL32_EXT, truths, "true,false"},
        {VK_LAYER_SETTING_TYPE_INT32_EXT, signed32, "-2147483648,7"},
        {VK_LAYER_SETTING_TYPE_INT64_EXT, signed64, "-9223372036854775808,7"},
        {VK_LAYER_SETTING_TYPE_UINT32_EXT, unsigned32, "4294967295,7"},
        {VK_LAYER_SETTING_TYPE_UINT64_EXT, unsigned64, "18446744073709551615,7"},
        {VK_LAYER_SETTING_TYPE_FLOAT32_EXT, floats, "1.500000,-2.250000"},
        {VK_LAYER_SETTING_TYPE_FLOAT64_EXT, doubles, "1.500000,-2.250000"},
        {VK_LAYER_SETTING_TYPE_STRING_EXT, texts, "one,two, three"},
        {(VkLayerSettingTypeEXT)77, unsigned64, NULL},
    };
    for (size_t i = 0; i < LENGTH(cases); i++) {
        VkLayerSettingEXT setting = setting_given("key", cases[i].type, cases[i].values);
        setting.valueCount = 2;
        assert_same_list(&setting, 1, cases[i].text);
        setting.valueCount = 0;
        assert_same_list(&setting, 1, NULL);
    }
}

TEST_OPENED(test_a_key_twice, clear)
{
    const char *const first = "first", *const second = "second";
    const VkLayerSettingEXT settings[] = {
        text_given("other", &second),
        text_given("key", &first),
        text_given("key", &second),
    };
    assert_same_list(settings, LENGTH(settings), "first");
}

/* ---- the log */

TEST_OPENED(test_log_file, clear)
{
    const char *name = "assay.log";
    const VkLayerSettingEXT setting = text_given("log_filename", &name);
    const VkLayerSettingsCreateInfoEXT info = settings_given(&setting, 1);
    capture_begin(STDERR_FILENO);
    struct reporter *reporter = reporter_of(&info);
    send_one(reporter);
    const char *text = capture_end();
    assert_has(text, "assay_validation.log_filename: \"assay.log\"");
    assert_has(text, "elevated privileges");
    assert_has(text, SENT_ID);
    assert_int_equal(access(name, F_OK), -1);
    reporter_destroy(reporter);

    is_elevated = false;
    reporter = reporter_of(&info);
    assert_int_equal(access(name, F_OK), 0);
    reporter_destroy(reporter);
    unlink(name);
}

/* ---- no memory */

TEST_OPENED(test_without_memory, clear)
{
    const char *level = "contents";
    const VkLayerSettingEXT setting = text_given("level", &level);
    const VkLayerSettingsCreateInfoEXT info = settings_given(&setting, 1);
    settings_read_scarce(&info, 1);
}
