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
