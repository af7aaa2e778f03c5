/* SPDX-License-Identifier: Apache-2.0 */
/* A table of hashes of lines, in static storage without constructor or destructor. */
#include "src/report/settings/reported_lines.h"

#include <stdatomic.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "src/platform/process.h"
#include "src/report/words.h"

enum { LINES_MAX = 64, LINE_SIZE = 1024 };

static _Atomic uint64_t lines[LINES_MAX]; /* 0: unused */

static uint64_t hash_of(const char *line)
{
    uint64_t hash = XXH64(line, strlen(line), 0);
    return hash ? hash : 1;
}

/* Removed lines leave empty slots, and a line may be behind one, so all slots are searched first.
 * If two threads add the same line at the same time, one of them finds it at the first empty slot.
 */
bool reported_lines_add(const char *line)
{
    const uint64_t hash = hash_of(line);
    for (unsigned i = 0; i < LINES_MAX; i++)
        if (atomic_load(&lines[i]) == hash)
            return false;
    for (unsigned i = 0; i < LINES_MAX; i++) {
        uint64_t found = 0;
        if (atomic_compare_exchange_strong(&lines[i], &found, hash))
            return true;
        if (found == hash)
            return false;
    }
    return true;
}

void reported_lines_remove(const char *line)
{
    const uint64_t hash = hash_of(line);
    for (unsigned i = 0; i < LINES_MAX; i++) {
        uint64_t found = hash;
        if (atomic_compare_exchange_strong(&lines[i], &found, 0))
            return;
    }
}

void reported_lines_keep(void)
{
    process_keep_library((const void *)lines);
}

void kept_lines_add(struct kept_lines *kept, const char *line)
{
    char **more = realloc(kept->lines, (kept->count + 1) * sizeof(*more));
    if (!more)
        return;
    kept->lines = more;
    more[kept->count] = strdup(line);
    if (more[kept->count])
        kept->count++;
}

void kept_lines_free(struct kept_lines *kept)
{
    for (size_t i = 0; i < kept->count; i++)
        free(kept->lines[i]);
    free(kept->lines);
    *kept = (struct kept_lines){0};
}

void kept_lines_append(struct kept_lines *kept, const char *says, const struct value *values,
                       uint32_t count)
{
    char line[LINE_SIZE];
    struct text_buffer text;
    text_begin(&text, line, sizeof(line));
    words_append(&(const struct words){.text = &text}, says, values, count);
    kept_lines_add(kept, line);
}
