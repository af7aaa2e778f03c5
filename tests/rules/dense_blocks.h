/* SPDX-License-Identifier: Apache-2.0 */
/* Dense geometry (VK_AMDX_dense_geometry_format) that is sound. */
#ifndef RULES_DENSE_BLOCKS_H
#define RULES_DENSE_BLOCKS_H

#include <stddef.h>
#include <stdint.h>

enum { DENSE_BLOCK = 128, DENSE_BLOCK_TRIANGLES = 8, DENSE_BLOCK_VERTICES = 10 };

/* `count` blocks, each a strip of 8 triangles between x = 0 and 5 and y = 0 and 1, the first at
 * z = 0, others one further each. Geometry 0, primitives counted on; not opaque. */
void dense_blocks_write(uint8_t *bytes, uint32_t count);

#endif
