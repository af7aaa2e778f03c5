/* SPDX-License-Identifier: Apache-2.0 */
/* The life of kept data. */
#include "src/state/builds/contents.h"

#include <stdlib.h>

struct build_contents *build_contents_create(uint32_t count)
{
    struct build_contents *contents =
        calloc(1, sizeof(*contents) + (size_t)count * sizeof(contents->items[0]));
    if (!contents)
        return NULL;
    atomic_init(&contents->references, 1);
    atomic_init(&contents->is_known, false);
    contents->count = count;
    return contents;
}

struct build_contents *build_contents_share(struct build_contents *contents)
{
    if (contents)
        atomic_fetch_add_explicit(&contents->references, 1, memory_order_relaxed);
    return contents;
}

void build_contents_release(struct build_contents *contents)
{
    if (!contents || atomic_fetch_sub_explicit(&contents->references, 1, memory_order_acq_rel) != 1)
        return;
    for (uint32_t i = 0; i < contents->count; i++) {
        free(contents->items[i].inactive);
        free(contents->items[i].indices);
    }
    free(contents);
}

void build_contents_tell(struct build_contents *contents)
{
    if (contents)
        atomic_store_explicit(&contents->is_known, true, memory_order_release);
}

const struct geometry_contents *build_contents_of(const struct build_contents *contents,
                                                  uint32_t geometry)
{
    return contents && geometry < contents->count &&
                   atomic_load_explicit(&contents->is_known, memory_order_acquire)
               ? &contents->items[geometry]
               : NULL;
}
