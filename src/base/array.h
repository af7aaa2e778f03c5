/* SPDX-License-Identifier: Apache-2.0 */
/* Arrays that grow by one element at a time, and lists of chunks. The owner of an array keeps it,
 * its count and its capacity, all of which are zero at first, and frees the array. */
#ifndef ASSAY_BASE_ARRAY_H
#define ASSAY_BASE_ARRAY_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Makes room for one more element of `size` bytes. `items` is the address of the array's pointer,
 * which changes if the array moves. Returns false without memory: nothing changes then. */
bool array_has_room(void *items, uint32_t count, uint32_t *capacity, size_t size);

/* Whether there is room for one more element now. The arguments are variables. */
#define ARRAY_HAS_ROOM(items, count, capacity)                                                     \
    array_has_room(&(items), count, &(capacity), sizeof(*(items)))

/* ---- A list of items of several sizes, stored in chunks. Items never move while the list grows.
 * Chunks that become empty are reused. A zero-initialized list is empty. The list has no lock; the
 * caller serializes access. */

/* A chunk; its items follow the structure in memory. */
struct chunk {
    struct chunk *next;
    char *end;   /* end of the items; unset in the last chunk */
    char *limit; /* from here on, the chunk may lack room */
};

struct chunk_list {
    struct chunk *first, *last, *spare;
    /* `start` is the first item. `next` is free memory at the end of the last chunk, and `limit` is
     * that chunk's. All three are NULL if the list has no chunk. */
    char *start, *next, *limit;
};

/* A position after an item, or before all items if `chunk` is NULL. */
struct chunk_place {
    struct chunk *chunk;
    char *next;
};

/* The sizes of a list, in bytes, the same in all calls for one list: the items of a chunk, and the
 * room that chunk_list_make_room() guarantees. */
struct chunk_sizes {
    size_t items, room;
};

/* Appends a chunk. Returns false if memory runs out. */
bool chunk_list_grow(struct chunk_list *list, struct chunk_sizes sizes);

/* Makes room at `next`; the caller advances `next` by the items that it writes. Returns false if
 * memory runs out. */
static inline bool chunk_list_make_room(struct chunk_list *list, struct chunk_sizes sizes)
{
    return list->next < list->limit || chunk_list_grow(list, sizes);
}

/* Returns the position after the last item. */
static inline struct chunk_place chunk_list_end(const struct chunk_list *list)
{
    return (struct chunk_place){list->last, list->next};
}

/* Removes all items after a position. The first chunk stays; later chunks become spare. */
void chunk_list_cut(struct chunk_list *list, struct chunk_place place);

static inline bool chunk_list_is_empty(const struct chunk_list *list)
{
    return list->next == list->start;
}

/* Removes all items. */
static inline void chunk_list_clear(struct chunk_list *list)
{
    if (list->first != list->last)
        chunk_list_cut(list, (struct chunk_place){NULL, NULL});
    list->next = list->start;
}

/* Returns the item at a position, or NULL at the end, which is a position of the list. The caller
 * then advances `place->next` by the size of the item. Reads nothing behind `end`, so another
 * thread may add items there meanwhile. */
void *chunk_list_at(const struct chunk_list *list, struct chunk_place *place,
                    const struct chunk_place *end);

/* Frees all chunks. The list must not be used afterwards. */
void chunk_list_free(struct chunk_list *list);

#endif
