/* SPDX-License-Identifier: Apache-2.0 */
/* Finds out where a setting came from, and how it was written. The Vulkan utility library merges
 * the sources and does not say which one it took, so they are searched again here, in its order. */
#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "src/platform/files.h"
#include "src/platform/process.h"
#include "src/report/settings/file.h"
#include "src/report/settings/source.h"

enum { NAME_SIZE = 128, PATH_SHOWN = 400 };

/* The library accepts names with the layer's vendor, without it, and without the layer's name. */
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

/* Sets `value` to a copy of the value; NULL if the file lacks the key, or memory runs out. Returns
 * whether the file has the key. */
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
    while (!found && settings_file_next(file, &buffer, &size, &line))
        found = line.value && strncmp(line.name, prefix, strlen(prefix)) == 0 &&
                strcmp(line.name + strlen(prefix), key) == 0;
    *value = found ? strdup(line.value) : NULL;
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

VkResult settings_find_outside(const char *key, char **text)
{
    char name[NAME_SIZE], path[SETTINGS_PATH_SIZE];
    bool found = find_variable(key, name);
    if (found)
        *text = strdup(process_variable(name));
    else
        found = read_file(key, path, text);
    return found && !*text ? VK_ERROR_OUT_OF_HOST_MEMORY : VK_SUCCESS;
}

void settings_append_origin(struct text_buffer *text, const char *key)
{
    char name[NAME_SIZE], path[SETTINGS_PATH_SIZE];
    bool is_elevated = process_is_elevated();
    if (!is_elevated && find_variable(key, name)) {
        text_append(text, "environment variable %s", name);
    } else if (!is_elevated && file_has(key, path)) {
        text_append(text, "file ");
        text_append_quoted(text, path, PATH_SHOWN);
    } else {
        text_append(text, "VkLayerSettingsCreateInfoEXT");
    }
}

bool settings_has_comma(const char *key)
{
    char *value;
    if (settings_find_outside(key, &value) != VK_SUCCESS || !value)
        return true;
    bool has_comma = strchr(value, ',');
    free(value);
    return has_comma;
}
