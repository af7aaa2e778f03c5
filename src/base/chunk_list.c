/* SPDX-License-Identifier: Apache-2.0 */
/* Chunked lists. */
#include "src/base/chunk_list.h"

#include <stdlib.h>

static char *items_of(struct chunk *chunk)
{
    return (char *)(chunk + 1);
}

static void make_last(struct chunk_list *list, size_t size, struct chunk *chunk, char *next)
{
    list->last = chunk;
    list->next = next;
    list->limit = items_of(chunk) + (CHUNK_ITEMS - CHUNK_ITEMS_AT_ONCE + 1) * size;
}

bool chunk_list_grow(struct chunk_list *list, size_t size)
{
    struct chunk *chunk = list->spare;
    if (chunk) {
        list->spare = chunk->next;
        __builtin_prefetch(list->spare, 1); /* the next call takes the chunk after this one */
    } else {
        chunk = malloc(sizeof(*chunk) + CHUNK_ITEMS * size);
    }
    if (!chunk)
        return false;
    chunk->next = NULL;
    if (list->last) {
        list->last->next = chunk;
        list->last->end = list->next;
    } else {
        list->first = chunk;
        list->start = items_of(chunk);
    }
    make_last(list, size, chunk, items_of(chunk));
    return true;
}

void chunk_list_cut(struct chunk_list *list, size_t size, struct chunk_place place)
{
    struct chunk *kept = place.chunk ? place.chunk : list->first;
    if (!kept)
        return;
    if (kept->next) {
        list->last->next = list->spare;
        list->spare = kept->next;
        kept->next = NULL;
    }
    make_last(list, size, kept, place.chunk ? place.next : items_of(kept));
}

void *chunk_list_next(const struct chunk_list *list, size_t size, struct chunk_place *place)
{
    if (!place->chunk && list->first)
        *place = (struct chunk_place){list->first, items_of(list->first)};
    struct chunk *chunk = place->chunk;
    if (chunk && chunk->next && place->next == chunk->end)
        *place = (struct chunk_place){chunk->next, items_of(chunk->next)};
    if (place->next == list->next)
        return NULL;
    char *item = place->next;
    place->next += size;
    return item;
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
