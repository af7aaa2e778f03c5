/* SPDX-License-Identifier: Apache-2.0 */
/* The bound ranges of a sparse buffer. */
#include <stdlib.h>
#include <string.h>

#include "state/resource_records.h"

static bool reserve(struct buffer_record *buffer, uint32_t count)
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
    return (struct sparse_range){.begin = begin,
                                 .end = range->end,
                                 .memory = range->memory,
                                 .memory_offset = range->memory_offset + (begin - range->begin)};
}

/* The index of the first range that ends behind `begin`: buffers of many pages are bound page by
 * page, so it is searched for. */
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

/* Takes [begin, end) out of the ranges, cutting those that reach over its ends. Needs room for one
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

void buffer_record_bind_sparse(struct buffer_record *buffer, const VkSparseMemoryBind *bind,
                               struct memory_record *memory)
{
    VkDeviceSize begin = bind->resourceOffset, end = begin + bind->size;
    if (!bind->size || end < begin)
        return;
    if (!reserve(buffer, buffer->sparse_count + 2)) {
        buffer->sparse_incomplete = true;
        return;
    }
    uint32_t at = cut_out(buffer, begin, end);
    if (memory)
        insert(
            buffer, at,
            (struct sparse_range){
                .begin = begin, .end = end, .memory = memory, .memory_offset = bind->memoryOffset});
}

enum tristate buffer_record_sparse_backing(const struct buffer_record *buffer, VkDeviceSize begin,
                                           VkDeviceSize end)
{
    for (uint32_t i = first_behind(buffer, begin); i < buffer->sparse_count && begin < end; i++) {
        const struct sparse_range *range = &buffer->sparse[i];
        if (range->begin > begin || !range->memory->alive)
            break;
        begin = range->end;
    }
    return begin >= end && !buffer->sparse_incomplete ? YES : UNKNOWN;
}

void buffer_record_sparse_pieces(const struct buffer_record *buffer, VkDeviceSize begin,
                                 VkDeviceSize end,
                                 void (*visit)(void *user, const struct memory_span *piece),
                                 void *user)
{
    if (buffer->sparse_incomplete)
        return;
    for (uint32_t i = first_behind(buffer, begin);
         i < buffer->sparse_count && buffer->sparse[i].begin < end; i++) {
        const struct sparse_range *range = &buffer->sparse[i];
        VkDeviceSize from = begin > range->begin ? begin : range->begin;
        VkDeviceSize to = end < range->end ? end : range->end;
        if (from >= to || !range->memory->alive)
            continue;
        VkDeviceSize offset = range->memory_offset + (from - range->begin);
        struct memory_span piece = {range->memory->handle, offset, offset + (to - from)};
        visit(user, &piece);
    }
}
