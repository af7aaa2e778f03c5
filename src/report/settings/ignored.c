/* SPDX-License-Identifier: Apache-2.0 */
/* Finds settings without effect: misspelt ones, lines that are not settings, and a file that is not
 * read. */
#include "src/report/settings/source.h"

#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "src/base/letter_case.h"
#include "src/base/text_buffer.h"
#include "src/platform/files.h"
#include "src/platform/process.h"
#include "src/report/words.h"

#define FILE_PREFIX "assay_validation."
#define ENVIRONMENT_PREFIX "VK_ASSAY_VALIDATION_"

enum { NAME_SIZE = 128, LINE_SIZE = 1024, SHOWN = 200 };

struct search {
    const char *const *keys;
    struct kept_lines *warnings;
};

/* ---- warnings */

/* The key that a name was meant to have: the one that it ends in, in any case. */
static const char *meant_key(const struct search *search, const char *name)
{
    size_t length = strlen(name);
    for (const char *const *key = search->keys; *key; key++) {
        size_t of_key = strlen(*key);
        if (length > of_key && text_equals_in_any_case(name + length - of_key, *key) &&
            strchr("._", name[length - of_key - 1]))
            return *key;
    }
    return NULL;
}

static void append_meant(struct text_buffer *text, const char *key, bool of_environment)
{
    text_say(text, "; did you mean {}", phrase(of_environment ? ENVIRONMENT_PREFIX : FILE_PREFIX));
    for (; *key; key++)
        text_append_part(text, &(char){of_environment ? (char)toupper((unsigned char)*key) : *key},
                         1);
    text_append(text, "?");
}

/* `path`: the settings file, or NULL. */
static void warn_of_name(const struct search *search, const char *name, const char *path,
                         bool of_environment)
{
    char line[LINE_SIZE];
    struct text_buffer text;
    text_begin(&text, line, sizeof(line));
    text_append_quoted(&text, name, SHOWN);
    if (path)
        text_say(&text, " in {}", quoted(path, SHOWN));
    text_append(&text, " is not a setting of this layer");
    const char *meant = meant_key(search, name);
    if (meant) {
        append_meant(&text, meant, of_environment);
    } else {
        text_append(&text, ", which has");
        for (const char *const *key = search->keys; *key; key++)
            text_say(&text, key == search->keys ? " {}" : ", {}", phrase(*key));
    }
    text_append(&text, meant ? " It is ignored." : ". It is ignored.");
    kept_lines_add(search->warnings, line);
}

static void warn_of_line(const struct search *search, const char *words, const char *path)
{
    kept_lines_say(search->warnings,
                   "{} in {} has no \"=\" between name and value. The line is ignored.",
                   quoted(words, SHOWN), quoted(path, SHOWN));
}

static void warn_of_path(const struct search *search, enum settings_path state, const char *path,
                         bool file_exists)
{
    const char *given = process_variable("VK_LAYER_SETTINGS_PATH");
    char line[LINE_SIZE];
    struct text_buffer text;
    if (state == SETTINGS_PATH_USED || !given)
        return;
    text_begin(&text, line, sizeof(line));
    text_say(&text, "VK_LAYER_SETTINGS_PATH: {}", quoted(given, SHOWN));
    if (state == SETTINGS_PATH_SECOND)
        text_say(&text, " is not read, because the file {} exists and comes first.",
                 quoted(path, SHOWN));
    else if (state == SETTINGS_PATH_WITHOUT_FILE)
        text_append(&text, " is a folder that has no vk_layer_settings.txt. No file is read.");
    else
        text_say(&text, " does not exist. {}",
                 phrase(file_exists
                            ? "The file vk_layer_settings.txt of the current folder is read."
                            : "No settings file is read."));
    kept_lines_add(search->warnings, line);
}

/* ---- the environment */

static bool is_key(const struct search *search, const char *name, bool in_upper_case)
{
    for (const char *const *key = search->keys; *key; key++) {
        size_t i = 0;
        while ((*key)[i] &&
               name[i] == (in_upper_case ? toupper((unsigned char)(*key)[i]) : (*key)[i]))
            i++;
        if (!(*key)[i] && !name[i])
            return true;
    }
    return false;
}

/* VK_ASSAY_ENABLE and VK_ASSAY_DISABLE are the loader's. */
static bool is_ignored_variable(const struct search *search, const char *name)
{
    if (!text_starts_in_any_case(name, "VK_ASSAY_") &&
        !text_starts_in_any_case(name, "VK_LAYER_ASSAY_"))
        return false;
    if (strcmp(name, "VK_ASSAY_ENABLE") == 0 || strcmp(name, "VK_ASSAY_DISABLE") == 0)
        return false;
    return strncmp(name, ENVIRONMENT_PREFIX, strlen(ENVIRONMENT_PREFIX)) != 0 ||
           !is_key(search, name + strlen(ENVIRONMENT_PREFIX), true);
}

/* The loader compares the value with the one in the implicit layer's manifest. */
static void check_enable_value(const struct search *search)
{
    const char *value = process_variable("VK_ASSAY_ENABLE");
    if (!value || !value[0] || strcmp(value, "0") == 0 || strcmp(value, "1") == 0)
        return;
    kept_lines_say(search->warnings,
                   "VK_ASSAY_ENABLE: {} does not enable the layer; only 1 does. It was enabled in "
                   "another way.",
                   quoted(value, SHOWN));
}

static void check_variable(void *context, const char *variable)
{
    const struct search *search = context;
    char name[NAME_SIZE];
    snprintf(name, sizeof(name), "%.*s", (int)strcspn(variable, "="), variable);
    if (is_ignored_variable(search, name))
        warn_of_name(search, name, NULL, true);
}

static void search_environment(const struct search *search)
{
    check_enable_value(search);
    process_environment(check_variable, (void *)(uintptr_t)search);
}

/* ---- the file */

/* Whether a line, which may be of any layer, is meant for this one: its first word, up to a point
 * if it has one, has the layer's name in it. */
static bool is_meant_for_layer(const char *line)
{
    size_t length = strcspn(line, ". \t:");
    for (size_t i = 0; i + strlen("assay") <= length; i++)
        if (text_starts_in_any_case(line + i, "assay") && (i == 0 || line[i - 1] == '_'))
            return true;
    return false;
}

static void search_file(const struct search *search)
{
    char path[SETTINGS_PATH_SIZE], *buffer = NULL;
    enum settings_path state = settings_file_find(path);
    FILE *file = file_open_to_read(path);
    struct settings_line line;
    size_t size = 0;
    warn_of_path(search, state, path, file != NULL);
    if (!file)
        return;
    while (settings_file_next(file, &buffer, &size, &line)) {
        if (!is_meant_for_layer(line.name))
            continue;
        if (!line.value)
            warn_of_line(search, line.name, path);
        else if (strncmp(line.name, FILE_PREFIX, strlen(FILE_PREFIX)) != 0 ||
                 !is_key(search, line.name + strlen(FILE_PREFIX), false))
            warn_of_name(search, line.name, path, false);
    }
    free(buffer);
    fclose(file);
}

void settings_source_ignored(const struct settings_source *source, const char *const *keys,
                             struct kept_lines *warnings)
{
    const struct search search = {keys, warnings};
    for (uint32_t i = 0; i < source->given_count; i++) {
        const char *key = source->given[i].pSettingName;
        char name[NAME_SIZE];
        snprintf(name, sizeof(name), FILE_PREFIX "%s", key);
        if (!is_key(&search, key, false))
            warn_of_name(&search, name, NULL, false);
    }
    if (process_is_elevated())
        return;
    search_environment(&search);
    search_file(&search);
}
