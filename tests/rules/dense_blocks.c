/* SPDX-License-Identifier: Apache-2.0 */
/* Dense geometry (VK_AMDX_dense_geometry_format) that is sound. */
#include "dense_blocks.h"

#include <string.h>

enum { OFFSET_BITS = 4, FRONT = 160, LAST = 8 * DENSE_BLOCK, EDGE1 = 1, EDGE2 = 2 };

static void put(uint8_t *block, uint32_t at, uint32_t count, uint32_t value)
{
    for (uint32_t i = 0; i < count; i++)
        if (value >> i & 1)
            block[(at + i) / 8] |= (uint8_t)(1u << (at + i) % 8);
}

static void write_block(uint8_t *block, uint32_t number)
{
    memset(block, 0, DENSE_BLOCK);
    put(block, 0, 8, 6); /* what blocks begin with */
    put(block, 10, 6, DENSE_BLOCK_VERTICES - 1);
    put(block, 16, 6, DENSE_BLOCK_TRIANGLES - 1);
    put(block, 32, 8, 127); /* steps of 1 */
    put(block, 64, 4, OFFSET_BITS - 1);
    put(block, 68, 4, OFFSET_BITS - 1);
    put(block, 96, 4, OFFSET_BITS - 1);
    put(block, 104, 24, number); /* the anchor's z */
    put(block, 128, 29, number * DENSE_BLOCK_TRIANGLES);
    for (uint32_t i = 0; i < DENSE_BLOCK_VERTICES; i++) {
        put(block, FRONT + 3 * OFFSET_BITS * i, OFFSET_BITS, i / 2);
        put(block, FRONT + 3 * OFFSET_BITS * i + OFFSET_BITS, OFFSET_BITS, i % 2);
    }
    /* From the end back: by which edge each triangle goes on, then that its vertex is a new one. */
    for (uint32_t i = 1; i < DENSE_BLOCK_TRIANGLES; i++) {
        put(block, LAST - 2 * i, 2, i % 2 ? EDGE1 : EDGE2);
        put(block, LAST - 2 * (DENSE_BLOCK_TRIANGLES - 1) - i, 1, 1);
    }
}

void dense_blocks_write(uint8_t *bytes, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++)
        write_block(bytes + (size_t)i * DENSE_BLOCK, i);
}
