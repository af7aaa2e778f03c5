/* SPDX-License-Identifier: Apache-2.0 */
/* A list of items of one size, stored in chunks. Items never move while the list grows. Chunks that
 * become empty are reused. A zero-initialized list is empty. The list has no lock; the caller
 * serializes access. */
#ifndef ASSAY_BASE_CHUNK_LIST_H
#define ASSAY_BASE_CHUNK_LIST_H

#include <stdbool.h>
#include <stddef.h>

/* Items per chunk, and the number of items that chunk_list_make_room() guarantees. */
enum { CHUNK_ITEMS = 64, CHUNK_ITEMS_AT_ONCE = 5 };

/* A chunk; its items follow the structure in memory. */
struct chunk {
    struct chunk *next;
    char *end; /* end of the items; unset in the last chunk */
};

struct chunk_list {
    struct chunk *first, *last, *spare;
    /* `start` is the first item. `next` is the free item at the end of the last chunk. From `limit`
     * on, the last chunk may lack room for CHUNK_ITEMS_AT_ONCE items. All three are NULL if the
     * list has no chunk. */
    char *start, *next, *limit;
};

/* A position after an item, or before all items if `chunk` is NULL. */
struct chunk_place {
    struct chunk *chunk;
    char *next;
};

/* Appends a chunk. Returns false if memory runs out. */
bool chunk_list_grow(struct chunk_list *list, size_t size);

/* Makes room for CHUNK_ITEMS_AT_ONCE items at `next`; the caller advances `next` by the items that
 * it writes. `size` is the size of an item in bytes, the same in all calls for one list. Returns
 * false if memory runs out. */
static inline bool chunk_list_make_room(struct chunk_list *list, size_t size)
{
    return list->next < list->limit || chunk_list_grow(list, size);
}

/* Returns the position after the last item. */
static inline struct chunk_place chunk_list_end(const struct chunk_list *list)
{
    return (struct chunk_place){list->last, list->next};
}

/* Removes all items after a position. The first chunk stays; later chunks become spare. */
void chunk_list_cut(struct chunk_list *list, size_t size, struct chunk_place place);

static inline bool chunk_list_is_empty(const struct chunk_list *list)
{
    return list->next == list->start;
}

/* Removes all items. */
static inline void chunk_list_clear(struct chunk_list *list, size_t size)
{
    if (list->first != list->last)
        chunk_list_cut(list, size, (struct chunk_place){NULL, NULL});
    list->next = list->start;
}

/* Returns the item at a position and advances the position, or returns NULL at the end. */
void *chunk_list_next(const struct chunk_list *list, size_t size, struct chunk_place *place);

/* Frees all chunks. The list must not be used afterwards. */
void chunk_list_free(struct chunk_list *list);

#endif
