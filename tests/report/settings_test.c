/* SPDX-License-Identifier: Apache-2.0 */
/* The settings that files, environments and applications give, the places of files, and the
 * warnings about what has no effect. */
#include "reading.h"

#define FILE_LINE(line) "assay_validation." line "\n"
#define JSON FILE_LINE("log_format = json")
#define CONTENT FILE_LINE("level = content")
#define PRESET FILE_LINE("preset = everything")
#define FILTER "MESSAGE_ID_FILTER="
#define NAMED "\" is not a setting"

/* The settings of a vk_layer_settings.txt and an environment: each line of the latter is a
 * KEY=VALUE of the layer's, or a whole VK_NAME=VALUE. They are as settings_text() says. There is
 * one warning, which assert_parts() finds, or none if that is NULL. */
static const struct row {
    const char *test, *file, *environment, *text;
    const char *warning, *application;
} rows[] = {
    {"defaults", NULL, "", ""},
    {"all_of_an_environment", NULL,
     "LEVEL=Parameters\nBACKEND=driver\nVUID_NAMES=listed\nREPORT_FLAGS=warn, info\n"
     "DEBUG_ACTION=log\nLOG_FILENAME=/tmp/12:30:run.txt\nDUPLICATE_MESSAGE_LIMIT=3\n" FILTER
         SENT_ID,
     "level=parameters vuid_names=1 limit=3 flags=warn+info action=log file=/tmp/12:30:run.txt "
     "muted=1 03710"},
    {"a_file_with_comments",
     "# a comment with assay_validation.nothing = 1\n"
     "khronos_validation.levle = 7\n"
     "  assay_validation.level = content # and another\n" FILE_LINE("log_filename = a,b:c")
         FILE_LINE("backend =") FILE_LINE("enable_message_limit = FALSE"),
     "", "level=content limit=0 file=a,b:c"},
    {"content_budget", FILE_LINE("content_budget_mib = 16") FILE_LINE("content_when_full = skip"),
     "", "budget=16 when_full=1"},

    /* ---- presets: a key that is given wins, wherever it and the preset are. What has no effect
     * beside other settings is left out, and only a key that is given brings a warning. */
    {"preset_none", FILE_LINE("preset = none"), "", ""},
    {"preset_everything", NULL, "PRESET=Everything", "level=content guard=1 sites=2 advice=1"},
    {"preset_everything_as_json", JSON, "PRESET=everything",
     "level=content guard=1 json=1 sites=2 advice=1 records=1"},
    {"preset_ci", JSON, "PRESET=ci",
     "level=content limits=1 guard=1 json=1 sites=2 advice=1 records=1"},
    {"preset_of_a_file_and_keys_of_the_environment", PRESET, "LEVEL=execution\nADVICE=false",
     "sites=2"},
    {"preset_of_the_environment_and_keys_of_a_file",
     FILE_LINE("hazards = false") FILE_LINE("call_sites = frames"), "PRESET=ci",
     "level=content limits=1 guard=1 sites=1 hazards=0 advice=1"},
    {"preset_before_a_key", PRESET FILE_LINE("guard = off"), "", "level=content sites=2 advice=1"},
    {"preset_behind_a_key", FILE_LINE("guard = off") PRESET, "", "level=content sites=2 advice=1"},
    {"preset_of_a_file_and_of_the_environment", PRESET, "PRESET=none", ""},
    {"preset_below_execution", PRESET, "LEVEL=state", "level=state sites=2"},
    {"preset_on_backend_cpu", PRESET, "BACKEND=cpu", "level=content backend=1 sites=2 advice=1"},
    {"preset_beside_a_key_without_effect", PRESET, "LEVEL=state\nHAZARDS=true",
     "level=state sites=2", "assay_validation.hazards needs level = execution"},
    {"preset_beside_an_invalid_value", PRESET, "LEVEL=contents",
     "level=content guard=1 sites=2 advice=1",
     "assay_validation.level...\"contents\"...The preset's value, content, is used."},

    /* ---- settings of the application: the file wins over them, and the environment over both */
    {"application", NULL, "", "level=parameters", NULL, "level=parameters"},
    {"application_and_file", FILE_LINE("level = state"), "", "level=state", NULL,
     "level=parameters"},
    {"application_file_and_environment", FILE_LINE("level = state"), "LEVEL=content",
     "level=content", NULL, "level=parameters"},
    {"two_lines_of_a_key", CONTENT FILE_LINE("level = state"), "", "level=state", NULL,
     "level=parameters"},
    {"a_line_without_a_value_behind_another", CONTENT FILE_LINE("level ="), "", "level=parameters",
     NULL, "level=parameters"},
    {"unknown_key_of_the_application", NULL, "", "",
     "assay_validation.validate_sync\" is not a setting", "validate_sync=true"},
    /* A key that is given wins over the preset, also if the preset's source comes before the key's.
     */
    {"preset_of_the_application_before_keys", NULL, "", "sites=2 hazards=0 advice=1", NULL,
     "preset=everything level=execution hazards=false"},
    {"preset_of_the_application_behind_keys", NULL, "", "sites=2 hazards=0 advice=1", NULL,
     "level=execution hazards=false preset=everything"},
    {"preset_of_the_application_alone", FILE_LINE("guard = off"), "ADVICE=false",
     "level=content sites=2", NULL, "preset=everything"},
    {"preset_of_the_environment_and_keys_of_the_application", NULL, "PRESET=ci",
     "limits=1 sites=2 hazards=0 advice=1", NULL, "level=execution hazards=false"},
    {"preset_of_a_file_and_keys_of_the_application", FILE_LINE("preset = ci"), "",
     "limits=1 sites=2 hazards=0 advice=1", NULL, "level=execution hazards=false"},

    /* ---- settings that need others: one line says why they have no effect */
    {"rays", CONTENT FILE_LINE("compare_rays = 64"), FILTER "ASSAY-compare-double",
     "level=content rays=64 muted=ASSAY-compare-double"},
    {"rays_below_content", FILE_LINE("compare_rays = 64"), "", "",
     "compare_rays...level = content...backend = driver"},
    {"rays_on_backend_cpu", CONTENT FILE_LINE("compare_rays = 64"), "BACKEND=cpu",
     "level=content backend=1", "compare_rays"},
    {"too_many_rays", FILE_LINE("compare_rays = 1000001"), "", "",
     "compare_rays...1000001...1000000"},
    {"limits", FILE_LINE("limits = Harsh"), "", "limits=1"},
    {"guard", CONTENT FILE_LINE("guard = references"), "", "level=content guard=1"},
    {"guard_below_content", FILE_LINE("guard = references"), "", "",
     "guard...level = content...backend = driver"},
    {"guard_on_backend_cpu", CONTENT FILE_LINE("guard = references"), "BACKEND=cpu",
     "level=content backend=1", "guard...level = content...backend = driver"},
    {"hazards", NULL, "HAZARDS=true\n" FILTER "SYNC-HAZARD-WRITE-AFTER-READ",
     "muted=SYNC-HAZARD-WRITE-AFTER-READ"},
    {"hazards_below_execution", NULL, "HAZARDS=true\nLEVEL=state", "level=state",
     "hazards...level = execution...content"},
    {"advice", NULL, "ADVICE=true\nADVICE_LIMITS=lines=7, Submissions = 3",
     "advice=1 submissions=3 lines=7"},
    {"advice_below_execution", NULL, "ADVICE=true\nLEVEL=state", "level=state",
     "advice...level = execution...content"},

#ifndef _WIN32 /* whose environment, paths and actions differ */
    {"flags_of_the_khronos_layer", NULL, "REPORT_FLAGS=error,perf,verbose,debug",
     "flags=error+perf"},

    /* Journals begin at level execution, and only lines of JSON have a schema. */
    {"records", JSON, "RECORD_BUILDS=true", "json=1 records=1"},
    {"records_at_content", JSON CONTENT, "RECORD_BUILDS=true\nDEBUG_ACTION=log",
     "level=content json=1 records=1 action=log"},
    {"records_below_execution", JSON, "RECORD_BUILDS=true\nLEVEL=state", "level=state json=1",
     "assay_validation.record_builds needs level...log_format = json...No builds are recorded"},
    {"records_without_journals", JSON, "RECORD_BUILDS=true\nLEVEL=parameters",
     "level=parameters json=1", "assay_validation.record_builds needs level"},
    {"records_as_text", CONTENT, "RECORD_BUILDS=true", "level=content",
     "assay_validation.record_builds needs level"},
    {"records_without_log", JSON, "RECORD_BUILDS=true\nDEBUG_ACTION=callback",
     "json=1 action=callback", "assay_validation.record_builds needs level"},
    /* A log file that nothing writes looks as if there were no findings. */
    {"file_for_callbacks", NULL, "LOG_FILENAME=assay.log\nDEBUG_ACTION=callback",
     "action=callback file=assay.log",
     "assay_validation.log_filename...\"assay.log\"...debug_action"},
    {"file_for_callbacks_that_fail", NULL, "LOG_FILENAME=assay.log\nDEBUG_ACTION=callback,fail",
     "action=callback+fail file=assay.log", "assay_validation.log_filename...\"assay.log\""},
    {"file_for_nothing", NULL, "LOG_FILENAME=assay.log\nDEBUG_ACTION=ignore",
     "action=ignore file=assay.log", "assay_validation.log_filename...\"assay.log\""},
    {"file_for_log", NULL, "LOG_FILENAME=assay.log\nDEBUG_ACTION=log", "action=log file=assay.log"},
    {"file_for_break", NULL, "LOG_FILENAME=assay.log\nDEBUG_ACTION=break",
     "action=break+default file=assay.log"},
    {"file_for_fail", NULL, "LOG_FILENAME=assay.log\nDEBUG_ACTION=fail",
     "action=default+fail file=assay.log"},

    /* ---- debug_action */
    {"action_default", NULL, "DEBUG_ACTION=default", ""},
    {"action_default_of_khronos", NULL, "DEBUG_ACTION=VK_DBG_LAYER_ACTION_DEFAULT", ""},
    {"action_ignore", NULL, "DEBUG_ACTION=VK_DBG_LAYER_ACTION_IGNORE", "action=ignore"},
    {"action_ignore_and_log", NULL, "DEBUG_ACTION=ignore,log", "action=log"},
    {"action_callback_and_log", NULL,
     "DEBUG_ACTION=VK_DBG_LAYER_ACTION_CALLBACK,VK_DBG_LAYER_ACTION_LOG_MSG",
     "action=callback+log"},
    {"action_callback", NULL, "DEBUG_ACTION=callback", "action=callback"},
    {"action_break", NULL, "DEBUG_ACTION=VK_DBG_LAYER_ACTION_BREAK", "action=break+default"},
    {"action_break_and_log", NULL, "DEBUG_ACTION=break,log", "action=log+break"},
    /* The action sends messages to a debugger on Windows. Alone, it must not silence the layer. */
    {"action_of_windows", NULL,
     "DEBUG_ACTION=VK_DBG_LAYER_ACTION_LOG_MSG,VK_DBG_LAYER_ACTION_DEBUG_OUTPUT", "action=log",
     "assay_validation.debug_action...VK_DBG_LAYER_ACTION_DEBUG_OUTPUT...Windows"},
    {"action_of_windows_alone", NULL, "DEBUG_ACTION=VK_DBG_LAYER_ACTION_DEBUG_OUTPUT", "",
     "assay_validation.debug_action"},

    /* ---- message_id_filter. The utility library splits a text without a comma at its colons, as
     * lists are elsewhere in the environment; names in C++ have some, too. */
    {"filter_list", NULL, FILTER " " SENT_ID " , 12258,", "muted=3 03710"},
    {"filter_with_colons", NULL, FILTER SENT_ID "@scene::rocks", "glob=scene::rocks"},
    {"filter_with_colons_in_a_list", NULL, FILTER SENT_ID "@a:b, 12258", "muted=2 glob=a:b"},
    {"filter_list_with_colons", NULL, FILTER SENT_ID ":12258", "muted=3 03710"},
    {"filter_with_a_name", NULL, FILTER SENT_ID "@scene", "glob=scene"},
    {"filter_with_colons_in_a_file", FILE_LINE("message_id_filter = " SENT_ID "@scene::rocks"), "",
     "glob=scene::rocks"},
    {"filter_list_in_a_file", FILE_LINE("message_id_filter = " SENT_ID "@a:b, 12258"), "",
     "muted=2 glob=a:b"},
    {"filter_list_with_colons_in_a_file", FILE_LINE("message_id_filter = " SENT_ID ":12258"), "",
     "muted=3 03710"},
    {"file_name_with_a_comma", NULL, "LOG_FILENAME=a,b.log\nDEBUG_ACTION=log",
     "action=log file=a,b.log"},
    {"file_name_with_a_colon", NULL, "LOG_FILENAME=a:b.log\nDEBUG_ACTION=log",
     "action=log file=a:b.log"},
    {"file_name_with_both", NULL, "LOG_FILENAME=a:b,c:d.log\nDEBUG_ACTION=log",
     "action=log file=a:b,c:d.log"},
#define NO_FILTER(test, entry)                                                                     \
    {                                                                                              \
        test, NULL, FILTER entry "," SENT_ID, "muted=1 03710",                                     \
            "assay_validation.message_id_filter:..." entry "...ignored"                            \
    }
    NO_FILTER("filter_for_another_command", "VUID-vkCmdDraw-None-02699"),
    NO_FILTER("filter_without_a_zero", "3710"),
    NO_FILTER("filter_for_no_number", "99999"),
    NO_FILTER("filter_for_a_name_of_another_command", "VUID-vkCmdDraw-None-02699@scene*"),
    NO_FILTER("filter_without_a_name", "12258@"),
    NO_FILTER("filter_without_an_id", "@scene*"),
    NO_FILTER("filter_of_nothing", "@"),

    /* ---- keys that are not read */
    {"unknown_key", NULL, "LEVLE=content", "",
     "VK_ASSAY_VALIDATION_LEVLE" NAMED "...level...message_id_filter"},
    {"unknown_key_in_a_file", FILE_LINE("report_flag = error"), "", "",
     "\"assay_validation.report_flag\"... is not a setting...report_flags"},
    {"unknown_case_in_a_file", "Assay_Validation.level = content\n", "", "",
     "\"Assay_Validation.level\"...vk_layer_settings.txt...assay_validation.level?"},
    {"unknown_case_of_a_key", "assay_validation.LEVEL = content\n", "", "",
     "\"assay_validation.LEVEL\"...vk_layer_settings.txt...assay_validation.level?"},
    {"name_of_the_layer_in_a_file", "VK_LAYER_ASSAY_validation.level = content\n", "", "",
     "\"VK_LAYER_ASSAY_validation.level\"...vk_layer_settings.txt...assay_validation.level?"},
    {"short_name_in_a_file", "assay.level = content\n", "", "",
     "\"assay.level\"...vk_layer_settings.txt...assay_validation.level?"},
    {"name_of_the_environment_in_a_file", "VK_ASSAY_VALIDATION_LEVEL = content\n", "", "",
     "\"VK_ASSAY_VALIDATION_LEVEL\"...vk_layer_settings.txt...assay_validation.level?"},
    {"unknown_key_of_the_layer", "VK_LAYER_ASSAY_validation.levle = content\n", "", "",
     "\"VK_LAYER_ASSAY_validation.levle\"...vk_layer_settings.txt...which has preset, level"},
    {"short_name", NULL, "VK_ASSAY_LEVEL=content", "",
     "\"VK_ASSAY_LEVEL\"...VK_ASSAY_VALIDATION_LEVEL"},
    {"name_of_the_layer", NULL, "VK_LAYER_ASSAY_LEVEL=content", "",
     "\"VK_LAYER_ASSAY_LEVEL\"...VK_ASSAY_VALIDATION_LEVEL"},
    {"long_name", NULL, "VK_LAYER_ASSAY_VALIDATION_LOG_FILENAME=content", "",
     "\"VK_LAYER_ASSAY_VALIDATION_LOG_FILENAME\"...VK_ASSAY_VALIDATION_LOG_FILENAME"},
    {"small_letters", NULL, "vk_assay_validation_backend=content", "",
     "\"vk_assay_validation_backend\"...VK_ASSAY_VALIDATION_BACKEND"},
    {"all_that_there_are", NULL, "VK_ASSAY_LEVLE=content", "",
     "\"VK_ASSAY_LEVLE\"...preset, level, backend,"},
    {"other_variables", NULL,
     "VK_ASSAY_ENABLE=1\nVK_ASSAY_DISABLE=1\nVK_ASSAYER_LEVEL=1\nVK_LEVELS=1\nVK_ASSAY=1", ""},
    {"enable_takes_1", NULL, "VK_ASSAY_ENABLE=true", "",
     "VK_ASSAY_ENABLE...\"true\"...only 1 does"},
    {"enable_may_be_0", NULL, "VK_ASSAY_ENABLE=0", ""},
    {"line_without_equals_sign", "assay_validation.level content\n", "", "",
     "\"assay_validation.level content\"...vk_layer_settings.txt...\"=\""},
    {"line_with_a_colon", "  VK_LAYER_ASSAY_validation.level: content # a level\n", "", "",
     "\"VK_LAYER_ASSAY_validation.level: content\"...\"=\""},
    /* The file is for all layers. */
    {"other_lines",
     "# assay_validation.level content\n\n   \nsome prose of the user\nkhronos_validation.assay = "
     "1\n"
     "khronos_validation.report_flags error\n= 7\n",
     "", ""},
    {"path_to_nothing", NULL, "VK_LAYER_SETTINGS_PATH=/nonexistent/settings.txt", "",
     "VK_LAYER_SETTINGS_PATH...\"/nonexistent/settings.txt\"...does not exist"},
    /* The library falls back to the current folder. */
    {"path_to_nothing_beside_a_file", FILE_LINE("level = state"),
     "VK_LAYER_SETTINGS_PATH=/nonexistent/settings.txt", "level=state",
     "VK_LAYER_SETTINGS_PATH...does not exist...current folder"},
#endif
};

/* Sets the variables, or removes them. */
static void set_variables(const char *environment, bool removes)
{
    for (const char *line = environment; *line; line += strspn(line, "\n")) {
        const size_t length = strcspn(line, "\n"), key = strcspn(line, "=");
        char name[128], value[256];
        snprintf(name, sizeof(name), "%s%.*s",
                 strncasecmp(line, "VK_", 3) ? "VK_ASSAY_VALIDATION_" : "", (int)key, line);
        snprintf(value, sizeof(value), "%.*s", (int)(length - key - 1), line + key + 1);
        if (removes)
            unsetenv(name);
        else
            setenv(name, value, 1);
        line += length;
    }
}

static const VkLayerSettingsCreateInfoEXT *settings_of(const char *application)
{
    enum { GIVEN = 4 };
    static char keys[GIVEN][64], texts[GIVEN][64];
    static const char *values[GIVEN];
    static VkLayerSettingEXT entries[GIVEN];
    static VkLayerSettingsCreateInfoEXT given;
    uint32_t count = 0;
    for (int length;
         sscanf(application, " %63[^=]=%63s%n", keys[count], texts[count], &length) == 2;
         application += length) {
        values[count] = texts[count];
        entries[count] = text_given(keys[count], &values[count]);
        assert_true(++count < GIVEN);
    }
    given = settings_given(entries, count);
    return &given;
}

TEST(settings_are_read)
{
    for (size_t i = 0; i < LENGTH(rows); i++) {
        const struct row *row = &rows[i];
        surrounding_clear(row->file);
        set_variables(row->environment, false);
        const struct settings settings =
            settings_read(row->application ? settings_of(row->application) : NULL);
        set_variables(row->environment, true);
        print_message("%s\n", row->test);
        assert_string_equal(settings_text(&settings), row->text);
        if (row->warning)
            assert_warned(row->warning);
        else
            assert_int_equal(warned.count, 0);
    }
}

#ifndef _WIN32
TEST_OPENED(values_that_are_not_understood, surrounding_set_up)
{
    static const struct {
        const char *key, *value, *takes, *used;
    } cases[] = {
        {"level", "contents", "parameters, state, execution or content", "execution"},
        {"level", "state,content", "parameters, state, execution or content", "execution"},
        {"backend", "gpu", "driver or cpu", "driver"},
        {"preset", "all", "none, everything or ci", "none"},
        {"preset", "everything,ci", "none, everything or ci", "none"},
        {"content_budget_mib", "-1", "a number", "256"},
        {"content_when_full", "drop", "wait or skip", "wait"},
        {"guard", "on", "off or references", "off"},
        {"vuid_names", "retired", "current or listed", "current"},
        {"spec_text", "brief", "full, short or none", "full"},
        {"report_flags", "error,warnings", "error, warn, info, perf", "error,warn"},
        {"advice", "some", "true or false", "false"},
        {"advice_limits", "lines=7,lies=8", "a list of NAME=NUMBER", "none"},
        {"advice_limits", "lines=many", "a list of NAME=NUMBER", "none"},
        {"advice_limits", "lines", "a list of NAME=NUMBER", "none"},
        {"debug_action", "VK_DBG_LAYER_ACTION_PANIC", "default, ignore, callback, log, break, fail",
         "default"},
        {"log_format", "xml", "text or json", "text"},
        {"call_sites", "true", "off, frames or full", "off"},
        {"hazards", "some", "true or false", "true"},
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
        char line[256], parts[256];
        snprintf(line, sizeof(line), "assay_validation.%s = %s\n", cases[i].key, cases[i].value);
        snprintf(parts, sizeof(parts), "assay_validation.%s:...%s...%s...%s", cases[i].key,
                 cases[i].value, cases[i].takes, cases[i].used);
        surrounding_clear(line);
        const struct settings settings = settings_read(NULL);
        assert_string_equal(settings_text(&settings), "");
        assert_warned(parts);
    }
}
#endif

/* ---- the members that an application fills in, and the places of files */

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
