/* SPDX-License-Identifier: Apache-2.0 */
/* The keys, their values, and the settings that they set. */
#include "src/report/settings.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "src/base/letter_case.h"
#include "src/base/text_buffer.h"
#include "src/platform/process.h"
#include "src/report/ids/message_filter.h"
#include "src/report/settings/source.h"
#include "src/report/words.h"

enum { LINE_SIZE = 1024, VALUE_SHOWN = 200, CHANGES_SIZE = 4096 };

struct loader {
    void (*warn)(void *context, const char *line);
    void *context;
    struct settings *settings;
    struct text_buffer *changes;
};

/* ---- values */

static const struct choice levels[] = {
    {"parameters", LEVEL_PARAMETERS},
    {"state", LEVEL_STATE},
    {"execution", LEVEL_EXECUTION},
    {"content", LEVEL_CONTENT},
    {NULL, 0},
};

static const struct choice backends[] = {
    {"driver", BACKEND_DRIVER},
    {"cpu", BACKEND_CPU},
    {NULL, 0},
};

static const struct choice when_full[] = {
    {"wait", CONTENT_WAIT},
    {"skip", CONTENT_SKIP},
    {NULL, 0},
};

static const struct choice vuid_names[] = {
    {"current", VUID_NAMES_CURRENT},
    {"listed", VUID_NAMES_LISTED},
    {NULL, 0},
};

static const struct choice spec_texts[] = {
    {"full", SPEC_TEXT_FULL},
    {"short", SPEC_TEXT_SHORT},
    {"none", SPEC_TEXT_NONE},
    {NULL, 0},
};

static const struct choice log_formats[] = {
    {"text", LOG_FORMAT_TEXT},
    {"json", LOG_FORMAT_JSON},
    {NULL, 0},
};

static const struct choice call_site_modes[] = {
    {"off", CALL_SITES_OFF},
    {"frames", CALL_SITES_FRAMES},
    {"full", CALL_SITES_FULL},
    {NULL, 0},
};

/* The last two are flags of the Khronos layer only; users share its settings with this layer. */
static const struct choice report_flags[] = {
    {"error", REPORT_ERROR},
    {"warn", REPORT_WARNING},
    {"info", REPORT_INFO},
    {"perf", REPORT_PERFORMANCE},
    {"debug", 0},
    {"verbose", 0},
    {NULL, 0},
};

static const struct choice debug_actions[] = {
    {"default", DEBUG_ACTION_DEFAULT},
    {"ignore", DEBUG_ACTION_IGNORE},
    {"callback", DEBUG_ACTION_CALLBACK},
    {"log", DEBUG_ACTION_LOG},
    {"break", DEBUG_ACTION_BREAK},
    {"fail", DEBUG_ACTION_FAIL},
    {"VK_DBG_LAYER_ACTION_DEFAULT", DEBUG_ACTION_DEFAULT},
    {"VK_DBG_LAYER_ACTION_IGNORE", DEBUG_ACTION_IGNORE},
    {"VK_DBG_LAYER_ACTION_CALLBACK", DEBUG_ACTION_CALLBACK},
    {"VK_DBG_LAYER_ACTION_LOG_MSG", DEBUG_ACTION_LOG},
    {"VK_DBG_LAYER_ACTION_BREAK", DEBUG_ACTION_BREAK},
    {"VK_DBG_LAYER_ACTION_FAIL", DEBUG_ACTION_FAIL},
    {"VK_DBG_LAYER_ACTION_DEBUG_OUTPUT", DEBUG_ACTION_DEBUGGER},
    {NULL, 0},
};

static const struct choice guards[] = {
    {"off", GUARD_OFF},
    {"references", GUARD_REFERENCES},
    {NULL, 0},
};

static const struct choice limits[] = {
    {"driver", LIMITS_DRIVER},
    {"harsh", LIMITS_HARSH},
    {NULL, 0},
};

enum preset { PRESET_NONE, PRESET_EVERYTHING, PRESET_CI };

static const struct choice presets[] = {
    {"none", PRESET_NONE},
    {"everything", PRESET_EVERYTHING},
    {"ci", PRESET_CI},
    {NULL, 0},
};

static const struct choice booleans[] = {
    {"true", 1}, {"false", 0}, {"on", 1}, {"off", 0}, {"1", 1}, {"0", 0}, {NULL, 0},
};

/* ---- keys: each function may modify `value`, and returns false if the value is invalid */

/* load_MEMBER for a member that is one of some choices. */
#define DEFINE_LOAD_CHOICE(member, choices)                                                        \
    static bool load_##member(const struct loader *loader, char *value)                            \
    {                                                                                              \
        uint32_t chosen;                                                                           \
        if (!value_read_choice(choices, value, &chosen))                                           \
            return false;                                                                          \
        loader->settings->member = (__typeof__(loader->settings->member))chosen;                   \
        return true;                                                                               \
    }

DEFINE_LOAD_CHOICE(level, levels)
DEFINE_LOAD_CHOICE(backend, backends)
DEFINE_LOAD_CHOICE(content_when_full, when_full)
DEFINE_LOAD_CHOICE(vuid_names, vuid_names)
DEFINE_LOAD_CHOICE(spec_text, spec_texts)
DEFINE_LOAD_CHOICE(log_format, log_formats)
DEFINE_LOAD_CHOICE(call_sites, call_site_modes)
DEFINE_LOAD_CHOICE(hazards, booleans)
DEFINE_LOAD_CHOICE(advice, booleans)
DEFINE_LOAD_CHOICE(record_builds, booleans)
DEFINE_LOAD_CHOICE(crash_report, booleans)
DEFINE_LOAD_CHOICE(guard, guards)
DEFINE_LOAD_CHOICE(limits, limits)

static bool load_content_budget_mib(const struct loader *loader, char *value)
{
    return value_read_number(value, &loader->settings->content_budget_mib);
}

static bool load_hang_seconds(const struct loader *loader, char *value)
{
    return value_read_number(value, &loader->settings->hang_seconds);
}

static bool load_report_flags(const struct loader *loader, char *value)
{
    return value_read_flags(report_flags, value, &loader->settings->report_flags);
}

static bool load_debug_action(const struct loader *loader, char *value)
{
    uint32_t actions;
    if (!value_read_flags(debug_actions, value, &actions))
        return false;
    if (actions & DEBUG_ACTION_DEBUGGER && !PROCESS_HAS_DEBUGGER_OUTPUT) {
        loader->warn(loader->context,
                     "assay_validation.debug_action: VK_DBG_LAYER_ACTION_DEBUG_OUTPUT has an "
                     "effect on Windows only.");
        actions &= ~(uint32_t)DEBUG_ACTION_DEBUGGER;
    }
    if (actions != DEBUG_ACTION_IGNORE)
        actions &= ~(uint32_t)DEBUG_ACTION_IGNORE;
    /* A break or a failed call needs the message, too: it states the reason. */
    if (!(actions & ~(uint32_t)(DEBUG_ACTION_BREAK | DEBUG_ACTION_FAIL)))
        actions |= DEBUG_ACTION_DEFAULT;
    loader->settings->debug_action = actions;
    return true;
}

static bool load_duplicate_message_limit(const struct loader *loader, char *value)
{
    return value_read_number(value, &loader->settings->duplicate_message_limit);
}

static bool load_enable_message_limit(const struct loader *loader, char *value)
{
    uint32_t enabled;
    if (!value_read_choice(booleans, value, &enabled))
        return false;
    if (!enabled)
        loader->settings->duplicate_message_limit = 0;
    return true;
}

/* More rays would delay a wait of the application by seconds for each build. */
enum { COMPARE_RAYS_MAX = 1000000 };

static bool load_compare_rays(const struct loader *loader, char *value)
{
    uint32_t rays;
    if (!value_read_number(value, &rays) || rays > COMPARE_RAYS_MAX)
        return false;
    loader->settings->compare_rays = rays;
    return true;
}

/* Finds the limit that an entry NAME=NUMBER names, and cuts the entry behind the name. Returns the
 * number as text, or NULL. */
static char *find_limit(char *entry, enum advice_limit *limit)
{
    char *equals = strchr(entry, '='), *name;
    if (!equals)
        return NULL;
    *equals = '\0';
    name = value_next_entry(&entry);
    for (*limit = 0; name && *limit < ADVICE_LIMITS; ++*limit)
        if (text_equals_in_any_case(name, advice_limit_infos[*limit].name))
            return equals + 1;
    return NULL;
}

/* A list that has one invalid entry changes nothing. */
static bool load_advice_limits(const struct loader *loader, char *value)
{
    struct advice_limits given = loader->settings->advice_limits;
    for (char *entry; (entry = value_next_entry(&value));) {
        enum advice_limit limit;
        char *number = find_limit(entry, &limit);
        if (!number || !value_read_number(number, &given.of[limit]))
            return false;
    }
    loader->settings->advice_limits = given;
    return true;
}

/* Colons separate entries if there is no comma, as in all lists; but not in ID@PATTERN, whose
 * pattern may have some. */
static bool load_message_id_filter(const struct loader *loader, char *value)
{
    struct settings *settings = loader->settings;
    bool has_colons = !strchr(value, ',') && !strchr(value, '@');
    for (char *colon = value; has_colons && (colon = strchr(colon, ':'));)
        *colon = ',';
    message_filters_load(&(struct message_filters){settings->muted, settings->muted_others,
                                                   &settings->narrow_filters},
                         value, loader->warn, loader->context);
    return true;
}

static bool load_preset(const struct loader *loader, char *value);

/* The preset comes first, so that any other key that is given replaces the preset's value. */
static const struct key {
    const char *name;
    bool (*load)(const struct loader *loader, char *value); /* NULL: log_filename */
    const char *accepts, *default_value;
} keys[] = {
    {"preset", load_preset, "none, everything or ci", "none"},
    {"level", load_level, "parameters, state, execution or content", "execution"},
    {"backend", load_backend, "driver or cpu", "driver"},
    {"limits", load_limits, "driver or harsh", "driver"},
    {"content_budget_mib", load_content_budget_mib, "a number", "256"},
    {"content_when_full", load_content_when_full, "wait or skip", "wait"},
    {"vuid_names", load_vuid_names, "current or listed", "current"},
    {"spec_text", load_spec_text, "full, short or none", "full"},
    {"report_flags", load_report_flags, "error, warn, info, perf", "error,warn"},
    {"debug_action", load_debug_action, "default, ignore, callback, log, break, fail", "default"},
    {"log_filename", NULL, "a file name", "stderr"},
    {"log_format", load_log_format, "text or json", "text"},
    {"record_builds", load_record_builds, "true or false", "false"},
    {"duplicate_message_limit", load_duplicate_message_limit, "a number; 0 is no limit", "10"},
    {"enable_message_limit", load_enable_message_limit, "true or false", "true"},
    {"message_id_filter", load_message_id_filter, "a list of VUIDs", "none"},
    {"hazards", load_hazards, "true or false", "false"},
    {"advice", load_advice, "true or false", "false"},
    {"advice_limits", load_advice_limits, "a list of NAME=NUMBER", "none"},
    {"guard", load_guard, "off or references", "off"},
    {"hang_seconds", load_hang_seconds, "a number of seconds; 0 is off", "10"},
    {"crash_report", load_crash_report, "true or false", "false"},
    {"call_sites", load_call_sites, "off, frames or full", "off"},
    {"compare_rays", load_compare_rays, "a number up to 1000000; 0 is off", "0"},
};

enum { KEY_COUNT = sizeof(keys) / sizeof(keys[0]) };

static const struct key *find_key(const char *name)
{
    const struct key *key = keys;
    while (strcmp(key->name, name) != 0)
        key++;
    return key;
}

/* ---- presets */

/* What presets set. Each preset sets what the presets before it set, too. */
static const struct preset_value {
    enum preset preset;
    const char *key, *value;
} preset_values[] = {
    {PRESET_EVERYTHING, "level", "content"},
    {PRESET_EVERYTHING, "hazards", "true"},
    {PRESET_EVERYTHING, "guard", "references"},
    {PRESET_EVERYTHING, "call_sites", "full"},
    {PRESET_EVERYTHING, "record_builds", "true"},
    {PRESET_EVERYTHING, "advice", "true"},
    {PRESET_CI, "limits", "harsh"},
};

enum { PRESET_VALUE_COUNT = sizeof(preset_values) / sizeof(preset_values[0]), VALUE_SIZE = 16 };

_Static_assert(KEY_COUNT <= 32, "settings.by_preset has a bit for each key");

static uint32_t bit_of(const struct key *key)
{
    return 1u << (key - keys);
}

static bool load_preset(const struct loader *loader, char *value)
{
    uint32_t preset;
    if (!value_read_choice(presets, value, &preset))
        return false;
    for (unsigned i = 0; i < PRESET_VALUE_COUNT; i++) {
        const struct key *key = find_key(preset_values[i].key);
        char copy[VALUE_SIZE];
        if (preset_values[i].preset > preset)
            continue;
        snprintf(copy, sizeof(copy), "%s", preset_values[i].value);
        key->load(loader, copy);
        loader->settings->by_preset |= bit_of(key);
    }
    return true;
}

/* The value of a key that is not given: the preset's or the default. */
static const char *usual_value(const struct settings *settings, const struct key *key)
{
    if (settings->by_preset & bit_of(key))
        for (unsigned i = 0; i < PRESET_VALUE_COUNT; i++)
            if (strcmp(preset_values[i].key, key->name) == 0)
                return preset_values[i].value;
    return key->default_value;
}

bool settings_leave_out(struct settings *settings, const char *name)
{
    const uint32_t bit = bit_of(find_key(name)), was_by_preset = settings->by_preset & bit;
    settings->by_preset &= ~bit;
    return was_by_preset;
}

/* ---- loading */

static void warn_of_value(const struct loader *loader, const struct key *key, const char *value)
{
    char line[LINE_SIZE];
    struct text_buffer text;
    text_begin(&text, line, sizeof(line));
    text_say(&text, "assay_validation.{}: {} is not a valid value ({}). The {}, {}, is used.",
             phrase(key->name), quoted(value, VALUE_SHOWN), phrase(key->accepts),
             phrase(loader->settings->by_preset & bit_of(key) ? "preset's value" : "default"),
             phrase(usual_value(loader->settings, key)));
    loader->warn(loader->context, line);
}

static void note_value(const struct loader *loader, const struct key *key, const char *value)
{
    char **values = loader->settings->values;
    if (values)
        values[key - keys] = strdup(value);
    struct text_buffer *changes = loader->changes;
    if (text_equals_in_any_case(value, usual_value(loader->settings, key)))
        return;
    text_say(changes, "{}{} = {} (", phrase(changes->length ? ", " : ""), phrase(key->name),
             quoted(value, VALUE_SHOWN));
    settings_append_origin(changes, key->name);
    text_append(changes, ")");
}

static VkResult load_filename(const struct loader *loader, const struct settings_source *source,
                              const struct key *key)
{
    char **filename = &loader->settings->log_filename;
    VkResult result = settings_source_text(source, key->name, filename);
    if (result == VK_SUCCESS && *filename)
        note_value(loader, key, *filename);
    return result;
}

static VkResult load_key(const struct loader *loader, const struct settings_source *source,
                         const struct key *key)
{
    if (!key->load)
        return load_filename(loader, source, key);

    char *value;
    VkResult result = key->load == load_message_id_filter
                          ? settings_source_text(source, key->name, &value)
                          : settings_source_list(source, key->name, &value);
    if (result != VK_SUCCESS || !value)
        return result;
    char *as_given = strdup(value);
    if (key->load(loader, value)) {
        if (as_given)
            note_value(loader, key, as_given);
        loader->settings->by_preset &= ~bit_of(key);
    } else {
        warn_of_value(loader, key, as_given ? as_given : "");
    }
    free(as_given);
    free(value);
    return VK_SUCCESS;
}

static void warn_of_ignored(const struct loader *loader, const struct settings_source *source)
{
    const char *names[KEY_COUNT + 1] = {NULL};
    for (unsigned i = 0; i < KEY_COUNT; i++)
        names[i] = keys[i].name;
    settings_source_ignored(source, names, loader->warn, loader->context);
}

VkResult settings_load(const VkInstanceCreateInfo *create_info,
                       void (*warn)(void *context, const char *line), void *context,
                       struct settings *settings)
{
    *settings = (struct settings){
        .level = LEVEL_EXECUTION,
        .backend = BACKEND_DRIVER,
        .limits = LIMITS_DRIVER,
        .vuid_names = VUID_NAMES_CURRENT,
        .spec_text = SPEC_TEXT_FULL,
        .content_budget_mib = 256,
        .content_when_full = CONTENT_WAIT,
        .hang_seconds = 10,
        .report_flags = REPORT_ERROR | REPORT_WARNING,
        .debug_action = DEBUG_ACTION_DEFAULT,
        .duplicate_message_limit = 10,
    };
    for (enum advice_limit limit = 0; limit < ADVICE_LIMITS; limit++)
        settings->advice_limits.of[limit] = advice_limit_infos[limit].by_default;
    settings->values = calloc(KEY_COUNT, sizeof(*settings->values));
    struct settings_source source;
    VkResult result = settings_source_open(&source, create_info);
    if (result != VK_SUCCESS) {
        settings_release(settings);
        return result;
    }

    char changed[CHANGES_SIZE];
    struct text_buffer changes;
    text_begin(&changes, changed, sizeof(changed));
    struct loader loader = {warn, context, settings, &changes};
    for (unsigned i = 0; i < KEY_COUNT && result == VK_SUCCESS; i++)
        result = load_key(&loader, &source, &keys[i]);
    if (result == VK_SUCCESS) {
        warn_of_ignored(&loader, &source);
        if (settings->report_flags & REPORT_INFO && changes.length)
            settings->changes = strdup(changed);
    } else {
        settings_release(settings);
    }
    settings_source_close(&source);
    return result;
}

void settings_release(struct settings *settings)
{
    for (unsigned i = 0; settings->values && i < KEY_COUNT; i++)
        free(settings->values[i]);
    free(settings->values);
    free(settings->log_filename);
    free(settings->changes);
    narrow_filters_free(settings->narrow_filters);
    settings_disown(settings);
}

void settings_disown(struct settings *settings)
{
    settings->narrow_filters = NULL;
    settings->log_filename = settings->changes = NULL;
    settings->values = NULL;
}

void settings_each(const struct settings *settings,
                   void (*each)(void *context, const char *key, const char *value), void *context)
{
    for (unsigned i = 0; i < KEY_COUNT; i++) {
        const char *given = settings->values ? settings->values[i] : NULL;
        each(context, keys[i].name, given ? given : usual_value(settings, &keys[i]));
    }
}
