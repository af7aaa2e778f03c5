/* SPDX-License-Identifier: Apache-2.0 */
/* Accesses: each is compared with the earlier ones of its bytes, and then replaces them or joins
 * them. Whether it is ordered after them: Vulkan specification, Synchronization and Cache Control:
 * Execution and Memory Dependencies. */
#include <string.h>

#include "src/hazards/engine.h"

static bool has_bit(uint32_t set, unsigned bit)
{
    return set >> bit & 1;
}

/* Whether a buffer barrier makes the piece's last write visible to kind b, if need be through
 * later global barriers. */
static bool barriers_order_write(const struct hazards *hazards, const struct piece_notes *notes,
                                 enum access_kind b)
{
    const struct chains *chains = hazards->queues[hazards->queue].chains;
    for (uint32_t i = 0; i < notes->barrier_count; i++) {
        const struct piece_barrier *barrier = &notes->barriers[i];
        if (barrier->queue != hazards->queue)
            continue;
        if (has_bit(barrier->dst_kinds, b))
            return true;
        for (stage_set rest = barrier->dst; rest; rest &= rest - 1)
            if (chains->visible[__builtin_ctz(rest)][b] >= barrier->number)
                return true;
    }
    return false;
}

/* Whether a buffer barrier has made the write available, and happens before stage d. */
static bool barriers_reach(const struct hazards *hazards, const struct piece_notes *notes,
                           enum sync_stage d)
{
    const struct chains *chains = hazards->queues[hazards->queue].chains;
    for (uint32_t i = 0; i < notes->barrier_count; i++) {
        const struct piece_barrier *barrier = &notes->barriers[i];
        if (barrier->queue != hazards->queue)
            continue;
        if (has_bit(barrier->dst, d))
            return true;
        for (stage_set rest = barrier->dst; rest; rest &= rest - 1)
            if (chains->reached[__builtin_ctz(rest)][d] >= barrier->number)
                return true;
    }
    return false;
}

/* Whether the batches may execute in either order. Only host commands do so on one queue. */
static bool is_racing(const struct hazards *hazards, access_mark earlier)
{
    const uint32_t queue = mark_queue(earlier);
    const uint64_t batch = hazards_batch_of(hazards, queue, mark_number(earlier));
    if (batch <= hazards->before[queue])
        return false;
    if (queue != hazards->queue)
        return true;
    return queue == HAZARD_HOST_QUEUE && batch != hazards_batch_of(hazards, queue, hazards->number);
}

static struct hazard describe_hazard(const struct hazards *hazards, const struct piece *piece,
                                     access_mark earlier, enum hazard_type type, uint64_t number,
                                     const struct hazard_access *access)
{
    const enum access_kind k = mark_kind(earlier);
    const enum sync_stage d = access_stage(access->kind);
    const uint64_t earlier_number = mark_number(earlier);
    const struct frontier *frontier = hazards->queues[hazards->queue].from[mark_queue(earlier)];
    const struct hazard_bytes *bytes = &access->bytes;
    struct hazard hazard = {
        .type = type,
        .is_racing = is_racing(hazards, earlier),
        .earlier = {mark_queue(earlier), earlier_number, k},
        .later = {hazards->queue, number, access->kind},
        .bytes = {bytes->memory, piece->begin > bytes->begin ? piece->begin : bytes->begin,
                  piece->end < bytes->end ? piece->end : bytes->end},
        .is_ordered = frontier && frontier_executes(frontier, earlier_number, access_stage(k), d)};
    if (type != WRITE_AFTER_READ)
        hazard.is_available = (frontier && frontier->available[k][d] >= earlier_number) ||
                              (piece->notes && barriers_reach(hazards, piece->notes, d));
    return hazard;
}

static void report_access(struct hazards *hazards, struct piece *piece, access_mark earlier,
                          enum hazard_type type, uint64_t number,
                          const struct hazard_access *access)
{
    const struct hazard hazard = describe_hazard(hazards, piece, earlier, type, number, access);
    hazards->found(hazards->user, &hazard);
}

/* Whether earlier commands have a later read of the same queue and kind. */
static bool is_superseded(const struct hazards *hazards, struct piece *piece, access_mark read)
{
    for (uint32_t i = 0; i < piece_read_count(piece); i++) {
        const access_mark other = *piece_read(piece, i);
        if (other > read && marks_have_same_source(other, read) &&
            mark_number(other) < hazards->command_first)
            return true;
    }
    return false;
}

/* Whether a write of that kind by the current command happens after the read. */
static bool read_is_ordered(const struct hazards *hazards, access_mark read, enum access_kind write)
{
    const uint64_t earlier = mark_number(read);
    const uint32_t past_queue = mark_queue(read);
    if (earlier >= hazards->command_first || earlier <= hazards->queues[past_queue].settled)
        return true;
    const struct frontier *frontier = hazards->queues[hazards->queue].from[past_queue];
    return frontier &&
           frontier_executes(frontier, earlier, access_stage(mark_kind(read)), access_stage(write));
}

static void judge_reads(struct hazards *hazards, struct piece *piece, uint64_t number,
                        const struct hazard_access *access)
{
    for (uint32_t i = 0; i < piece_read_count(piece); i++) {
        const access_mark read = *piece_read(piece, i);
        if (read && !read_is_ordered(hazards, read, access->kind) &&
            !is_superseded(hazards, piece, read))
            report_access(hazards, piece, read, WRITE_AFTER_READ, number, access);
    }
}

/* Markers "implicitly complete in submission order" (vkCmdWriteBufferMarkerAMD), at least those of
 * one stage. Nothing is said about two queues. */
static bool are_markers(enum access_kind k, enum access_kind b)
{
    return k == ACCESS_MARKER_WRITE && b == ACCESS_MARKER_WRITE;
}

static bool write_is_ordered(const struct hazards *hazards, const struct piece *piece,
                             enum access_kind b)
{
    const uint32_t past_queue = mark_queue(piece->write);
    const uint64_t earlier = mark_number(piece->write);
    if (are_markers(mark_kind(piece->write), b))
        return true;
    if (earlier >= hazards->command_first || earlier <= hazards->queues[past_queue].settled)
        return true;
    const struct frontier *frontier = hazards->queues[hazards->queue].from[past_queue];
    return (frontier && frontier_orders_write(frontier, earlier, mark_kind(piece->write), b)) ||
           (piece->notes && barriers_order_write(hazards, piece->notes, b));
}

/* Compares an access of the current command with the earlier ones (judge.c). */
static void hazards_judge(struct hazards *hazards, struct piece *piece, uint64_t number,
                          const struct hazard_access *access)
{
    const bool is_write = access_is_write(access->kind);
    if (piece->write && !write_is_ordered(hazards, piece, access->kind))
        report_access(hazards, piece, piece->write, is_write ? WRITE_AFTER_WRITE : READ_AFTER_WRITE,
                      number, access);
    if (is_write)
        judge_reads(hazards, piece, number, access);
}

/* ---- accesses */

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
        unknown_set(&hazards->failure, UNKNOWN_HAZARDS);
    hazards_settle_failure(hazards);
    return number;
}

void hazards_write_after(struct hazards *hazards, const struct hazard_side *read, uint64_t number,
                         const struct hazard_access *write)
{
    const access_mark mark = mark_of(read->number, read->queue, read->kind);
    struct piece piece = {.begin = write->bytes.begin, .end = write->bytes.begin + 1};
    if (!read_is_ordered(hazards, mark, write->kind))
        report_access(hazards, &piece, mark, WRITE_AFTER_READ, number, write);
}

/* Returns the piece of the first byte if its last write is known; else NULL. */
static const struct piece *find_written(struct hazards *hazards, const struct hazard_bytes *bytes)
{
    struct hazard_memory *memory = hazards_memory(hazards, bytes->memory, false);
    const struct piece *piece =
        memory ? cursor_piece(ranges_find(&memory->ranges, bytes->begin)) : NULL;
    return piece && piece->begin <= bytes->begin && piece->write ? piece : NULL;
}

uint64_t hazards_write_since(struct hazards *hazards, uint64_t since, struct hazard_bytes *bytes)
{
    struct hazard_memory *memory = hazards_memory(hazards, bytes->memory, false);
    struct cursor cursor = {0};
    const struct piece *piece = NULL;
    if (memory) {
        cursor = ranges_find(&memory->ranges, bytes->begin);
        piece = cursor_piece(cursor);
    }
    while (piece && piece->begin < bytes->end && mark_number(piece->write) <= since) {
        cursor_step(&cursor);
        piece = cursor_piece(cursor);
    }
    if (!piece || piece->begin >= bytes->end)
        return 0;
    const uint64_t number = mark_number(piece->write), limit = bytes->end;
    bytes->begin = piece->begin > bytes->begin ? piece->begin : bytes->begin;
    bytes->end = piece->end;
    /* Reads split what one write has written. */
    for (cursor_step(&cursor); (piece = cursor_piece(cursor)) && piece->begin == bytes->end &&
                               mark_number(piece->write) == number;
         cursor_step(&cursor))
        bytes->end = piece->end;
    bytes->end = bytes->end < limit ? bytes->end : limit;
    return number;
}

bool hazards_read_is_early(struct hazards *hazards, const struct hazard_access *read,
                           struct hazard *hazard)
{
    const struct piece *piece = find_written(hazards, &read->bytes);
    if (!piece || write_is_ordered(hazards, piece, read->kind))
        return false;
    *hazard =
        describe_hazard(hazards, piece, piece->write, READ_AFTER_WRITE, hazards->number, read);
    return true;
}

uint64_t hazards_begin_command(struct hazards *hazards)
{
    hazards->command_first = hazards->number + 1;
    return hazards->command_first;
}
