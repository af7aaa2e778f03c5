/* SPDX-License-Identifier: Apache-2.0 */
/* Finds and reads the settings file as the Vulkan utility library does. */
#include "src/report/settings/file.h"

#include <ctype.h>
#include <stdlib.h>
#include <string.h>

#include "src/platform/files.h"
#include "src/platform/process.h"

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
