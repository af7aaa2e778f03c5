/* SPDX-License-Identifier: Apache-2.0 */
/* Where settings come from: the application, the environment and files, and which of them counts.
 */
#include <sys/stat.h>

#include "reading.h"

TEST_OPENED(instance_extension, surrounding_set_up)
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
    assert_string_equal(settings_text(&settings), "level=state limit=4 flags=error+info");
    assert_int_equal(warned.count, 0);

    entries[1] = setting_given("enable_message_limit", VK_LAYER_SETTING_TYPE_BOOL32_EXT, &off);
    settings = settings_read(&first);
    assert_int_equal(settings.duplicate_message_limit, 0);

    first.settingCount = 0;
    first.pSettings = NULL;
    first.pNext = NULL;
    settings = settings_read(&first);
    assert_string_equal(settings_text(&settings), "");
}

TEST_OPENED(precedence, surrounding_set_up)
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

/* A key that is given wins over the preset, also if the preset's source comes before the key's. */
TEST_OPENED(preset_and_keys_of_the_application, surrounding_set_up)
{
    const char *preset = "everything", *level = "execution";
    const VkBool32 off = VK_FALSE;
    VkLayerSettingEXT entries[] = {
        text_given("preset", &preset),
        text_given("level", &level),
        setting_given("hazards", VK_LAYER_SETTING_TYPE_BOOL32_EXT, &off),
        text_given("preset", &preset),
    };
    const VkLayerSettingsCreateInfoEXT preset_first = settings_given(entries, 3),
                                       preset_last = settings_given(entries + 1, 3),
                                       only_preset = settings_given(entries, 1),
                                       only_keys = settings_given(entries + 1, 2);
    struct settings settings = settings_read(&preset_first);
    assert_string_equal(settings_text(&settings), "sites=2 hazards=0 advice=1");
    settings = settings_read(&preset_last);
    assert_string_equal(settings_text(&settings), "sites=2 hazards=0 advice=1");

    surrounding_clear("assay_validation.guard = off\n");
    environment_set("ADVICE=false");
    settings = settings_read(&only_preset);
    assert_string_equal(settings_text(&settings), "level=content sites=2");

    surrounding_clear(NULL);
    environment_set("PRESET=ci");
    settings = settings_read(&only_keys);
    assert_string_equal(settings_text(&settings), "limits=1 sites=2 hazards=0 advice=1");

    surrounding_clear("assay_validation.preset = ci\n");
    settings = settings_read(&only_keys);
    assert_string_equal(settings_text(&settings), "limits=1 sites=2 hazards=0 advice=1");
    assert_int_equal(warned.count, 0);
}

TEST_OPENED(several_lines_of_a_key, surrounding_set_up)
{
    const char *level = "parameters";
    const VkLayerSettingEXT entry = text_given("level", &level);
    const VkLayerSettingsCreateInfoEXT info = settings_given(&entry, 1);
    surrounding_clear("assay_validation.level = content\nassay_validation.level = state\n");
    struct settings settings = settings_read(&info);
    assert_int_equal(settings.level, LEVEL_STATE);

    surrounding_clear("assay_validation.level = content\nassay_validation.level =\n");
    settings = settings_read(&info);
    assert_int_equal(settings.level, LEVEL_PARAMETERS);
    assert_int_equal(warned.count, 0);
}

TEST_OPENED(unknown_keys_of_the_application, surrounding_set_up)
{
    const VkBool32 on = VK_TRUE;
    const VkLayerSettingEXT entry =
        setting_given("validate_sync", VK_LAYER_SETTING_TYPE_BOOL32_EXT, &on);
    const VkLayerSettingsCreateInfoEXT info = settings_given(&entry, 1);
    const struct settings settings = settings_read(&info);
    assert_string_equal(settings_text(&settings), "");
    assert_warned("assay_validation.validate_sync\" is not a setting");
}

#ifndef _WIN32 /* where the paths differ */
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

TEST_OPENED(places_of_the_file, surrounding_set_up)
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

static void write_file(const char *path)
{
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    fputs("assay_validation.level = state\n", file);
    fclose(file);
}

TEST_OPENED(a_path_to_a_folder, surrounding_set_up)
{
    mkdir("folder", 0700);
    setenv("VK_LAYER_SETTINGS_PATH", "folder", 1);
    settings_read(NULL);
    assert_warned("VK_LAYER_SETTINGS_PATH...\"folder\"...has no vk_layer_settings.txt");

    write_file("folder/vk_layer_settings.txt");
    struct settings settings = settings_read(NULL);
    assert_int_equal(settings.level, LEVEL_STATE);
    assert_int_equal(warned.count, 0);
    remove("folder/vk_layer_settings.txt");
    rmdir("folder");
}

TEST_OPENED(a_path_that_comes_second, surrounding_set_up)
{
    mkdir(".local", 0700);
    mkdir(".local/share", 0700);
    mkdir(".local/share/vulkan", 0700);
    mkdir(".local/share/vulkan/settings.d", 0700);
    write_file(".local/share/vulkan/settings.d/vk_layer_settings.txt");
    write_file("mine.txt");
    setenv("VK_LAYER_SETTINGS_PATH", "mine.txt", 1);
    settings_read(NULL);
    assert_warned(
        "VK_LAYER_SETTINGS_PATH...\"mine.txt\" is not "
        "read.../.local/share/vulkan/settings.d/vk_layer_settings.txt\"");
    remove("mine.txt");
}
#endif

TEST_OPENED(without_memory, surrounding_set_up)
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

TEST_OPENED(a_preset_without_memory, surrounding_set_up)
{
    environment_set("PRESET=ci LEVEL=state HAZARDS=true");
    settings_read_scarce(NULL, 1);
}
