/* SPDX-License-Identifier: Apache-2.0 */
/* An encoder of displacement micromaps: from the tables of the specification, and recursive where
 * the builder's decoder counts. */
#ifndef ASSAY_TESTS_BUILDER_DISPLACEMENT_ENCODER_H
#define ASSAY_TESTS_BUILDER_DISPLACEMENT_ENCODER_H

#include <stdint.h>

#define ENCODER_EDGE 33 /* vertices of an edge at level 5 */
#define ENCODER_BYTES (16 * 128)

/* Values by weights of vertices 1 and 2, in units in which an edge is 2^level. */
struct encoder_values {
    uint16_t at[ENCODER_EDGE][ENCODER_EDGE]; /* [u][v] */
};

/* Blocks of values as near to `wanted` as random shifts allow, which then are in `coded`. Returns
 * the bytes. */
uint32_t encoder_encode(uint32_t format, uint32_t level, const struct encoder_values *wanted,
                        uint64_t *random, uint8_t *blocks, struct encoder_values *coded);

void encoder_write_bits(uint8_t *bytes, uint32_t at, uint32_t count, uint32_t value);

#endif
