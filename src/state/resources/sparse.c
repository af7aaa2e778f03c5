/* SPDX-License-Identifier: Apache-2.0 */
/* The bindings of the ranges of sparse buffers, and their timestamps. */
#include <stdlib.h>
#include <string.h>

#include "src/state/resources/records.h"

/* ---- ranges */

static bool reserve_ranges(struct buffer_record *buffer, uint32_t count)
{
    if (count <= buffer->sparse_capacity)
        return true;
    uint32_t capacity = count * 2;
    struct sparse_range *ranges = realloc(buffer->sparse, capacity * sizeof(*ranges));
    if (!ranges)
        return false;
    buffer->sparse = ranges;
    buffer->sparse_capacity = capacity;
    return true;
}

static void insert(struct buffer_record *buffer, uint32_t at, struct sparse_range range)
{
    memmove(&buffer->sparse[at + 1], &buffer->sparse[at],
            (buffer->sparse_count - at) * sizeof(range));
    buffer->sparse[at] = range;
    buffer->sparse_count++;
    if (range.memory)
        range.memory->references++;
}

/* Erases the ranges from index `first` to before index `behind`. */
static void erase(struct buffer_record *buffer, uint32_t first, uint32_t behind)
{
    for (uint32_t i = first; i < behind; i++)
        memory_record_release(buffer->sparse[i].memory);
    memmove(&buffer->sparse[first], &buffer->sparse[behind],
            (buffer->sparse_count - behind) * sizeof(buffer->sparse[0]));
    buffer->sparse_count -= behind - first;
}

static struct sparse_range tail_of(const struct sparse_range *range, VkDeviceSize begin)
{
    struct sparse_range tail = *range;
    tail.memory_offset += begin - range->begin;
    tail.begin = begin;
    return tail;
}

/* Returns the index of the first range that ends after `begin`. Binary search, because large
 * buffers are bound page by page. */
static uint32_t first_behind(const struct buffer_record *buffer, VkDeviceSize begin)
{
    uint32_t low = 0, high = buffer->sparse_count;
    while (low < high) {
        uint32_t middle = low + (high - low) / 2;
        if (buffer->sparse[middle].end <= begin)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

/* Removes [begin, end) from the ranges and cuts ranges that reach beyond it. Needs room for one
 * more range. Returns the index where a range that begins at `begin` belongs. */
static uint32_t cut_out(struct buffer_record *buffer, VkDeviceSize begin, VkDeviceSize end)
{
    uint32_t i = first_behind(buffer, begin);
    if (i < buffer->sparse_count && buffer->sparse[i].begin < begin) {
        struct sparse_range *range = &buffer->sparse[i];
        if (range->end > end)
            insert(buffer, i + 1, tail_of(range, end));
        buffer->sparse[i].end = begin;
        i++;
    }
    uint32_t behind = i;
    while (behind < buffer->sparse_count && buffer->sparse[behind].end <= end)
        behind++;
    erase(buffer, i, behind);
    if (i < buffer->sparse_count && buffer->sparse[i].begin < end)
        buffer->sparse[i] = tail_of(&buffer->sparse[i], end);
    return i;
}

/* Returns whether every earlier binding of [begin, end) is certain to precede `clock`. */
static bool is_settled(const struct buffer_record *buffer, VkDeviceSize begin, VkDeviceSize end,
                       const struct execution_clock *clock)
{
    for (uint32_t i = first_behind(buffer, begin);
         i < buffer->sparse_count && buffer->sparse[i].begin < end; i++)
        if (!execution_clock_has(clock, buffer->sparse[i].written))
            return false;
    return true;
}

/* ---- binding */

struct sparse_binding resources_announce_sparse(struct resources *resources, VkBuffer handle,
                                                const VkSparseMemoryBind *bind)
{
    struct sparse_binding binding = {.buffer = handle,
                                     .memory = bind->memory,
                                     .offset = bind->resourceOffset,
                                     .size = bind->size,
                                     .memory_offset = bind->memoryOffset};
    reader_lock_write(&resources->lock);
    struct buffer_record *buffer = resources_buffer(resources, handle);
    const struct memory_record *memory = resources_memory(resources, bind->memory);
    if (buffer) {
        binding.buffer_id = buffer->where.buffer_id;
        buffer->sparse_announced++;
    }
    if (memory)
        binding.memory_id = memory->id;
    reader_lock_write_done(&resources->lock);
    return binding;
}

/* Returns NULL if the buffer is destroyed. */
static struct buffer_record *buffer_of(struct resources *resources,
                                       const struct sparse_binding *binding)
{
    struct buffer_record *buffer = resources_buffer(resources, binding->buffer);
    return buffer && buffer->where.buffer_id == binding->buffer_id ? buffer : NULL;
}

void resources_settle_sparse(struct resources *resources, const struct sparse_binding *binding)
{
    reader_lock_write(&resources->lock);
    struct buffer_record *buffer = buffer_of(resources, binding);
    if (buffer)
        buffer->sparse_announced--;
    reader_lock_write_done(&resources->lock);
}

/* If two bindings of one range are unordered, the last one is unknown. The same holds if the memory
 * is destroyed or unknown. */
static void bind(struct buffer_record *buffer, const struct sparse_binding *binding,
                 struct memory_record *memory, struct timestamp when,
                 const struct execution_clock *follows)
{
    struct sparse_range range = {.begin = binding->offset,
                                 .end = binding->offset + binding->size,
                                 .memory = memory,
                                 .memory_offset = binding->memory_offset,
                                 .written = when};
    if (range.end <= range.begin)
        return;
    if (!reserve_ranges(buffer, buffer->sparse_count + 2)) {
        unknown_set(&buffer->sparse_unknown, UNKNOWN_SPARSE_BINDINGS);
        return;
    }
    bool memory_was_destroyed = binding->memory && (!memory || memory->id != binding->memory_id);
    if (memory_was_destroyed || !when.count || !is_settled(buffer, range.begin, range.end, follows))
        range.written = timestamp_never();
    if (memory_was_destroyed)
        range.memory = NULL;
    insert(buffer, cut_out(buffer, range.begin, range.end), range);
}

void resources_bind_sparse(struct resources *resources, const struct sparse_binding *binding,
                           struct timestamp when, const struct execution_clock *follows)
{
    reader_lock_write(&resources->lock);
    struct buffer_record *buffer = buffer_of(resources, binding);
    if (buffer)
        bind(buffer, binding, resources_memory(resources, binding->memory), when, follows);
    reader_lock_write_done(&resources->lock);
}

void resources_forget_sparse(struct resources *resources, VkBuffer handle)
{
    reader_lock_write(&resources->lock);
    struct buffer_record *buffer = resources_buffer(resources, handle);
    if (buffer)
        unknown_set(&buffer->sparse_unknown, UNKNOWN_SPARSE_BINDINGS);
    reader_lock_write_done(&resources->lock);
}

/* ---- look-ups */

/* Returns NULL if the bindings of the buffer are not certain. */
static const struct buffer_record *find_certain(const struct resources *resources,
                                                const struct sparse_bytes *bytes)
{
    const struct buffer_record *buffer = resources_buffer(resources, bytes->buffer);
    bool is_certain = buffer && buffer->where.buffer_id == bytes->buffer_id &&
                      !buffer->sparse_announced && !unknown_is_set(&buffer->sparse_unknown);
    return is_certain ? buffer : NULL;
}

static enum tristate backing(const struct buffer_record *buffer, const struct sparse_bytes *bytes,
                             const struct execution_clock *clock, struct sparse_bytes *missing)
{
    VkDeviceSize at = bytes->begin;
    enum tristate answer = YES;
    for (uint32_t i = first_behind(buffer, at); at < bytes->end; i++) {
        const struct sparse_range *range = i < buffer->sparse_count ? &buffer->sparse[i] : NULL;
        VkDeviceSize bound = range ? smaller_of(range->begin, bytes->end) : bytes->end;
        *missing = (struct sparse_bytes){bytes->buffer, bytes->buffer_id, at, bound};
        if (at < bound)
            return NO;
        missing->end = smaller_of(range->end, bytes->end);
        if (!execution_clock_has(clock, range->written))
            answer = UNKNOWN;
        else if (!range->memory || !range->memory->alive)
            return NO;
        at = range->end;
    }
    return answer;
}

enum tristate resources_sparse_backing(struct resources *resources,
                                       const struct sparse_bytes *bytes,
                                       const struct execution_clock *clock,
                                       struct sparse_bytes *missing)
{
    unsigned token = resources_begin_reading(resources);
    const struct buffer_record *buffer = find_certain(resources, bytes);
    enum tristate answer = buffer ? backing(buffer, bytes, clock, missing) : UNKNOWN;
    resources_end_reading(resources, token);
    return answer;
}

static void visit_pieces(const struct buffer_record *buffer, const struct sparse_bytes *bytes,
                         const struct execution_clock *clock,
                         void (*visit)(void *user, const struct memory_span *piece), void *user)
{
    for (uint32_t i = first_behind(buffer, bytes->begin);
         i < buffer->sparse_count && buffer->sparse[i].begin < bytes->end; i++) {
        const struct sparse_range *range = &buffer->sparse[i];
        VkDeviceSize from = bytes->begin > range->begin ? bytes->begin : range->begin;
        VkDeviceSize to = smaller_of(bytes->end, range->end);
        if (from >= to || !range->memory || !range->memory->alive ||
            !execution_clock_has(clock, range->written))
            continue;
        VkDeviceSize offset = range->memory_offset + (from - range->begin);
        struct memory_span piece = {range->memory->handle, offset, offset + (to - from)};
        visit(user, &piece);
    }
}

void resources_find_pieces(struct resources *resources, const struct sparse_bytes *bytes,
                           const struct execution_clock *clock,
                           void (*visit)(void *user, const struct memory_span *piece), void *user)
{
    unsigned token = resources_begin_reading(resources);
    const struct buffer_record *buffer = find_certain(resources, bytes);
    if (buffer)
        visit_pieces(buffer, bytes, clock, visit, user);
    resources_end_reading(resources, token);
}
