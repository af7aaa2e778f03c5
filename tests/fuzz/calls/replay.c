/* SPDX-License-Identifier: Apache-2.0 */
/* fuzz_calls_replay FOLDER|FILE...: runs the fuzz target without a fuzzer on each file. */
#include <dirent.h>
#include <stdio.h>
#include <string.h>

#include "../fuzz.h"

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

int main(int count, char **arguments)
{
    int failures = count < 2;
    unsigned files = 0;
    for (int i = 1; i < count; i++) {
        DIR *folder = opendir(arguments[i]);
        failures += folder ? run_folder(arguments[i], folder, &files) : run_file(arguments[i]);
        files += !folder;
        if (folder)
            closedir(folder);
    }
    printf("%u streams\n", files);
    return failures > 0 || files == 0;
}
