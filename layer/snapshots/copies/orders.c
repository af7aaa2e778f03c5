/* SPDX-License-Identifier: Apache-2.0 */
/* Takes copy orders when a build is recorded. */
#include "layer/snapshots/copies/copies.h"

#include <string.h>

enum {
    ORDER_SIZE = sizeof(struct copy_order),
    BLOCK_ORDERS = 64,
    GROUPS_MAX = 65535, /* the most workgroups of a dispatch that each device supports */
};

/* Push constants, in the layout of copy.comp. */
struct constants {
    uint64_t gate, orders;
};

static struct copy_block *last_block(const struct recorder *recorder)
{
    const struct recording *recording = recorder->recording;
    return recording->copy_block_count ? &recording->copy_blocks[recording->copy_block_count - 1]
                                       : NULL;
}

static const struct staging_chunk *chunk_of(const struct recorder *recorder, uint32_t chunk)
{
    return (const struct staging_chunk *)recorder->recording->chunks[chunk];
}

/* ---- taking orders */

/* Adds a block of orders, in front of the first snapshot that uses them. */
static bool add_block(struct recorder *recorder, uint32_t order_count, uint64_t size,
                      struct snapshot *snapshot)
{
    uint32_t count = order_count > BLOCK_ORDERS ? (order_count + 1) / 2 * 2 : BLOCK_ORDERS;
    uint64_t block_size = (uint64_t)count * ORDER_SIZE;
    copy_orders_flush(recorder);
    if (!recorder_reserve(recorder, block_size + size, snapshot))
        return false;
    const struct copy_block block = {{snapshot->chunk, count, snapshot->offset}, 0};
    if (!recording_add_copy_block(recorder->recording, &block)) {
        recorder_fail(recorder);
        return false;
    }
    recorder->first_order = 0;
    snapshot->offset += block_size;
    snapshot->size = size;
    return true;
}

/* Reserves a snapshot of `size` bytes, and `count` orders for it. */
static bool reserve_snapshot(struct recorder *recorder, uint32_t count, uint64_t size,
                             struct snapshot *snapshot)
{
    const struct copy_block *last = last_block(recorder);
    bool has_orders = last && recorder->recording->chunks[last->orders.chunk] &&
                      count <= last->orders.count - last->used;
    *snapshot = (struct snapshot){0};
    if (!has_orders && !add_block(recorder, count, size, snapshot))
        return false;
    if (has_orders && size && !recorder_reserve(recorder, size, snapshot))
        return false;
    struct copy_block *block = last_block(recorder);
    if (!size) /* it needs no bytes of its own; the first chunk may have been given back */
        snapshot->chunk = block->orders.chunk;
    snapshot->orders = (struct copy_orders){
        block->orders.chunk, count, block->orders.offset + (uint64_t)block->used * ORDER_SIZE};
    block->used += count;
    return true;
}

/* Writes the orders. The shader reads nothing until copy_orders_renew() has been called. */
static void write_orders(const struct recorder *recorder, const struct snapshot *snapshot)
{
    struct copy_order *orders = copy_orders_at(recorder->recording, &snapshot->orders);
    uint64_t target = chunk_of(recorder, snapshot->chunk)->buffer.address + snapshot->offset;
    for (uint32_t i = 0; i < snapshot->orders.count; i++) {
        uint64_t done = (uint64_t)i * COPY_SIZE_MAX, rest = snapshot->size - done;
        orders[i] = (struct copy_order){
            .source = snapshot->address + done,
            .target = target + done,
            .size = (uint32_t)(rest < COPY_SIZE_MAX ? rest : COPY_SIZE_MAX),
        };
    }
}

static bool order_copy(struct recorder *recorder, uint64_t address, uint64_t size,
                       struct snapshot *snapshot)
{
    uint64_t count = (size + COPY_SIZE_MAX - 1) / COPY_SIZE_MAX;
    if (count > UINT32_MAX / 2 || !dispatches_prepare(recorder, SHADER_COPY)) {
        recorder_fail(recorder);
        return false;
    }
    if (!reserve_snapshot(recorder, (uint32_t)count, size, snapshot))
        return false;
    snapshot->address = address;
    write_orders(recorder, snapshot);
    return true;
}

bool recorder_measure(struct recorder *recorder, uint64_t address, struct snapshot *snapshot)
{
    if (recorder->cannot_inject || !dispatches_are_allowed(recorder) ||
        !reserve_snapshot(recorder, 1, 0, snapshot))
        return false;
    snapshot->address = address;
    write_orders(recorder, snapshot);
    return true;
}

void copy_orders_flush(struct recorder *recorder)
{
    const struct copy_block *block = last_block(recorder);
    if (!block || recorder->addresses)
        return;
    while (recorder->first_order < block->used) {
        uint32_t count = block->used - recorder->first_order;
        const struct constants constants = {
            .gate = recorder->recording->gate.address,
            .orders = chunk_of(recorder, block->orders.chunk)->buffer.address +
                      block->orders.offset + (uint64_t)recorder->first_order * ORDER_SIZE,
        };
        count = count < GROUPS_MAX ? count : GROUPS_MAX;
        if (dispatches_prepare(recorder, SHADER_COPY))
            dispatches_add(recorder, SHADER_COPY, &constants, sizeof(constants), count);
        recorder->first_order += count;
    }
}

/* ---- copies from buffers that the application names */

/* Copies by vkCmdCopyBuffer. All such copies of a command share one order, which serves as their
 * mark. */
static bool copy_buffer(struct recorder *recorder, const struct buffer_target *source,
                        uint64_t address, uint64_t size, struct snapshot *snapshot)
{
    struct copy_orders *mark = &recorder->mark;
    struct snapshot marked = {0};
    if (!mark->count && !reserve_snapshot(recorder, 1, 0, &marked))
        return false;
    if (!mark->count) {
        *mark = marked.orders;
        *copy_orders_at(recorder->recording, mark) = (struct copy_order){0};
    }
    if (!recorder_reserve(recorder, size, snapshot))
        return false;
    snapshot->address = address;
    snapshot->orders = *mark;
    const struct staging_chunk *chunk = chunk_of(recorder, snapshot->chunk);
    const VkBufferCopy region = {source->offset, chunk->offset + snapshot->offset, size};
    recording_keep_chunks(recorder->recording);
    recorder_start_copies(recorder);
    recorder->device->snapshots->next.CmdCopyBuffer(recorder->handle, source->buffer,
                                                    chunk->buffer.handle, 1, &region);
    return true;
}

void copy_orders_mark(const struct recorder *recorder)
{
    const struct copy_orders *mark = &recorder->mark;
    if (!mark->count)
        return;
    const struct staging_chunk *chunk = chunk_of(recorder, mark->chunk);
    recorder->device->snapshots->next.CmdFillBuffer(
        recorder->handle, chunk->buffer.handle,
        chunk->offset + mark->offset + offsetof(struct copy_order, is_done), sizeof(uint32_t), 1);
}

/* ---- orders of both kinds: plain and gathered */

/* Returns why the source can't be copied. */
static enum left_out find_obstacle(const struct recorder *recorder,
                                   const struct buffer_target *source)
{
    struct snapshots *snapshots = recorder->device->snapshots;
    if (recorder->cannot_inject || (!recorder->addresses && !dispatches_are_allowed(recorder)))
        return LEFT_OUT_PLACE;
    bool can_read =
        recorder->addresses ? snapshots_can_copy(snapshots, source->buffer) : !source->is_protected;
    return can_read ? LEFT_OUT_NOTHING : LEFT_OUT_BUFFER;
}

bool recorder_copy(struct recorder *recorder, uint64_t address, uint64_t size,
                   struct snapshot *snapshot)
{
    struct buffer_target source;
    if (!size || !recorder_find(recorder, address, &source))
        return false;
    enum left_out obstacle = find_obstacle(recorder, &source);
    if (obstacle) {
        recorder->left_out = obstacle;
        return false;
    }
    size = size < source.size ? size : source.size;
    if (recorder->addresses ? !copy_buffer(recorder, &source, address, size, snapshot)
                            : !order_copy(recorder, address, size, snapshot))
        return false;
    atomic_fetch_add_explicit(&recorder->device->snapshots->bytes_copied, size,
                              memory_order_relaxed);
    return true;
}
