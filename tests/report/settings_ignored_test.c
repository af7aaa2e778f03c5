/* SPDX-License-Identifier: Apache-2.0 */
/* Tests that what a user writes without effect gets a warning. */
#include <sys/stat.h>

#include "reading.h"

/* ---- names */

TEST_OPENED(test_names_in_the_environment, surrounding_set_up)
{
    static const struct {
        const char *name, *meant;
    } cases[] = {
        {"VK_ASSAY_LEVEL", "VK_ASSAY_VALIDATION_LEVEL"},
        {"VK_LAYER_ASSAY_LEVEL", "VK_ASSAY_VALIDATION_LEVEL"},
        {"VK_LAYER_ASSAY_VALIDATION_LOG_FILENAME", "VK_ASSAY_VALIDATION_LOG_FILENAME"},
        {"vk_assay_validation_backend", "VK_ASSAY_VALIDATION_BACKEND"},
        {"VK_ASSAY_LEVLE", "level, backend,"}, /* all that there are */
    };
    for (size_t i = 0; i < LENGTH(cases); i++) {
        char name[128];
        setenv(cases[i].name, "content", 1);
        struct settings settings = settings_read(NULL);
        unsetenv(cases[i].name);
        assert_default_settings(&settings);
        snprintf(name, sizeof(name), "\"%s\"", cases[i].name);
        ASSERT_WARNED(name, cases[i].meant);
    }
}

TEST_OPENED(test_other_variables_are_left_alone, surrounding_set_up)
{
    static const char *const names[] = {"VK_ASSAY_ENABLE",  "VK_ASSAY_DISABLE", "ASSAY_LEVEL",
                                        "VK_ASSAYER_LEVEL", "VK_LEVELS",        "VK_ASSAY"};
    for (size_t i = 0; i < LENGTH(names); i++) {
        setenv(names[i], "1", 1);
        settings_read(NULL);
        unsetenv(names[i]);
        assert_int_equal(warned.count, 0);
    }
}

TEST_OPENED(test_names_in_the_file, surrounding_set_up)
{
    static const struct {
        const char *line, *named, *meant;
    } cases[] = {
        {"VK_LAYER_ASSAY_validation.level = content", "\"VK_LAYER_ASSAY_validation.level\"",
         "assay_validation.level?"},
        {"assay.level = content", "\"assay.level\"", "assay_validation.level?"},
        {"Assay_Validation.level = content", "\"Assay_Validation.level\"",
         "assay_validation.level?"},
        {"assay_validation.LEVEL = content", "\"assay_validation.LEVEL\"",
         "assay_validation.level?"},
        {"VK_ASSAY_VALIDATION_LEVEL = content", "\"VK_ASSAY_VALIDATION_LEVEL\"",
         "assay_validation.level?"},
        {"VK_LAYER_ASSAY_validation.levle = content", "\"VK_LAYER_ASSAY_validation.levle\"",
         "which has level"},
    };
    for (size_t i = 0; i < LENGTH(cases); i++) {
        char text[256];
        snprintf(text, sizeof(text), "%s\n", cases[i].line);
        surrounding_clear(text);
        struct settings settings = settings_read(NULL);
        assert_default_settings(&settings);
        ASSERT_WARNED(cases[i].named, cases[i].meant, "vk_layer_settings.txt");
    }
}

TEST_OPENED(test_lines_without_an_equals_sign, surrounding_set_up)
{
    surrounding_clear("assay_validation.level content\n");
    struct settings settings = settings_read(NULL);
    assert_default_settings(&settings);
    ASSERT_WARNED("\"assay_validation.level content\"", "\"=\"", "vk_layer_settings.txt");

    surrounding_clear("  VK_LAYER_ASSAY_validation.level: content # a level\n");
    settings_read(NULL);
    ASSERT_WARNED("\"VK_LAYER_ASSAY_validation.level: content\"", "\"=\"");
}

/* The file is for all layers. */
TEST_OPENED(test_other_lines_are_left_alone, surrounding_set_up)
{
    surrounding_clear(
        "# assay_validation.level content\n"
        "\n"
        "   \n"
        "some prose of the user\n"
        "khronos_validation.assay = 1\n"
        "khronos_validation.report_flags error\n"
        "= 7\n");
    settings_read(NULL);
    assert_int_equal(warned.count, 0);
}

TEST_OPENED(test_other_values_of_enable, surrounding_set_up)
{
    setenv("VK_ASSAY_ENABLE", "true", 1);
    settings_read(NULL);
    ASSERT_WARNED("VK_ASSAY_ENABLE", "\"true\"", "only 1 does");
    setenv("VK_ASSAY_ENABLE", "0", 1);
    settings_read(NULL);
    unsetenv("VK_ASSAY_ENABLE");
    assert_int_equal(warned.count, 0);
}

/* ---- VK_LAYER_SETTINGS_PATH */

static void write_file(const char *path)
{
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    fputs("assay_validation.level = state\n", file);
    fclose(file);
}

TEST_OPENED(test_a_path_to_nothing, surrounding_set_up)
{
    setenv("VK_LAYER_SETTINGS_PATH", "/nonexistent/settings.txt", 1);
    settings_read(NULL);
    ASSERT_WARNED("VK_LAYER_SETTINGS_PATH", "\"/nonexistent/settings.txt\"", "does not exist");

    /* The library falls back to the current folder. */
    surrounding_clear("assay_validation.level = state\n");
    setenv("VK_LAYER_SETTINGS_PATH", "/nonexistent/settings.txt", 1);
    struct settings settings = settings_read(NULL);
    assert_int_equal(settings.level, LEVEL_STATE);
    ASSERT_WARNED("VK_LAYER_SETTINGS_PATH", "does not exist", "current folder");
}

TEST_OPENED(test_a_path_to_a_folder, surrounding_set_up)
{
    mkdir("folder", 0700);
    setenv("VK_LAYER_SETTINGS_PATH", "folder", 1);
    settings_read(NULL);
    ASSERT_WARNED("VK_LAYER_SETTINGS_PATH", "\"folder\"", "has no vk_layer_settings.txt");

    write_file("folder/vk_layer_settings.txt");
    struct settings settings = settings_read(NULL);
    assert_int_equal(settings.level, LEVEL_STATE);
    assert_int_equal(warned.count, 0);
    remove("folder/vk_layer_settings.txt");
    rmdir("folder");
}

TEST_OPENED(test_a_path_that_comes_second, surrounding_set_up)
{
    mkdir(".local", 0700);
    mkdir(".local/share", 0700);
    mkdir(".local/share/vulkan", 0700);
    mkdir(".local/share/vulkan/settings.d", 0700);
    write_file(".local/share/vulkan/settings.d/vk_layer_settings.txt");
    write_file("mine.txt");
    setenv("VK_LAYER_SETTINGS_PATH", "mine.txt", 1);
    settings_read(NULL);
    ASSERT_WARNED("VK_LAYER_SETTINGS_PATH", "\"mine.txt\" is not read",
                  "/.local/share/vulkan/settings.d/vk_layer_settings.txt\"");
    remove("mine.txt");
}
