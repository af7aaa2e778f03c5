/* SPDX-License-Identifier: Apache-2.0 */
/* Finds unknown keys, so that a misspelt key is reported. The utility library can't list the keys
 * of the environment and of the file, so both are searched here. The file is searched in the same
 * places as in that library. */
#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>
#include <unistd.h>

#include "src/base/elevated.h"
#include "src/report/settings/source.h"

extern char **environ;

#define FILE_PREFIX "assay_validation."
#define ENVIRONMENT_PREFIX "VK_ASSAY_VALIDATION_"

enum { KEY_SIZE = 128, PATH_SIZE = 4096 };

struct search {
    bool (*known)(const char *key);
    void (*visit)(void *context, const char *key);
    void *context;
};

static void search_environment(const struct search *search)
{
    for (char **entry = environ; entry && *entry; entry++) {
        if (strncmp(*entry, ENVIRONMENT_PREFIX, strlen(ENVIRONMENT_PREFIX)) != 0)
            continue;
        char key[KEY_SIZE], name[KEY_SIZE];
        size_t length = 0;
        for (const char *c = *entry + strlen(ENVIRONMENT_PREFIX);
             *c && *c != '=' && length < sizeof(key) - 1; c++)
            key[length++] = (char)tolower((unsigned char)*c);
        key[length] = '\0';
        if (search->known(key))
            continue;
        snprintf(name, sizeof(name), "%.*s", (int)strcspn(*entry, "="), *entry);
        search->visit(search->context, name);
    }
}

static bool is_file(const char *path)
{
    struct stat status;
    return stat(path, &status) == 0 && S_ISREG(status.st_mode);
}

static FILE *open_settings_file(void)
{
    static const char name[] = "vk_layer_settings.txt";
    char path[PATH_SIZE];
    struct stat status;
    const char *data = getenv("XDG_DATA_HOME"), *home = getenv("HOME");
    const char *given = getenv("VK_LAYER_SETTINGS_PATH");

    if (data && data[0])
        snprintf(path, sizeof(path), "%s/vulkan/settings.d/%s", data, name);
    else
        snprintf(path, sizeof(path), "%s/.local/share/vulkan/settings.d/%s", home ? home : "",
                 name);
    if (((data && data[0]) || (home && home[0])) && is_file(path))
        return fopen(path, "re");

    if (!given || stat(given, &status) != 0)
        return fopen(name, "re");
    if (!S_ISDIR(status.st_mode))
        return fopen(given, "re");
    snprintf(path, sizeof(path), "%s/%s", given, name);
    return fopen(path, "re");
}

static void search_line(const struct search *search, char *line)
{
    line[strcspn(line, "#")] = '\0';
    char *equals = strchr(line, '=');
    if (!equals)
        return;
    while (isspace((unsigned char)*line))
        line++;
    while (equals > line && isspace((unsigned char)equals[-1]))
        equals--;
    *equals = '\0';
    if (strncasecmp(line, FILE_PREFIX, strlen(FILE_PREFIX)) == 0 &&
        (strncmp(line, FILE_PREFIX, strlen(FILE_PREFIX)) != 0 ||
         !search->known(line + strlen(FILE_PREFIX))))
        search->visit(search->context, line);
}

static void search_file(const struct search *search)
{
    FILE *file = open_settings_file();
    if (!file)
        return;
    char *line = NULL;
    size_t size = 0;
    while (getline(&line, &size, file) >= 0)
        search_line(search, line);
    free(line);
    fclose(file);
}

void settings_source_unknown(const struct settings_source *source, bool (*known)(const char *key),
                             void (*visit)(void *context, const char *key), void *context)
{
    const struct search search = {known, visit, context};
    for (uint32_t i = 0; i < source->given_info.settingCount; i++) {
        const char *key = source->given[i].pSettingName;
        if (known(key))
            continue;
        char name[KEY_SIZE];
        snprintf(name, sizeof(name), FILE_PREFIX "%s", key);
        visit(context, name);
    }
    if (process_is_elevated())
        return;
    search_environment(&search);
    search_file(&search);
}
