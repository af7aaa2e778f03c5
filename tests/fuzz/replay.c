/* SPDX-License-Identifier: Apache-2.0 */
#include "replay.h"

#include <dirent.h>
#include <stdio.h>
#include <string.h>

#include "fuzz.h"

enum { INPUT_MAX = 1 << 16, PATH_SIZE = 1024 };

static int run_file(const char *path)
{
    static uint8_t input[INPUT_MAX];
    FILE *file = fopen(path, "rb");
    if (!file) {
        fprintf(stderr, "%s: can't be read\n", path);
        return 1;
    }
    size_t size = fread(input, 1, sizeof(input), file);
    fclose(file);
    LLVMFuzzerTestOneInput(input, size);
    return 0;
}

static int run_folder(const char *path, DIR *folder, unsigned *count)
{
    int failures = 0;
    for (const struct dirent *entry; (entry = readdir(folder));) {
        char name[PATH_SIZE];
        if (entry->d_name[0] == '.')
            continue;
        snprintf(name, sizeof(name), "%s/%s", path, entry->d_name);
        failures += run_file(name);
        (*count)++;
    }
    return failures;
}

int replay(int count, char **paths)
{
    int failures = 0;
    unsigned files = 0;
    for (int i = 0; i < count; i++) {
        DIR *folder = opendir(paths[i]);
        failures += folder ? run_folder(paths[i], folder, &files) : run_file(paths[i]);
        files += !folder;
        if (folder)
            closedir(folder);
    }
    printf("%u files\n", files);
    return files == 0 ? 1 : failures;
}
