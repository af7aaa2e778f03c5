/* SPDX-License-Identifier: Apache-2.0 */
/* Reading settings, and what was said of them. */
#include "reading.h"

#include "src/report/ids/message_filter.h"
#include "src/report/settings.h"

struct kept_lines warned;

VkResult settings_try(const void *chain, struct settings *settings)
{
    const VkInstanceCreateInfo create_info = {.pNext = chain};
    kept_lines_free(&warned);
    VkResult result = settings_load(&create_info, &warned, settings);
    if (result == VK_SUCCESS)
        settings_check(settings, &warned);
    return result;
}

struct settings settings_read(const void *chain)
{
    static struct settings settings;
    settings_release(&settings);
    assert_int_equal(settings_try(chain, &settings), VK_SUCCESS);
    return settings;
}

void settings_read_scarce(const void *chain, unsigned warnings)
{
    for (int count = 0; memory_is_scarce(count); count++) {
        struct settings settings;
        VkResult result = settings_try(chain, &settings);
        const bool failed = memory_fail_no_more();
        if (result == VK_SUCCESS) {
            assert_in_range(warned.count, warnings - (failed && warnings), warnings);
            settings_release(&settings);
        } else {
            assert_true(failed);
            assert_int_equal(result, VK_ERROR_OUT_OF_HOST_MEMORY);
        }
    }
}

unsigned settings_muted(const struct settings *settings)
{
    unsigned count = 0;
    for (unsigned i = 0; i < MESSAGE_ID_COUNT; i++)
        count += settings->muted[i];
    return count;
}

static char described[1024];

static void add_word(const char *key, const char *value)
{
    const size_t length = strlen(described);
    snprintf(described + length, sizeof(described) - length, "%s%s%s%s", length ? " " : "", key,
             value ? "=" : "", value ? value : "");
}

static void add_number(const char *key, unsigned value)
{
    char number[16];
    snprintf(number, sizeof(number), "%u", value);
    add_word(key, number);
}

/* Adds the words of a set of flags. */
static void add_flags(const char *key, uint32_t flags, const char *const *words)
{
    char all[128] = "";
    for (int i = 0; words[i]; i++)
        if (flags & 1u << i)
            snprintf(all + strlen(all), sizeof(all) - strlen(all), "%s%s", all[0] ? "+" : "",
                     words[i]);
    add_word(key, all);
}

static void add_filters(const struct settings *settings)
{
    for (unsigned i = 0; i < OTHER_ID_COUNT; i++)
        if (settings->muted_others[i])
            add_word("muted", other_id_name(i));
    if (settings_muted(settings))
        add_number("muted", settings_muted(settings));
    if (settings->muted[SENT_VUID])
        add_word("03710", NULL);
    if (settings->narrow_filters)
        add_word("glob", settings->narrow_filters->glob);
}

const char *settings_text(const struct settings *settings)
{
    static const char *const levels[] = {"parameters", "state", "execution", "content"},
                             *const flags[] = {"error", "warn", "info", "perf", NULL},
                             *const actions[] = {"ignore",  "callback", "log", "break",
                                                 "default", "fail",     NULL};
    const struct {
        const char *key;
        unsigned value, usual;
    } numbers[] = {
        {"backend", settings->backend, BACKEND_DRIVER},
        {"limits", settings->limits, LIMITS_DRIVER},
        {"vuid_names", settings->vuid_names, VUID_NAMES_CURRENT},
        {"spec_text", settings->spec_text, SPEC_TEXT_FULL},
        {"budget", settings->content_budget_mib, 256},
        {"when_full", settings->content_when_full, CONTENT_WAIT},
        {"guard", settings->guard, GUARD_OFF},
        {"hang", settings->hang_seconds, 10},
        {"crash", settings->crash_report, false},
        {"json", settings->log_format, LOG_FORMAT_TEXT},
        {"sites", settings->call_sites, CALL_SITES_OFF},
        {"hazards", settings->hazards, settings->level >= LEVEL_EXECUTION},
        {"advice", settings->advice, false},
        {"submissions", settings->advice_limits.of[ADVICE_LIMIT_submissions], 30},
        {"lines", settings->advice_limits.of[ADVICE_LIMIT_lines], 5},
        {"records", settings->record_builds, false},
        {"limit", settings->duplicate_message_limit, 10},
        {"rays", settings->compare_rays, 0},
    };
    described[0] = '\0';
    if (settings->level != LEVEL_EXECUTION)
        add_word("level", levels[settings->level]);
    for (size_t i = 0; i < LENGTH(numbers); i++)
        if (numbers[i].value != numbers[i].usual)
            add_number(numbers[i].key, numbers[i].value);
    if (settings->report_flags != (REPORT_ERROR | REPORT_WARNING))
        add_flags("flags", settings->report_flags, flags);
    if (settings->debug_action != DEBUG_ACTION_DEFAULT)
        add_flags("action", settings->debug_action, actions);
    if (settings->log_filename)
        add_word("file", settings->log_filename);
    add_filters(settings);
    return described;
}

void assert_warned(const char *parts)
{
    assert_int_equal(warned.count, 1);
    assert_null(strchr(warned.lines[0], '\n'));
    assert_parts(warned.lines[0], parts);
}

VkLayerSettingEXT setting_given(const char *key, VkLayerSettingTypeEXT type, const void *values)
{
    return (VkLayerSettingEXT){"VK_LAYER_ASSAY_validation", key, type, 1, values};
}

VkLayerSettingEXT text_given(const char *key, const char *const *text)
{
    return setting_given(key, VK_LAYER_SETTING_TYPE_STRING_EXT, text);
}

VkLayerSettingsCreateInfoEXT settings_given(const VkLayerSettingEXT *settings, uint32_t count)
{
    return MAKE(VkLayerSettingsCreateInfoEXT, .settingCount = count, .pSettings = settings);
}
