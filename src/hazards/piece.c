/* SPDX-License-Identifier: Apache-2.0 */
/* The marks of a piece. */
#include <stdlib.h>
#include <string.h>

#include "src/base/array.h"
#include "src/hazards/ranges.h"

void piece_clear_notes(struct piece *piece)
{
    if (!piece->notes)
        return;
    free(piece->notes->reads);
    free(piece->notes->barriers);
    free(piece->notes);
    piece->notes = NULL;
}

static bool notes_create(struct piece *piece)
{
    if (!piece->notes)
        piece->notes = calloc(1, sizeof(*piece->notes));
    return piece->notes;
}

bool piece_add_read(struct piece *piece, access_mark read, uint64_t first)
{
    access_mark *free_element = NULL, *before = NULL;
    for (uint32_t i = 0; i < piece_read_count(piece); i++) {
        access_mark *other = piece_read(piece, i);
        if (!*other) {
            free_element = free_element ? free_element : other;
        } else if (marks_have_same_source(*other, read)) {
            if (mark_number(*other) >= first) {
                *other = read;
                return true;
            }
            if (before) {
                /* Both are of earlier commands. */
                *(*before < *other ? before : other) = read;
                return true;
            }
            before = other;
        }
    }
    if (free_element) {
        *free_element = read;
        return true;
    }
    if (!notes_create(piece))
        return false;
    struct piece_notes *notes = piece->notes;
    if (!ARRAY_HAS_ROOM(notes->reads, notes->read_count, notes->read_capacity))
        return false;
    notes->reads[notes->read_count++] = read;
    return true;
}

bool piece_add_barrier(struct piece *piece, const struct piece_barrier *barrier)
{
    if (!notes_create(piece))
        return false;
    struct piece_notes *notes = piece->notes;
    for (uint32_t i = 0; i < notes->barrier_count; i++) {
        const struct piece_barrier *older = &notes->barriers[i];
        if (older->queue == barrier->queue && !(barrier->dst & ~older->dst) &&
            !(barrier->dst_kinds & ~older->dst_kinds))
            return true;
    }
    if (notes->barrier_count == PIECE_BARRIERS_MAX) {
        piece->write = 0;
        notes->barrier_count = 0;
        return true;
    }
    if (!ARRAY_HAS_ROOM(notes->barriers, notes->barrier_count, notes->barrier_capacity))
        return false;
    notes->barriers[notes->barrier_count++] = *barrier;
    return true;
}

/* Copies notes to a piece that has none. */
static bool notes_copy(struct piece *to, const struct piece_notes *from)
{
    if (!notes_create(to))
        return false;
    struct piece_notes *notes = to->notes;
    const size_t reads = from->read_count * sizeof(*from->reads),
                 barriers = from->barrier_count * sizeof(*from->barriers);
    notes->reads = reads ? malloc(reads) : NULL;
    notes->barriers = barriers ? malloc(barriers) : NULL;
    if ((reads && !notes->reads) || (barriers && !notes->barriers)) {
        piece_clear_notes(to);
        return false;
    }
    if (reads)
        memcpy(notes->reads, from->reads, reads);
    if (barriers)
        memcpy(notes->barriers, from->barriers, barriers);
    notes->read_count = notes->read_capacity = from->read_count;
    notes->barrier_count = notes->barrier_capacity = from->barrier_count;
    return true;
}

/* Splits the piece at the cursor in two. */
static bool split(struct ranges *ranges, struct cursor cursor, uint64_t at)
{
    struct piece second = *cursor_piece(cursor);
    const struct piece_notes *notes = second.notes;
    second.begin = at;
    second.notes = NULL;
    if (notes && !notes_copy(&second, notes))
        return false;
    struct cursor behind = cursor;
    cursor_step(&behind);
    struct piece *new = ranges_insert(ranges, &behind, at, second.end);
    if (!new) {
        piece_clear_notes(&second);
        return false;
    }
    *new = second;
    /* The insertion may have moved the first part to another leaf. */
    struct cursor first = {behind.leaf, behind.piece - 1};
    if (behind.piece == 0)
        first = (struct cursor){behind.leaf->prev, behind.leaf->prev->count - 1};
    cursor_piece(first)->end = at;
    return true;
}

bool ranges_cut(struct ranges *ranges, uint64_t at)
{
    const struct cursor cursor = ranges_find(ranges, at);
    const struct piece *piece = cursor_piece(cursor);
    return !piece || piece->begin >= at || split(ranges, cursor, at);
}

struct piece *ranges_trim(struct ranges *ranges, struct cursor *cursor, uint64_t begin,
                          uint64_t end)
{
    struct piece *piece = cursor_piece(*cursor);
    const uint64_t from = piece->begin, to = piece->end;
    if (from >= begin && to <= end)
        return piece;
    if ((from < begin && !ranges_cut(ranges, begin)) || (to > end && !ranges_cut(ranges, end)))
        return NULL;
    *cursor = ranges_find(ranges, from < begin ? begin : from);
    return cursor_piece(*cursor);
}
