/* SPDX-License-Identifier: Apache-2.0 */
/* Reading settings, and what was said of them. */
#include "reading.h"

#include "src/report/settings_check.h"

struct warned warned;

static void warn(void *context, const char *line)
{
    assert_ptr_equal(context, &warned);
    assert_true(warned.count < WARNED_LINES);
    snprintf(warned.lines[warned.count++], sizeof(warned.lines[0]), "%s", line);
}

VkResult settings_try(const void *chain, struct settings *settings)
{
    const VkInstanceCreateInfo create_info = {.pNext = chain};
    warned.count = 0;
    VkResult result = settings_load(&create_info, warn, &warned, settings);
    if (result == VK_SUCCESS)
        settings_check(settings, warn, &warned);
    return result;
}

struct settings settings_read(const void *chain)
{
    static struct settings settings;
    settings_release(&settings);
    assert_int_equal(settings_try(chain, &settings), VK_SUCCESS);
    return settings;
}

struct settings settings_of_file(const char *text)
{
    surrounding_clear(text);
    const struct settings settings = settings_read(NULL);
    assert_int_equal(warned.count, 0);
    return settings;
}

void settings_read_scarce(const void *chain, unsigned warnings)
{
    for (int count = 0; memory_is_scarce(count); count++) {
        struct settings settings;
        VkResult result = settings_try(chain, &settings);
        const bool failed = memory_fail_no_more();
        if (result == VK_SUCCESS) {
            assert_int_equal(warned.count, warnings);
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

void assert_default_settings(const struct settings *settings)
{
    assert_int_equal(settings->level, LEVEL_EXECUTION);
    assert_int_equal(settings->backend, BACKEND_DRIVER);
    assert_int_equal(settings->vuid_names, VUID_NAMES_CURRENT);
    assert_int_equal(settings->spec_text, SPEC_TEXT_FULL);
    assert_int_equal(settings->report_flags, REPORT_ERROR | REPORT_WARNING);
    assert_int_equal(settings->debug_action, DEBUG_ACTION_DEFAULT);
    assert_int_equal(settings->duplicate_message_limit, 10);
    assert_null(settings->log_filename);
    assert_int_equal(settings->log_format, LOG_FORMAT_TEXT);
    assert_int_equal(settings->call_sites, CALL_SITES_OFF);
    assert_false(settings->record_builds);
    assert_null(settings->narrow_filters);
    assert_int_equal(settings->compare_rays, 0);
    assert_int_equal(settings->hang_seconds, 10);
    assert_false(settings->crash_report);
    assert_int_equal(settings->content_budget_mib, 256);
    assert_int_equal(settings->content_when_full, CONTENT_WAIT);
    assert_int_equal(settings_muted(settings), 0);
}

void assert_warned(const char *const *words)
{
    assert_int_equal(warned.count, 1);
    assert_null(strchr(warned.lines[0], '\n'));
    for (; *words; words++)
        if (!strstr(warned.lines[0], *words))
            fail_msg("\"%s\" is not in: %s", *words, warned.lines[0]);
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
