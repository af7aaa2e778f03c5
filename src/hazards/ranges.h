/* SPDX-License-Identifier: Apache-2.0 */
/* A mark: the number, queue and kind of an access in one word. 0 is no mark: numbers begin at 1.
 * Among marks of the same queue and kind, the greater one is the later access. */
#ifndef ASSAY_HAZARDS_RANGES_H
#define ASSAY_HAZARDS_RANGES_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "src/hazards/hazards.h"

typedef uint64_t access_mark; /* 54 bits of number, 5 of queue, 5 of kind */

_Static_assert(HAZARD_QUEUES <= 32 && ACCESS_KINDS <= 32, "both have 5 bits");

static inline access_mark mark_of(uint64_t number, uint32_t queue, enum access_kind kind)
{
    return number << 10 | queue << 5 | kind;
}

static inline uint64_t mark_number(access_mark mark)
{
    return mark >> 10;
}

static inline uint32_t mark_queue(access_mark mark)
{
    return mark >> 5 & 31;
}

static inline enum access_kind mark_kind(access_mark mark)
{
    return (enum access_kind)(mark & 31);
}

static inline bool marks_have_same_source(access_mark a, access_mark b)
{
    return ((a ^ b) & 1023) == 0;
}

/* ---- The last accesses of each byte of a memory object: disjoint pieces [begin, end) in ascending
 * order. Neighbours that are alike are not merged.
 *
 * Pieces are in a list of leaves of up to LEAF_PIECES, none of which is empty. A sorted index has
 * most leaves; it is renewed when searches and changes together have taken as many steps as there
 * are leaves. Accesses mostly walk along a few streams, such as structures, scratch and vertices: a
 * finger remembers where each of these has been. */

enum { LEAF_PIECES = 64, RANGE_FINGERS = 8, INLINE_READS = 4, PIECE_BARRIERS_MAX = 64 };

/* A buffer barrier that has made the last write of a piece available. It continues on its queue. */
struct piece_barrier {
    uint64_t number; /* of its command */
    uint32_t queue;
    stage_set dst;
    kind_set dst_kinds; /* to which the write is visible */
};

/* What few pieces have. */
struct piece_notes {
    access_mark *reads; /* further ones */
    struct piece_barrier *barriers;
    uint32_t read_count, read_capacity, barrier_count, barrier_capacity;
};

struct piece {
    uint64_t begin, end;
    access_mark write;               /* the last one, or 0 */
    access_mark reads[INLINE_READS]; /* since then; unused elements are 0 */
    struct piece_notes *notes;       /* owned, or NULL */
};

_Static_assert(sizeof(struct piece) == 64, "a cache line");

struct leaf {
    struct leaf *prev, *next;
    uint32_t count; /* 0 once it is removed */
    _Alignas(64) struct piece pieces[LEAF_PIECES];
};

/* A place in front of a piece of a leaf; at the end, `leaf` is NULL. */
struct cursor {
    struct leaf *leaf;
    uint32_t piece;
};

struct ranges {
    struct leaf *first, *last;
    struct range_index {
        uint64_t first; /* begin of the leaf's first piece at some time */
        struct leaf *leaf;
    } * index;
    size_t index_count, index_capacity;
    size_t leaf_count, debt; /* steps since the index was renewed */
    struct leaf *removed;    /* to be freed then */
    uint64_t *piece_count;   /* of this and other memory objects */
    struct cursor fingers[RANGE_FINGERS];
    uint64_t used[RANGE_FINGERS], find_count; /* when a finger was used, in searches */
    uint32_t recent_finger;
};

/* Frees everything but the count. */
void ranges_release(struct ranges *ranges);

/* Returns the first piece that ends behind `at`. */
struct cursor ranges_find(struct ranges *ranges, uint64_t at);

/* Returns the piece, or NULL at the end. */
static inline struct piece *cursor_piece(struct cursor cursor)
{
    return cursor.leaf ? &cursor.leaf->pieces[cursor.piece] : NULL;
}

/* Goes on to the next piece. */
static inline void cursor_step(struct cursor *cursor)
{
    if (++cursor->piece == cursor->leaf->count)
        *cursor = (struct cursor){cursor->leaf->next, 0};
}

/* Inserts a piece [begin, end) without marks before the cursor, which then is at the new piece.
 * Returns NULL, and changes nothing, if memory runs out. */
struct piece *ranges_insert(struct ranges *ranges, struct cursor *cursor, uint64_t begin,
                            uint64_t end);
/* Splits the piece that begins before `at` and ends behind it, if there is one. Cursors are invalid
 * afterwards. Returns false, and changes nothing, if memory runs out. */
bool ranges_cut(struct ranges *ranges, uint64_t at);
/* Cuts the piece at the cursor to its part within [begin, end), which is not empty. Returns that
 * part, at which the cursor is then; or NULL if memory runs out. */
struct piece *ranges_trim(struct ranges *ranges, struct cursor *cursor, uint64_t begin,
                          uint64_t end);
/* Removes the pieces from the cursor on that begin before `end`. The cursor then is at what
 * follows. */
void ranges_remove(struct ranges *ranges, struct cursor *cursor, uint64_t end);
/* Removes the pieces that are not wanted. `is_wanted` may remove marks from a piece. */
void ranges_sweep(struct ranges *ranges, bool (*is_wanted)(struct piece *piece, void *context),
                  void *context);

/* Adds a read; `first` is the first number of the command that reads. For each queue and kind, the
 * last read of this command stays, and the last read before. Returns false if memory runs out. */
bool piece_add_read(struct piece *piece, access_mark read, uint64_t first);
/* Adds a barrier, unless an older one of the same queue has the same stages and kinds, or more.
 * A write with too many of them counts as ordered. Returns false if memory runs out. */
bool piece_add_barrier(struct piece *piece, const struct piece_barrier *barrier);
/* Frees the notes. */
void piece_clear_notes(struct piece *piece);

static inline uint32_t piece_read_count(const struct piece *piece)
{
    return INLINE_READS + (piece->notes ? piece->notes->read_count : 0);
}

/* An element may be 0. */
static inline access_mark *piece_read(struct piece *piece, uint32_t i)
{
    return i < INLINE_READS ? &piece->reads[i] : &piece->notes->reads[i - INLINE_READS];
}

#endif
