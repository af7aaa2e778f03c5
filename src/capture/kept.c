/* SPDX-License-Identifier: Apache-2.0 */
#include "src/capture/kept.h"

#include <stdlib.h>
#include <string.h>

/* A line, which the lists of several structures may have: those that were updated or copied from
 * what it builds. */
struct kept_line {
    uint32_t references;
    bool is_in_place; /* an update of what was there */
    bool is_written;
    size_t size;
    char text[];
};

struct kept_list {
    uint32_t count;
    struct kept_line *lines[];
};

static void let_go(struct capture_folder *folder, struct kept_line *line)
{
    if (--line->references)
        return;
    if (folder)
        capture_folder_let_go(folder, line->text, line->size);
    free(line);
}

static void free_list(struct capture_folder *folder, struct kept_list *list)
{
    for (uint32_t i = 0; list && i < list->count; i++)
        let_go(folder, list->lines[i]);
    free(list);
}

void capture_kept_remove(struct capture_kept *kept, struct capture_folder *folder, uint64_t id)
{
    if (id)
        free_list(folder, handle_table_remove(&kept->structures, id));
}

static struct kept_line *make_line(const char *text, size_t size, bool is_in_place)
{
    struct kept_line *line = malloc(sizeof(*line) + size);
    if (!line)
        return NULL;
    *line = (struct kept_line){.references = 1, .is_in_place = is_in_place, .size = size};
    memcpy(line->text, text, size);
    return line;
}

/* A new list: the lines of `source`, which may be NULL, and then `line`. Another update in place
 * makes those before it needless. */
static struct kept_list *make_list(const struct kept_list *source, struct kept_line *line)
{
    const uint32_t most = source ? source->count : 0;
    struct kept_list *list = malloc(sizeof(*list) + (most + 1) * sizeof(struct kept_line *));
    if (!list)
        return NULL;
    list->count = 0;
    for (uint32_t i = 0; i < most; i++) {
        if (line->is_in_place && source->lines[i]->is_in_place)
            continue;
        source->lines[i]->references++;
        list->lines[list->count++] = source->lines[i];
    }
    list->lines[list->count++] = line;
    return list;
}

void capture_kept_add(struct capture_kept *kept, struct capture_folder *folder, uint64_t dst,
                      uint64_t src, const char *text, size_t size)
{
    const struct kept_list *source = src ? handle_table_find(&kept->structures, src) : NULL;
    struct kept_line *line = !src || source ? make_line(text, size, src == dst) : NULL;
    struct kept_list *list = line ? make_list(source, line) : NULL;
    if (!list) {
        capture_folder_let_go(folder, text, size);
        free(line);
    }
    capture_kept_remove(kept, folder, dst);
    if (list && !handle_table_set(&kept->structures, dst, list))
        free_list(folder, list);
}

void capture_kept_write(struct capture_kept *kept, struct capture_folder *folder, uint64_t id,
                        uint64_t *number)
{
    struct kept_list *list = id ? handle_table_remove(&kept->structures, id) : NULL;
    for (uint32_t i = 0; list && i < list->count; i++) {
        struct kept_line *line = list->lines[i];
        if (line->is_written)
            continue;
        line->is_written = true;
        if (capture_folder_write_held(folder, line->text, line->size))
            capture_folder_add_command(folder, ++*number, true, line->text, line->size);
    }
    free_list(folder, list);
}

static void release_list(void *list)
{
    free_list(NULL, list);
}

void capture_kept_release(struct capture_kept *kept)
{
    handle_table_drop(&kept->structures, release_list);
}
