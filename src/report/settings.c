/* SPDX-License-Identifier: Apache-2.0 */
/* Reads the settings of settings.def. */
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

enum { LINE_SIZE = 1024, VALUE_SHOWN = 200, VALUE_SIZE = 32, CHANGES_SIZE = 4096 };

struct loader {
    struct kept_lines *warnings;
    struct settings *settings;
    struct text_buffer *changes;
};

/* ---- the table */

static const struct key {
    const char *name, *by_default;
    const char *accepts; /* NULL: the setting's words */
    bool has_list;       /* of words; else there is one at most */
    bool is_own;         /* its default is no value */
} keys[SETTING_COUNT] = {
#define CHOICE(key, by_default, ...) {#key, by_default, NULL, false, false},
#define CHOICE_OF(key, type, by_default, ...) {#key, by_default, NULL, false, false},
#define FLAGS(key, by_default, ...) {#key, by_default, NULL, true, false},
#define SWITCH(key, by_default, ...) {#key, by_default, "true or false", false, false},
#define NUMBER(key, by_default, most, accepts, ...) {#key, by_default, accepts, false, false},
#define OWN(key, kind, by_default, accepts, ...) {#key, by_default, accepts, false, true},
#include "src/report/settings.def"
};

/* The words of settings. */
static const struct word {
    enum setting setting;
    bool is_alias;
    const char *name;
    uint32_t value;
} words[] = {
#define VALUE(key, constant, name, ...) {SETTING_##key, false, name, constant},
#define GIVEN(key, constant, name, ...) {SETTING_##key, false, name, constant},
#define ALIAS(key, constant, name) {SETTING_##key, true, name, constant},
#include "src/report/settings.def"
};

/* Each preset sets what the presets before it set, too. */
static const struct preset_value {
    enum preset_setting preset;
    enum setting setting;
    const char *value;
} preset_values[] = {
#define PRESET(preset, key, value) {preset, SETTING_##key, value},
#include "src/report/settings.def"
};

#define COUNT_OF(array) (sizeof(array) / sizeof((array)[0]))

/* ---- values: each function may modify the text, and returns false if the value is invalid */

static bool read_word(enum setting setting, const char *name, uint32_t *value)
{
    for (size_t i = 0; i < COUNT_OF(words); i++)
        if (words[i].setting == setting && text_equals_in_any_case(words[i].name, name)) {
            *value |= words[i].value;
            return true;
        }
    return false;
}

/* Reads one word, or several if the setting has a list; combines their values. */
static bool read_words(enum setting setting, char *list, uint32_t *value)
{
    uint32_t all = 0, count = 0;
    for (char *name; (name = value_next_entry(&list)); count++)
        if (!read_word(setting, name, &all) || (count && !keys[setting].has_list))
            return false;
    *value = all;
    return count != 0;
}

static bool read_switch(char *list, bool *value)
{
    static const char *const names[] = {"false", "off", "0", "true", "on", "1"};
    const char *name = value_next_entry(&list);
    for (size_t i = 0; name && i < COUNT_OF(names); i++)
        if (text_equals_in_any_case(names[i], name)) {
            *value = i >= COUNT_OF(names) / 2;
            return !value_next_entry(&list);
        }
    return false;
}

static bool read_number(char *list, uint32_t most, uint32_t *value)
{
    uint32_t number;
    if (!value_read_number(list, &number) || number > most)
        return false;
    *value = number;
    return true;
}

/* The settings own the text. */
static bool load_log_filename(const struct loader *loader, char *value)
{
    loader->settings->log_filename = value;
    return true;
}

/* settings_load() takes the text from `values`. */
static bool load_capture(const struct loader *loader, const char *value)
{
    (void)loader;
    return value[0];
}

static bool read_point(const char *value, struct capture_point *point)
{
    char *end;
    *point = (struct capture_point){.kind = AT_ANY_POINT};
    if (text_equals_in_any_case(value, "none"))
        return true;
    const bool is_frame = strncmp(value, "frame:", 6) == 0;
    *point = (struct capture_point){.kind = AT_LABEL, .label = value + 6};
    if (strncmp(value, "label:", 6) == 0)
        return value[6];
    if (!is_frame && strncmp(value, "submission:", 11) != 0)
        return false;
    value += is_frame ? 6 : 11;
    *point = (struct capture_point){.kind = is_frame ? AT_FRAME : AT_SUBMISSION,
                                    .number = strtoull(value, &end, 10)};
    return *value >= '0' && *value <= '9' && !*end;
}

/* settings_load() reads them again, from `values`. */
static bool load_capture_from(const struct loader *loader, const char *value)
{
    return read_point(value, &loader->settings->capture_from);
}

static bool load_capture_until(const struct loader *loader, const char *value)
{
    return read_point(value, &loader->settings->capture_until);
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
                         value, loader->warnings);
    return true;
}

/* Reads the value of a setting. */
static bool load_value(const struct loader *loader, enum setting setting, char *value)
{
    struct settings *settings = loader->settings;
    uint32_t word;
    switch (setting) {
#define CHOICE(key, ...)                                                                           \
    case SETTING_##key:                                                                            \
        if (!read_words(setting, value, &word))                                                    \
            return false;                                                                          \
        settings->key = (__typeof__(settings->key))word;                                           \
        return true;
#define CHOICE_OF(key, ...) CHOICE(key)
#define FLAGS(key, ...)                                                                            \
    case SETTING_##key:                                                                            \
        return read_words(setting, value, &settings->key);
#define SWITCH(key, ...)                                                                           \
    case SETTING_##key:                                                                            \
        return read_switch(value, &settings->key);
#define NUMBER(key, by_default, most, ...)                                                         \
    case SETTING_##key:                                                                            \
        return read_number(value, most, &settings->key);
#define OWN(key, ...)                                                                              \
    case SETTING_##key:                                                                            \
        return load_##key(loader, value);
#include "src/report/settings.def"
    case SETTING_COUNT:
        break;
    }
    return false;
}

/* Reads a value of the table. */
static void load_known(const struct loader *loader, enum setting setting, const char *value)
{
    char copy[VALUE_SIZE];
    snprintf(copy, sizeof(copy), "%s", value);
    load_value(loader, setting, copy);
}

/* The value of a setting that is not given: the preset's or the default. */
static const char *usual_value(const struct settings *settings, enum setting setting)
{
    for (size_t i = 0; settings->by_preset[setting] && i < COUNT_OF(preset_values); i++)
        if (preset_values[i].setting == setting)
            return preset_values[i].value;
    return keys[setting].by_default;
}

static void apply_preset(const struct loader *loader)
{
    for (size_t i = 0; i < COUNT_OF(preset_values); i++) {
        const struct preset_value *value = &preset_values[i];
        if (value->preset > loader->settings->preset)
            continue;
        load_known(loader, value->setting, value->value);
        loader->settings->by_preset[value->setting] = true;
    }
}

/* ---- loading */

static void append_accepted(struct text_buffer *text, enum setting setting)
{
    const char *before = "";
    uint32_t left = 0;
    if (keys[setting].accepts) {
        text_append(text, keys[setting].accepts);
        return;
    }
    for (size_t i = 0; i < COUNT_OF(words); i++)
        left += words[i].setting == setting && !words[i].is_alias;
    for (size_t i = 0; i < COUNT_OF(words); i++)
        if (words[i].setting == setting && !words[i].is_alias) {
            text_say(text, "{}{}", phrase(before), phrase(words[i].name));
            before = --left == 1 && !keys[setting].has_list ? " or " : ", ";
        }
}

static void warn_of_value(const struct loader *loader, enum setting setting, const char *value)
{
    char line[LINE_SIZE];
    struct text_buffer text;
    text_begin(&text, line, sizeof(line));
    text_say(&text, "assay_validation.{}: {} is not a valid value (", phrase(keys[setting].name),
             quoted(value, VALUE_SHOWN));
    append_accepted(&text, setting);
    text_say(&text, "). The {}, {}, is used.",
             phrase(loader->settings->by_preset[setting] ? "preset's value" : "default"),
             phrase(usual_value(loader->settings, setting)));
    kept_lines_add(loader->warnings, line);
}

static void note_value(const struct loader *loader, enum setting setting, const char *value)
{
    struct text_buffer *changes = loader->changes;
    loader->settings->values[setting] = strdup(value);
    if (text_equals_in_any_case(value, usual_value(loader->settings, setting)))
        return;
    text_say(changes, "{}{} = {} (", phrase(changes->length ? ", " : ""),
             phrase(keys[setting].name), quoted(value, VALUE_SHOWN));
    settings_append_origin(changes, keys[setting].name);
    text_append(changes, ")");
}

static VkResult load_setting(const struct loader *loader, const struct settings_source *source,
                             enum setting setting)
{
    const struct key *key = &keys[setting];
    const bool is_text = setting == SETTING_log_filename || setting == SETTING_capture ||
                         setting == SETTING_capture_from || setting == SETTING_capture_until ||
                         setting == SETTING_message_id_filter;
    char *value;
    if (!key->is_own && !loader->settings->by_preset[setting])
        load_known(loader, setting, key->by_default);
    VkResult result = is_text ? settings_source_text(source, key->name, &value)
                              : settings_source_list(source, key->name, &value);
    if (result != VK_SUCCESS || !value)
        return result;
    char *as_given = strdup(value);
    if (load_value(loader, setting, value)) {
        if (as_given)
            note_value(loader, setting, as_given);
        loader->settings->by_preset[setting] = false;
        loader->settings->is_given[setting] = true;
    } else {
        warn_of_value(loader, setting, as_given ? as_given : "");
    }
    free(as_given);
    if (value != loader->settings->log_filename)
        free(value);
    return VK_SUCCESS;
}

/* Actions that count for nothing beside others, and those that others need. */
static void settle_actions(const struct loader *loader)
{
    uint32_t actions = loader->settings->debug_action;
    if (actions & DEBUG_ACTION_DEBUGGER && !PROCESS_HAS_DEBUGGER_OUTPUT) {
        kept_lines_add(loader->warnings,
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
}

static void warn_of_ignored(const struct loader *loader, const struct settings_source *source)
{
    const char *names[SETTING_COUNT + 1] = {NULL};
    for (unsigned i = 0; i < SETTING_COUNT; i++)
        names[i] = keys[i].name;
    settings_source_ignored(source, names, loader->warnings);
}

VkResult settings_load(const VkInstanceCreateInfo *create_info, struct kept_lines *warnings,
                       struct settings *settings)
{
    *settings = (struct settings){0};
    for (enum advice_limit limit = 0; limit < ADVICE_LIMITS; limit++)
        settings->advice_limits.of[limit] = advice_limit_infos[limit].by_default;
    struct settings_source source;
    VkResult result = settings_source_open(&source, create_info);
    if (result != VK_SUCCESS)
        return result;

    char changed[CHANGES_SIZE];
    struct text_buffer changes;
    text_begin(&changes, changed, sizeof(changed));
    struct loader loader = {warnings, settings, &changes};
    for (enum setting setting = 0; setting < SETTING_COUNT && result == VK_SUCCESS; setting++) {
        result = load_setting(&loader, &source, setting);
        if (setting == SETTING_preset)
            apply_preset(&loader);
    }
    if (result == VK_SUCCESS) {
        settle_actions(&loader);
        settings->capture = settings->values[SETTING_capture];
        if (settings->capture && text_equals_in_any_case(settings->capture, "none"))
            settings->capture = NULL;
        if (settings->values[SETTING_capture_from])
            read_point(settings->values[SETTING_capture_from], &settings->capture_from);
        if (settings->values[SETTING_capture_until])
            read_point(settings->values[SETTING_capture_until], &settings->capture_until);
        if (!settings->enable_message_limit)
            settings->duplicate_message_limit = 0;
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
    for (unsigned i = 0; i < SETTING_COUNT; i++)
        free(settings->values[i]);
    free(settings->log_filename);
    free(settings->changes);
    narrow_filters_free(settings->narrow_filters);
    settings_disown(settings);
}

void settings_disown(struct settings *settings)
{
    settings->narrow_filters = NULL;
    settings->log_filename = settings->changes = NULL;
    settings->capture = settings->capture_from.label = settings->capture_until.label = NULL;
    memset(settings->values, 0, sizeof(settings->values));
}

void settings_each(const struct settings *settings,
                   void (*each)(void *context, const char *key, const char *value), void *context)
{
    for (enum setting i = 0; i < SETTING_COUNT; i++)
        each(context, keys[i].name,
             settings->values[i] ? settings->values[i] : usual_value(settings, i));
}

/* ---- settings without effect beside others */

/* Warns of a setting that was given and has no effect. The preset's values and defaults are left
 * out in silence. */
static void leave_out(const struct loader *loader, enum setting setting, const char *needs)
{
    loader->settings->by_preset[setting] = false;
    if (!loader->settings->is_given[setting])
        return;
    kept_lines_say(loader->warnings, "assay_validation.{} needs {}", phrase(keys[setting].name),
                   phrase(needs));
}

/* The file would look as if there were no messages. */
static void check_log_filename(const struct loader *loader)
{
    const struct settings *settings = loader->settings;
    if (!settings->log_filename ||
        settings->debug_action & (DEBUG_ACTION_LOG | DEBUG_ACTION_DEFAULT))
        return;
    kept_lines_say(
        loader->warnings,
        "assay_validation.log_filename: nothing is written to {}, because debug_action has "
        "neither log nor default.",
        quoted(settings->log_filename, VALUE_SHOWN));
}

void settings_check(struct settings *settings, struct kept_lines *warnings)
{
    const struct loader loader = {warnings, settings, NULL};
#define NEEDS(key, condition, says)                                                                \
    if (settings->key && !(condition)) {                                                           \
        settings->key = 0;                                                                         \
        leave_out(&loader, SETTING_##key, says);                                                   \
    }
#include "src/report/settings.def"
    check_log_filename(&loader);
}
