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

enum { LINES_MAX = 64 };

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

void kept_lines_add(void *context, const char *line)
{
    struct kept_lines *kept = context;
    char **more = realloc(kept->lines, (kept->count + 1) * sizeof(*more));
    if (!more)
        return;
    kept->lines = more;
    more[kept->count] = strdup(line);
    if (more[kept->count])
        kept->count++;
}
