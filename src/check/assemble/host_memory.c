/* SPDX-License-Identifier: Apache-2.0 */
/* Looks for host memory in mappings of device memory. */
#include "src/check/assemble/host_memory.h"

struct search {
    struct readable_cache *cache;
    uint64_t at; /* the address of the next piece */
    bool is_there;
};

static void visit_piece(void *user, const struct memory_span *piece)
{
    struct search *search = user;
    const uint64_t size = piece->end - piece->begin;
    search->is_there &= piece->memory != memory_of_host() ||
                        readable(search->cache, (const void *)(uintptr_t)search->at, size);
    search->at += size;
}

bool host_memory_is_there(struct check_context *context, const void *address, uint64_t size)
{
    if (readable(context->readable, address, size))
        return true;
    struct search search = {context->readable, (uint64_t)(uintptr_t)address, true};
    resources_find_host_pieces(context->resources, address, size, visit_piece, &search);
    return search.is_there;
}

struct host_bytes host_memory_bytes(struct check_context *context, const void *address,
                                    uint64_t offset, uint64_t count, uint64_t stride, uint64_t size)
{
    struct host_bytes bytes = {.address = address};
    uint64_t base = (uint64_t)(uintptr_t)address;
    bool wraps = __builtin_add_overflow(base, offset, &bytes.begin);
    if (!address || !count)
        return bytes;
    wraps |= __builtin_mul_overflow(count - 1, stride, &bytes.size);
    wraps |= __builtin_add_overflow(bytes.size, size, &bytes.size);
    bytes.unreadable =
        wraps || !host_memory_is_there(context, (const void *)(uintptr_t)bytes.begin, bytes.size);
    return bytes;
}
