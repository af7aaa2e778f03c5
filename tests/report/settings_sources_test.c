/* SPDX-License-Identifier: Apache-2.0 */
/* Where settings come from: the members that an application fills in, and the places of files.
 * settings_test.c has which source counts. */
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

#ifndef _WIN32 /* where the paths differ */
#define STATE "assay_validation.level = state\n"

static void make_folders(const char *path)
{
    char command[128];
    snprintf(command, sizeof(command), "mkdir -p %s", path);
    assert_int_equal(system(command), 0);
}

/* The library and the search for unknown keys have to find the same file. */
static void assert_file_is_read(const char *path)
{
    file_fill(path, STATE "assay_validation.levle = state\n");
    struct settings settings = settings_read(NULL);
    assert_int_equal(settings.level, LEVEL_STATE);
    assert_has(warned.lines[warned.count - 1], "\"assay_validation.levle\" in ");
    remove(path);
}

TEST_OPENED(places_of_the_file, surrounding_set_up)
{
    char folder[256];
    snprintf(folder, sizeof(folder), "%s/.local", getenv("HOME"));
    make_folders(".local");
    setenv("VK_LAYER_SETTINGS_PATH", "/nonexistent/place", 1);
    assert_file_is_read("vk_layer_settings.txt");
    setenv("VK_LAYER_SETTINGS_PATH", folder, 1);
    assert_file_is_read(".local/vk_layer_settings.txt");
    setenv("VK_LAYER_SETTINGS_PATH", ".local/mine.txt", 1);
    assert_file_is_read(".local/mine.txt");

    make_folders(".local/share/vulkan/settings.d");
    assert_file_is_read(".local/share/vulkan/settings.d/vk_layer_settings.txt");
    make_folders(".local/vulkan/settings.d");
    setenv("XDG_DATA_HOME", folder, 1);
    assert_file_is_read(".local/vulkan/settings.d/vk_layer_settings.txt");
}

TEST_OPENED(a_path_to_a_folder, surrounding_set_up)
{
    make_folders("folder");
    setenv("VK_LAYER_SETTINGS_PATH", "folder", 1);
    settings_read(NULL);
    assert_warned("VK_LAYER_SETTINGS_PATH...\"folder\"...has no vk_layer_settings.txt");

    file_fill("folder/vk_layer_settings.txt", STATE);
    struct settings settings = settings_read(NULL);
    assert_int_equal(settings.level, LEVEL_STATE);
    assert_int_equal(warned.count, 0);
    remove("folder/vk_layer_settings.txt");
    rmdir("folder");
}

TEST_OPENED(a_path_that_comes_second, surrounding_set_up)
{
    make_folders(".local/share/vulkan/settings.d");
    file_fill(".local/share/vulkan/settings.d/vk_layer_settings.txt", STATE);
    file_fill("mine.txt", STATE);
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
