/* SPDX-License-Identifier: Apache-2.0 */
/* Lists of items of one size, in chunks, so that growing moves nothing; emptied chunks are kept for
 * the items that come next. Zero-initialized is empty. Not locked. */
#ifndef ASSAY_BASE_CHUNK_LIST_H
#define ASSAY_BASE_CHUNK_LIST_H

#include <stdbool.h>
#include <stddef.h>

/* Of a chunk at most; and as many come without asking for room one by one. */
enum { CHUNK_ITEMS = 64, CHUNK_ITEMS_AT_ONCE = 5 };

/* Its items lie behind it. */
struct chunk {
    struct chunk *next;
    char *end; /* of its items, unless it is the last */
};

struct chunk_list {
    struct chunk *first, *last, *spare;
    /* Where the first item comes; and, in the last chunk, the next, and from where on there may be
     * no room for CHUNK_ITEMS_AT_ONCE. All are NULL before there is a chunk. */
    char *start, *next, *limit;
};

/* A place behind an item, or, of a null chunk, before all. */
struct chunk_place {
    struct chunk *chunk;
    char *next;
};

/* Adds a chunk; false without memory. */
bool chunk_list_grow(struct chunk_list *list, size_t size);

/* Makes room for CHUNK_ITEMS_AT_ONCE, at `next`, which moves behind those that the caller adds.
 * `size` is that of an item in bytes, the same for all of a list. False without memory. */
static inline bool chunk_list_make_room(struct chunk_list *list, size_t size)
{
    return list->next < list->limit || chunk_list_grow(list, size);
}

static inline struct chunk_place chunk_list_end(const struct chunk_list *list)
{
    return (struct chunk_place){list->last, list->next};
}

/* Takes the items behind a place out again. The first chunk stays in its place, others are spare.
 */
void chunk_list_cut(struct chunk_list *list, size_t size, struct chunk_place place);

static inline bool chunk_list_is_empty(const struct chunk_list *list)
{
    return list->next == list->start;
}

/* Takes out all. */
static inline void chunk_list_clear(struct chunk_list *list, size_t size)
{
    if (list->first != list->last)
        chunk_list_cut(list, size, (struct chunk_place){NULL, NULL});
    list->next = list->start;
}

/* The item at a place, which moves behind it; NULL at the end. */
void *chunk_list_next(const struct chunk_list *list, size_t size, struct chunk_place *place);

void chunk_list_free(struct chunk_list *list);

#endif
