/* SPDX-License-Identifier: Apache-2.0 */
/* Memory for the arrays that a call hands on, whose size is known before: on the stack if they are
 * small. */
#ifndef ASSAY_BASE_BLOCK_H
#define ASSAY_BASE_BLOCK_H

#include <stdbool.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

struct block {
    char *next;
    void *heap; /* NULL: the arrays lie in `room` */
    max_align_t room[128];
};

/* The bytes that an array takes in a block. */
static inline size_t block_size(size_t count, size_t size)
{
    const size_t step = sizeof(max_align_t);
    return (count * size + step - 1) / step * step;
}

/* Returns false without memory. The caller ends the block in either case. */
static inline bool block_begin(struct block *block, size_t size)
{
    block->heap = size > sizeof(block->room) ? malloc(size) : NULL;
    block->next = block->heap ? block->heap : (char *)block->room;
    return block->heap || size <= sizeof(block->room);
}

static inline void block_end(struct block *block)
{
    free(block->heap);
}

static inline void *block_take(struct block *block, size_t count, size_t size)
{
    void *array = block->next;
    block->next += block_size(count, size);
    return array;
}

/* A copy of an array. Returns NULL if `count` is 0. */
static inline void *block_copy(struct block *block, const void *array, size_t count, size_t size)
{
    return count ? memcpy(block_take(block, count, size), array, count * size) : NULL;
}

#endif
