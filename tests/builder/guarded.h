/* SPDX-License-Identifier: Apache-2.0 */
/* Blocks of memory that end with bytes that must stay as they are. New blocks and freed ones are
 * filled, so that nothing relies on what happens to be there. For the functions that the linker's
 * --wrap puts in the place of the C library's. */
#ifndef ASSAY_TESTS_BUILDER_GUARDED_H
#define ASSAY_TESTS_BUILDER_GUARDED_H

#include <malloc.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { GUARDED_BYTES = 16, GUARDED_FILLED = 0xa5, GUARDED_FREED = 0x5a };

/* At the end of a block. Blocks that the C library has allocated itself have none. */
struct guarded_end {
    uint64_t size, mark;
};

/* Of a request; the same if it is too large to exist. */
static inline size_t guarded_size(size_t size)
{
    const size_t more = GUARDED_BYTES + sizeof(struct guarded_end);
    return size <= SIZE_MAX - more ? size + more : size;
}

static inline char *guarded_end(void *block)
{
    return (char *)block + malloc_usable_size(block) - sizeof(struct guarded_end);
}

static inline uint64_t guarded_mark(const void *block)
{
    return UINT64_C(0x6775617264656421) ^ (uintptr_t)block;
}

/* A block of guarded_size(size) bytes, whose first `filled` bytes are to stay. */
static inline void *guarded_open(void *block, size_t size, size_t filled)
{
    if (!block)
        return NULL;
    const struct guarded_end end = {size, guarded_mark(block)};
    char *bytes = block, *at = guarded_end(block);
    memset(bytes + filled, GUARDED_FILLED, (size_t)(at - bytes) - filled);
    memcpy(at, &end, sizeof(end));
    return block;
}

/* Returns false if the block is the C library's own. */
static inline bool guarded_check(void *block, size_t *size)
{
    struct guarded_end end;
    if (!block || malloc_usable_size(block) < sizeof(end) + GUARDED_BYTES)
        return false;
    const char *at = guarded_end(block);
    memcpy(&end, at, sizeof(end));
    if (end.mark != guarded_mark(block))
        return false;
    for (const char *byte = (const char *)block + end.size; byte < at; byte++)
        if (*byte != (char)GUARDED_FILLED) {
            fprintf(stderr, "bytes after a block of %zu were written\n", (size_t)end.size);
            abort();
        }
    *size = end.size;
    return true;
}

/* The mark must not outlive the block: the C library may allocate the same bytes. */
static inline void guarded_close(void *block)
{
    size_t size;
    guarded_check(block, &size);
    if (block)
        memset(block, GUARDED_FREED, malloc_usable_size(block));
}

static inline void *guarded_realloc(void *(*real)(void *block, size_t size), void *old, size_t size)
{
    size_t before = 0;
    if (old && !guarded_check(old, &before))
        return real(old, size);
    if (old)
        memset(guarded_end(old), 0, sizeof(struct guarded_end));
    void *block = real(old, guarded_size(size));
    if (!block)
        guarded_open(old, before, before);
    return guarded_open(block, size, before < size ? before : size);
}

#endif
