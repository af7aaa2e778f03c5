/* SPDX-License-Identifier: Apache-2.0 */
/* Runs a fuzz target without a fuzzer. */
#include <dirent.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fuzz.h"
#include "tests/unit/random.h"

enum { INPUT_MAX = 1 << 16, PATH_SIZE = 1024 };

static uint8_t input[INPUT_MAX];
static size_t input_size;

static bool read_file(const char *path)
{
    FILE *file = fopen(path, "rb");
    if (!file) {
        fprintf(stderr, "%s: can't be read\n", path);
        return false;
    }
    input_size = fread(input, 1, sizeof(input), file);
    fclose(file);
    return true;
}

static int run_file(const char *path)
{
    if (!read_file(path))
        return 1;
    LLVMFuzzerTestOneInput(input, input_size);
    return 0;
}

/* In the order of the names, so that the outcome is the same everywhere. */
static int run_folder(const char *path, struct dirent **entries, int entry_count, unsigned *count)
{
    int failures = 0;
    for (int i = 0; i < entry_count; i++) {
        char name[PATH_SIZE];
        snprintf(name, sizeof(name), "%s/%s", path, entries[i]->d_name);
        const bool is_file = entries[i]->d_name[0] != '.';
        free(entries[i]);
        if (!is_file)
            continue;
        failures += run_file(name);
        (*count)++;
    }
    free(entries);
    return failures;
}

int replay(int count, char **paths)
{
    int failures = 0;
    unsigned files = 0;
    for (int i = 0; i < count; i++) {
        struct dirent **entries;
        const int found = scandir(paths[i], &entries, NULL, alphasort);
        failures += found >= 0 ? run_folder(paths[i], entries, found, &files) : run_file(paths[i]);
        files += found < 0;
    }
    printf("%u files\n", files);
    return files == 0 ? 1 : failures;
}

int replay_random(uint32_t count)
{
    enum { SIZE_MOST = 1024 };
    struct random random = random_of("replay");
    for (uint32_t i = 0; i < count; i++) {
        input_size = random_below(&random, SIZE_MOST);
        for (size_t j = 0; j < input_size; j++)
            input[j] = (uint8_t)random_below(&random, 256);
        LLVMFuzzerTestOneInput(input, input_size);
    }
    return 0;
}
