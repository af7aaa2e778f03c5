/* SPDX-License-Identifier: Apache-2.0 */
/* Arrays and lists that grow. */
#include "src/base/array.h"

#include <stdlib.h>
#include <string.h>

enum { FIRST_CAPACITY = 4 };

bool array_has_room(void *items, uint32_t count, uint32_t *capacity, size_t size)
{
    void *moved;
    if (count < *capacity)
        return true;
    if (*capacity > UINT32_MAX / 2)
        return false;
    uint32_t larger = *capacity ? *capacity * 2 : FIRST_CAPACITY;
    memcpy(&moved, items, sizeof(moved));
    moved = realloc(moved, larger * size);
    if (!moved)
        return false;
    memcpy(items, &moved, sizeof(moved));
    *capacity = larger;
    return true;
}

/* ---- chunked lists */

static char *items_of(struct chunk *chunk)
{
    return (char *)(chunk + 1);
}

static void make_last(struct chunk_list *list, struct chunk *chunk, char *next)
{
    list->last = chunk;
    list->next = next;
    list->limit = chunk->limit;
}

bool chunk_list_grow(struct chunk_list *list, struct chunk_sizes sizes)
{
    struct chunk *chunk = list->spare;
    if (chunk) {
        list->spare = chunk->next;
        __builtin_prefetch(list->spare, 1); /* the next call takes the chunk after this one */
    } else {
        chunk = malloc(sizeof(*chunk) + sizes.items);
    }
    if (!chunk)
        return false;
    chunk->next = NULL;
    chunk->limit = items_of(chunk) + sizes.items - sizes.room + 1;
    if (list->last) {
        list->last->end = list->next;
        list->last->next = chunk;
    } else {
        list->first = chunk;
        list->start = items_of(chunk);
    }
    make_last(list, chunk, items_of(chunk));
    return true;
}

void chunk_list_cut(struct chunk_list *list, struct chunk_place place)
{
    struct chunk *kept = place.chunk ? place.chunk : list->first;
    if (!kept)
        return;
    if (kept->next) {
        list->last->next = list->spare;
        list->spare = kept->next;
        kept->next = NULL;
    }
    make_last(list, kept, place.chunk ? place.next : items_of(kept));
}

void *chunk_list_at(const struct chunk_list *list, struct chunk_place *place,
                    const struct chunk_place *end)
{
    if (!place->chunk && list->first)
        *place = (struct chunk_place){list->first, items_of(list->first)};
    if (place->next == end->next || !end->chunk)
        return NULL;
    struct chunk *chunk = place->chunk;
    if (chunk != end->chunk && place->next == chunk->end) {
        *place = (struct chunk_place){chunk->next, items_of(chunk->next)};
        if (place->next == end->next)
            return NULL;
    }
    return place->next;
}

static void free_chunks(struct chunk *chunk)
{
    while (chunk) {
        struct chunk *next = chunk->next;
        free(chunk);
        chunk = next;
    }
}

void chunk_list_free(struct chunk_list *list)
{
    free_chunks(list->first);
    free_chunks(list->spare);
}
