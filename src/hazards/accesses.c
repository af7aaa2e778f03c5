/* SPDX-License-Identifier: Apache-2.0 */
/* Accesses: each is compared with the earlier ones of its bytes, and then replaces them or joins
 * them. */
#include <string.h>

#include "src/hazards/engine.h"

static void piece_set_write(struct piece *piece, access_mark write)
{
    piece->write = write;
    memset(piece->reads, 0, sizeof(piece->reads));
    piece_clear_notes(piece);
}

/* Returns false if memory runs out. */
static bool write_bytes(struct hazards *hazards, struct ranges *ranges, uint64_t number,
                        const struct hazard_access *access)
{
    const uint64_t begin = access->bytes.begin, end = access->bytes.end;
    const access_mark write = mark_of(number, hazards->queue, access->kind);
    struct cursor cursor = ranges_find(ranges, begin);
    struct piece *piece = cursor_piece(cursor);
    if (piece && piece->begin == begin && piece->end == end) {
        hazards_judge(hazards, piece, number, access);
        piece_set_write(piece, write);
        return true;
    }
    if (piece && piece->begin < end) {
        for (struct cursor each = cursor; piece && piece->begin < end;
             cursor_step(&each), piece = cursor_piece(each))
            hazards_judge(hazards, piece, number, access);
        if (!ranges_cut(ranges, begin) || !ranges_cut(ranges, end))
            return false;
        cursor = ranges_find(ranges, begin);
        ranges_remove(ranges, &cursor, end);
    }
    piece = ranges_insert(ranges, &cursor, begin, end);
    if (piece)
        piece->write = write;
    return piece;
}

/* Returns false if memory runs out. */
static bool read_bytes(struct hazards *hazards, struct ranges *ranges, uint64_t number,
                       const struct hazard_access *access)
{
    const uint64_t end = access->bytes.end;
    const access_mark read = mark_of(number, hazards->queue, access->kind);
    struct cursor cursor = ranges_find(ranges, access->bytes.begin);
    for (uint64_t at = access->bytes.begin; at < end;) {
        struct piece *piece = cursor_piece(cursor);
        if (!piece || piece->begin > at) {
            const uint64_t gap_end = piece && piece->begin < end ? piece->begin : end;
            piece = ranges_insert(ranges, &cursor, at, gap_end);
        } else {
            hazards_judge(hazards, piece, number, access);
            piece = ranges_trim(ranges, &cursor, at, end);
        }
        if (!piece || !piece_add_read(piece, read, hazards->command_first))
            return false;
        at = piece->end;
        cursor_step(&cursor);
    }
    return true;
}

uint64_t hazards_access(struct hazards *hazards, const struct hazard_access *access)
{
    const uint64_t number = ++hazards->number;
    if (access->bytes.begin >= access->bytes.end)
        return number;
    struct past *past = &hazards->queues[hazards->queue].past;
    past->stages |= (stage_set)1 << access_stage(access->kind);
    if (access_is_write(access->kind))
        past->writes |= (kind_set)1 << access->kind;
    struct hazard_memory *memory = hazards_memory(hazards, access->bytes.memory, true);
    if (!memory || !(access_is_write(access->kind) ? write_bytes : read_bytes)(
                       hazards, &memory->ranges, number, access))
        hazards->has_failed = true;
    hazards_settle_failure(hazards);
    return number;
}

uint64_t hazards_begin_command(struct hazards *hazards)
{
    hazards->command_first = hazards->number + 1;
    return hazards->command_first;
}
