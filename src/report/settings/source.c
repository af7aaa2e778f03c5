/* SPDX-License-Identifier: Apache-2.0 */
/* Reads settings from their sources. */
#include "src/report/settings/source.h"

#include <ctype.h>
#include <errno.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "src/base/letter_case.h"
#include "src/platform/files.h"
#include "src/platform/process.h"
#include "src/report/words.h"

static bool setting_is_readable(const VkLayerSettingEXT *setting)
{
    if (!setting->pLayerName || strcmp(setting->pLayerName, SETTINGS_LAYER) != 0 ||
        !setting->pSettingName || !setting->pSettingName[0] ||
        (setting->valueCount && !setting->pValues))
        return false;
    if (setting->type != VK_LAYER_SETTING_TYPE_STRING_EXT)
        return true;
    const char *const *texts = setting->pValues;
    for (uint32_t i = 0; i < setting->valueCount; i++)
        if (!texts[i])
            return false;
    return true;
}

static uint32_t collect(const VkInstanceCreateInfo *create_info, VkLayerSettingEXT *given)
{
    uint32_t count = 0;
    for (const VkBaseInStructure *link = create_info->pNext; link; link = link->pNext) {
        const VkLayerSettingsCreateInfoEXT *info = (const VkLayerSettingsCreateInfoEXT *)link;
        if (link->sType != VK_STRUCTURE_TYPE_LAYER_SETTINGS_CREATE_INFO_EXT || !info->pSettings)
            continue;
        for (uint32_t i = 0; i < info->settingCount; i++) {
            if (!setting_is_readable(&info->pSettings[i]))
                continue;
            if (given)
                given[count] = info->pSettings[i];
            count++;
        }
    }
    return count;
}

VkResult settings_source_open(struct settings_source *source,
                              const VkInstanceCreateInfo *create_info)
{
    *source = (struct settings_source){.given_count = collect(create_info, NULL)};
    if (!source->given_count)
        return VK_SUCCESS;
    source->given = malloc(source->given_count * sizeof(*source->given));
    if (!source->given)
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    collect(create_info, source->given);
    return VK_SUCCESS;
}

void settings_source_close(struct settings_source *source)
{
    free(source->given);
}

/* ---- settings of VK_EXT_layer_settings, as text */

enum { NUMBER_SIZE = 32 }; /* bytes of any number; a large double is cut */

static const VkLayerSettingEXT *find_given(const struct settings_source *source, const char *key)
{
    for (uint32_t i = 0; i < source->given_count; i++)
        if (strcmp(source->given[i].pSettingName, key) == 0)
            return &source->given[i];
    return NULL;
}

/* Returns false if the type is not a number type of Vulkan. */
static bool write_number(const VkLayerSettingEXT *setting, uint32_t i, char text[NUMBER_SIZE])
{
#define VALUE(type) (((const type *)setting->pValues)[i])
    switch (setting->type) {
    case VK_LAYER_SETTING_TYPE_BOOL32_EXT:
        snprintf(text, NUMBER_SIZE, "%s", VALUE(VkBool32) ? "true" : "false");
        return true;
    case VK_LAYER_SETTING_TYPE_INT32_EXT:
        snprintf(text, NUMBER_SIZE, "%" PRId32, VALUE(int32_t));
        return true;
    case VK_LAYER_SETTING_TYPE_INT64_EXT:
        snprintf(text, NUMBER_SIZE, "%" PRId64, VALUE(int64_t));
        return true;
    case VK_LAYER_SETTING_TYPE_UINT32_EXT:
        snprintf(text, NUMBER_SIZE, "%" PRIu32, VALUE(uint32_t));
        return true;
    case VK_LAYER_SETTING_TYPE_UINT64_EXT:
        snprintf(text, NUMBER_SIZE, "%" PRIu64, VALUE(uint64_t));
        return true;
    case VK_LAYER_SETTING_TYPE_FLOAT32_EXT:
        snprintf(text, NUMBER_SIZE, "%f", (double)VALUE(float));
        return true;
    case VK_LAYER_SETTING_TYPE_FLOAT64_EXT:
        snprintf(text, NUMBER_SIZE, "%f", VALUE(double));
        return true;
    case VK_LAYER_SETTING_TYPE_STRING_EXT:
    case VK_LAYER_SETTING_TYPE_MAX_ENUM_EXT:
        return false;
    }
#undef VALUE
    return false;
}

static size_t text_size(const VkLayerSettingEXT *setting)
{
    size_t size = 1;
    for (uint32_t i = 0; i < setting->valueCount; i++)
        size += setting->type == VK_LAYER_SETTING_TYPE_STRING_EXT
                    ? strlen(((const char *const *)setting->pValues)[i]) + 1
                    : NUMBER_SIZE;
    return size;
}

static VkResult read_given(const struct settings_source *source, const char *key, char **list)
{
    const VkLayerSettingEXT *setting = find_given(source, key);
    *list = NULL;
    if (!setting || !setting->valueCount)
        return VK_SUCCESS;
    char *end = *list = malloc(text_size(setting));
    if (!end)
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    *end = '\0';
    for (uint32_t i = 0; i < setting->valueCount; i++) {
        char number[NUMBER_SIZE];
        const char *text = number;
        if (setting->type == VK_LAYER_SETTING_TYPE_STRING_EXT) {
            text = ((const char *const *)setting->pValues)[i];
        } else if (!write_number(setting, i, number)) {
            free(*list);
            *list = NULL;
            return VK_SUCCESS;
        }
        if (i)
            *end++ = ',';
        const size_t length = strlen(text);
        memcpy(end, text, length + 1);
        end += length;
    }
    return VK_SUCCESS;
}

/* ---- The environment and the settings file, which count only if the process has no elevated
 * privileges. */

enum { NAME_SIZE = 128, PATH_SHOWN = 400 };

/* Accepts names with the layer's vendor, without it, and without the layer's name, as the Vulkan
 * utility library does, through which other layers read their settings. */
static bool find_variable(const char *key, char name[NAME_SIZE])
{
    static const char *const prefixes[] = {"VK_ASSAY_VALIDATION_", "VK_VALIDATION_", "VK_"};
    for (size_t i = 0; i < sizeof(prefixes) / sizeof(prefixes[0]); i++) {
        snprintf(name, NAME_SIZE, "%s%s", prefixes[i], key);
        for (char *c = name + strlen(prefixes[i]); *c; c++)
            *c = (char)toupper((unsigned char)*c);
        const char *value = process_variable(name);
        if (value && value[0])
            return true;
    }
    return false;
}

/* Sets `value` to a copy of the key's last value; NULL if the file lacks it, or memory runs out.
 * Returns whether the file has the key. An empty value does not count. */
static bool read_file(const char *key, char path[SETTINGS_PATH_SIZE], char **value)
{
    static const char prefix[] = "assay_validation.";
    struct settings_line line;
    char *buffer = NULL;
    size_t size = 0;
    bool found = false;
    *value = NULL;
    settings_file_find(path);
    FILE *file = file_open_to_read(path);
    if (!file)
        return false;
    while (settings_file_next(file, &buffer, &size, &line)) {
        if (!line.value || strncmp(line.name, prefix, strlen(prefix)) != 0 ||
            strcmp(line.name + strlen(prefix), key) != 0)
            continue;
        free(*value);
        found = line.value[0];
        *value = found ? strdup(line.value) : NULL;
    }
    free(buffer);
    fclose(file);
    return found;
}

static bool file_has(const char *key, char path[SETTINGS_PATH_SIZE])
{
    char *value;
    bool found = read_file(key, path, &value);
    free(value);
    return found;
}

/* Sets `text` to the value of a key in the environment or the file; NULL if it is in neither. */
static VkResult read_outside(const char *key, char **text)
{
    char name[NAME_SIZE], path[SETTINGS_PATH_SIZE];
    bool found = find_variable(key, name);
    if (found)
        *text = strdup(process_variable(name));
    else
        found = read_file(key, path, text);
    return found && !*text ? VK_ERROR_OUT_OF_HOST_MEMORY : VK_SUCCESS;
}

VkResult settings_source_text(const struct settings_source *source, const char *key, char **text)
{
    *text = NULL;
    VkResult result = process_is_elevated() ? VK_SUCCESS : read_outside(key, text);
    return result == VK_SUCCESS && !*text ? read_given(source, key, text) : result;
}

/* Where a value has no comma, its entries may be separated as paths are. */
VkResult settings_source_list(const struct settings_source *source, const char *key, char **list)
{
    VkResult result = settings_source_text(source, key, list);
    if (*list && !strchr(*list, ','))
        for (char *c = *list; *c; c++)
            if (*c == FILES_LIST_SEPARATOR)
                *c = ',';
    return result;
}

void settings_append_origin(struct text_buffer *text, const char *key)
{
    char name[NAME_SIZE], path[SETTINGS_PATH_SIZE];
    bool is_elevated = process_is_elevated();
    if (!is_elevated && find_variable(key, name))
        text_say(text, "environment variable {}", phrase(name));
    else if (!is_elevated && file_has(key, path))
        text_say(text, "file {}", quoted(path, PATH_SHOWN));
    else
        text_append(text, "VkLayerSettingsCreateInfoEXT");
}

/* ---- the settings file */

static const char file_name[] = "vk_layer_settings.txt";

enum settings_path settings_file_find(char path[SETTINGS_PATH_SIZE])
{
    const char *given = process_variable("VK_LAYER_SETTINGS_PATH");
    bool is_given = given && given[0];
    if (file_find_users_settings(path, SETTINGS_PATH_SIZE))
        return is_given ? SETTINGS_PATH_SECOND : SETTINGS_PATH_USED;
    if (!is_given || file_find_kind(given) == FILE_NONE) {
        snprintf(path, SETTINGS_PATH_SIZE, "%s", file_name);
        return is_given ? SETTINGS_PATH_MISSING : SETTINGS_PATH_USED;
    }
    if (file_find_kind(given) != FILE_FOLDER) {
        snprintf(path, SETTINGS_PATH_SIZE, "%s", given);
        return SETTINGS_PATH_USED;
    }
    snprintf(path, SETTINGS_PATH_SIZE, "%s/%s", given, file_name);
    return file_find_kind(path) != FILE_NONE ? SETTINGS_PATH_USED : SETTINGS_PATH_WITHOUT_FILE;
}

static char *trim(char *text)
{
    while (isspace((unsigned char)*text))
        text++;
    size_t length = strlen(text);
    while (length && isspace((unsigned char)text[length - 1]))
        text[--length] = '\0';
    return text;
}

bool settings_file_next(FILE *file, char **buffer, size_t *size, struct settings_line *line)
{
    while (file_read_line(file, buffer, size)) {
        (*buffer)[strcspn(*buffer, "#")] = '\0';
        char *equals = strchr(*buffer, '=');
        if (equals)
            *equals = '\0';
        line->name = trim(*buffer);
        line->value = equals ? trim(equals + 1) : NULL;
        if (line->name[0])
            return true;
    }
    return false;
}

/* ---- values */

char *value_next_entry(char **list)
{
    while (*list) {
        char *entry = *list, *comma = strchr(entry, ',');
        *list = comma ? comma + 1 : NULL;
        if (comma)
            *comma = '\0';
        entry = trim(entry);
        if (*entry)
            return entry;
    }
    return NULL;
}

bool value_read_number(char *list, uint32_t *value)
{
    const char *digits = value_next_entry(&list);
    if (!digits || !isdigit((unsigned char)digits[0]) || value_next_entry(&list))
        return false;
    char *end;
    errno = 0;
    unsigned long long number = strtoull(digits, &end, 10);
    if (*end || errno || number > UINT32_MAX)
        return false;
    *value = (uint32_t)number;
    return true;
}
