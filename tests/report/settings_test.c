/* SPDX-License-Identifier: Apache-2.0 */
/* Tests of the settings: where they come from. */
#include "reading.h"

TEST(test_defaults)
{
    struct settings settings = settings_of_file(NULL);
    assert_default_settings(&settings);
}

/* ---- sources */

TEST_OPENED(test_environment, surrounding_set_up)
{
    environment_set("LEVEL=Parameters BACKEND=driver VUID_NAMES=listed");
    setenv("VK_ASSAY_VALIDATION_REPORT_FLAGS", "warn, info", 1);
    environment_set("DEBUG_ACTION=log LOG_FILENAME=/tmp/12:30:run.txt DUPLICATE_MESSAGE_LIMIT=3");
    setenv("VK_ASSAY_VALIDATION_MESSAGE_ID_FILTER", SENT_ID, 1);
    struct settings settings = settings_read(NULL);
    assert_int_equal(settings.level, LEVEL_PARAMETERS);
    assert_int_equal(settings.vuid_names, VUID_NAMES_LISTED);
    assert_int_equal(settings.report_flags, REPORT_WARNING | REPORT_INFO);
    assert_int_equal(settings.debug_action, DEBUG_ACTION_LOG);
    assert_string_equal(settings.log_filename, "/tmp/12:30:run.txt");
    assert_int_equal(settings.duplicate_message_limit, 3);
    assert_int_equal(settings_muted(&settings), 1);
    assert_true(settings.muted[SENT_VUID]);
    assert_int_equal(warned.count, 0);
}

TEST_OPENED(test_file, surrounding_set_up)
{
    struct settings settings = settings_of_file(
        "# a comment with assay_validation.nothing = 1\n"
        "khronos_validation.levle = 7\n"
        "  assay_validation.level = content # and another\n"
        "assay_validation.log_filename = a,b:c\n"
        "assay_validation.backend =\n"
        "assay_validation.enable_message_limit = FALSE\n");
    assert_int_equal(settings.level, LEVEL_CONTENT);
    assert_string_equal(settings.log_filename, "a,b:c");
    assert_int_equal(settings.duplicate_message_limit, 0);
}

TEST_OPENED(test_content_budget, surrounding_set_up)
{
    struct settings settings = settings_of_file(
        "assay_validation.content_budget_mib = 16\n"
        "assay_validation.content_when_full = skip\n");
    assert_int_equal(settings.content_budget_mib, 16);
    assert_int_equal(settings.content_when_full, CONTENT_SKIP);
}

/* Rays are compared at level content on backend driver; elsewhere one line says why they aren't. */
TEST_OPENED(test_compare_rays, surrounding_set_up)
{
    struct settings settings = settings_of_file(
        "assay_validation.compare_rays = 64\n"
        "assay_validation.level = content\n"
        "assay_validation.message_id_filter = ASSAY-compare-double\n");
    assert_int_equal(settings.compare_rays, 64);
    assert_int_equal(settings_muted(&settings), 0);
    assert_true(settings.muted_others[DIFFERENCE_DOUBLE]);
    assert_false(settings.muted_others[DIFFERENCE_MISSED]);

    surrounding_clear("assay_validation.compare_rays = 64\n");
    settings = settings_read(NULL);
    assert_int_equal(settings.compare_rays, 0);
    ASSERT_WARNED("compare_rays", "level = content", "backend = driver");

    surrounding_clear(
        "assay_validation.compare_rays = 64\n"
        "assay_validation.level = content\n"
        "assay_validation.backend = cpu\n");
    settings = settings_read(NULL);
    assert_int_equal(settings.compare_rays, 0);
    ASSERT_WARNED("compare_rays");

    surrounding_clear("assay_validation.compare_rays = 1000001\n");
    settings = settings_read(NULL);
    ASSERT_WARNED("compare_rays", "1000001", "1000000");
}

TEST_OPENED(test_guard, surrounding_set_up)
{
    struct settings settings = settings_of_file(
        "assay_validation.guard = references\n"
        "assay_validation.level = content\n");
    assert_int_equal(settings.guard, GUARD_REFERENCES);

    static const char *const elsewhere[] = {"assay_validation.level = execution\n",
                                            "assay_validation.level = content\n"
                                            "assay_validation.backend = cpu\n"};
    for (int i = 0; i < 2; i++) {
        char lines[128];
        snprintf(lines, sizeof(lines), "assay_validation.guard = references\n%s", elsewhere[i]);
        surrounding_clear(lines);
        settings = settings_read(NULL);
        assert_int_equal(settings.guard, GUARD_OFF);
        ASSERT_WARNED("guard", "level = content", "backend = driver");
    }
}

TEST_OPENED(test_hazards_need_a_level, surrounding_set_up)
{
    assert_true(settings_of_file("assay_validation.hazards = true\n").hazards);
    surrounding_clear("assay_validation.hazards = true\nassay_validation.level = state\n");
    assert_false(settings_read(NULL).hazards);
    ASSERT_WARNED("hazards", "level = execution", "content");

    surrounding_clear("assay_validation.message_id_filter = SYNC-HAZARD-WRITE-AFTER-READ\n");
    const struct settings muting = settings_read(NULL);
    assert_true(muting.muted_others[other_id_of_hazard(HAZARD_ID_WRITE_AFTER_READ)]);
    assert_false(muting.muted_others[other_id_of_hazard(HAZARD_ID_WRITE_AFTER_WRITE)]);
}

TEST_OPENED(test_instance_extension, surrounding_set_up)
{
    const char *level = "state", *flags[] = {"error", "info"}, *no_text = NULL;
    uint32_t limit = 4;
    VkBool32 off = VK_FALSE;
    VkLayerSettingEXT more[] = {
        text_given("report_flags", flags),
        text_given("level", &level),
    };
    const VkLayerSettingsCreateInfoEXT second = settings_given(more, 2);
    const VkBaseInStructure between = {VK_STRUCTURE_TYPE_APPLICATION_INFO,
                                       (const VkBaseInStructure *)&second};
    VkLayerSettingEXT entries[] = {
        setting_given("duplicate_message_limit", VK_LAYER_SETTING_TYPE_UINT32_EXT, &limit),
        setting_given(NULL, VK_LAYER_SETTING_TYPE_UINT32_EXT, &limit),
        text_given("level", NULL),
        text_given("level", &no_text),
        {NULL, "level", VK_LAYER_SETTING_TYPE_STRING_EXT, 1, &level},
        {"VK_LAYER_KHRONOS_validation", "enable_message_limit", VK_LAYER_SETTING_TYPE_BOOL32_EXT, 1,
         &off},
    };
    VkLayerSettingsCreateInfoEXT first = {VK_STRUCTURE_TYPE_LAYER_SETTINGS_CREATE_INFO_EXT,
                                          &between, 6, entries};
    more[0].valueCount = 2;

    struct settings settings = settings_read(&first);
    assert_int_equal(settings.level, LEVEL_STATE);
    assert_int_equal(settings.report_flags, REPORT_ERROR | REPORT_INFO);
    assert_int_equal(settings.duplicate_message_limit, 4);
    assert_int_equal(warned.count, 0);

    entries[1] = setting_given("enable_message_limit", VK_LAYER_SETTING_TYPE_BOOL32_EXT, &off);
    settings = settings_read(&first);
    assert_int_equal(settings.duplicate_message_limit, 0);

    first.settingCount = 0;
    first.pSettings = NULL;
    first.pNext = NULL;
    settings = settings_read(&first);
    assert_default_settings(&settings);
}

TEST_OPENED(test_precedence, surrounding_set_up)
{
    const char *level = "parameters";
    const VkLayerSettingEXT entry = text_given("level", &level);
    const VkLayerSettingsCreateInfoEXT info = settings_given(&entry, 1);
    struct settings settings = settings_read(&info);
    assert_int_equal(settings.level, LEVEL_PARAMETERS);

    surrounding_clear("assay_validation.level = state\n");
    settings = settings_read(&info);
    assert_int_equal(settings.level, LEVEL_STATE);

    environment_set("LEVEL=content");
    settings = settings_read(&info);
    assert_int_equal(settings.level, LEVEL_CONTENT);
}

/* ---- no memory */

TEST_OPENED(test_without_memory, surrounding_set_up)
{
    environment_set(
        "LEVEL=contents LEVLE=content LOG_FILENAME=log.txt "
        "MESSAGE_ID_FILTER=03710,99999");
    VkBool32 off = VK_FALSE;
    const VkLayerSettingEXT entry =
        setting_given("enable_message_limit", VK_LAYER_SETTING_TYPE_BOOL32_EXT, &off);
    const VkLayerSettingsCreateInfoEXT info = settings_given(&entry, 1);
    settings_read_scarce(&info, 3);
}
