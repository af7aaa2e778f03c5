/* SPDX-License-Identifier: Apache-2.0 */
/* Finds and reads the settings file as the Vulkan utility library does. */
#include "src/report/settings/file.h"

#include <ctype.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

static const char file_name[] = "vk_layer_settings.txt";

/* Returns false if the user has no home, or a path is too long. */
static bool find_users_file(char path[SETTINGS_PATH_SIZE])
{
    const char *data = getenv("XDG_DATA_HOME"), *home = getenv("HOME");
    bool has_data = data && data[0];
    if (!has_data && !(home && home[0]))
        return false;
    int length = snprintf(path, SETTINGS_PATH_SIZE, "%s%s/vulkan/settings.d/%s",
                          has_data ? data : home, has_data ? "" : "/.local/share", file_name);
    return length > 0 && length < SETTINGS_PATH_SIZE;
}

static bool is_file(const char *path)
{
    struct stat status;
    return stat(path, &status) == 0 && S_ISREG(status.st_mode);
}

enum settings_path settings_file_find(char path[SETTINGS_PATH_SIZE])
{
    const char *given = getenv("VK_LAYER_SETTINGS_PATH");
    struct stat status;
    bool is_given = given && given[0];
    if (find_users_file(path) && is_file(path))
        return is_given ? SETTINGS_PATH_SECOND : SETTINGS_PATH_USED;
    if (!is_given || stat(given, &status) != 0) {
        snprintf(path, SETTINGS_PATH_SIZE, "%s", file_name);
        return is_given ? SETTINGS_PATH_MISSING : SETTINGS_PATH_USED;
    }
    if (!S_ISDIR(status.st_mode)) {
        snprintf(path, SETTINGS_PATH_SIZE, "%s", given);
        return SETTINGS_PATH_USED;
    }
    snprintf(path, SETTINGS_PATH_SIZE, "%s/%s", given, file_name);
    return stat(path, &status) == 0 ? SETTINGS_PATH_USED : SETTINGS_PATH_WITHOUT_FILE;
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
    while (getline(buffer, size, file) >= 0) {
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
