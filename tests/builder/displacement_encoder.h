/* SPDX-License-Identifier: Apache-2.0 */
/* An encoder of displacement micromaps: from the tables of the specification, and recursive where
 * the builder's decoder counts. */
#ifndef ASSAY_TESTS_BUILDER_DISPLACEMENT_ENCODER_H
#define ASSAY_TESTS_BUILDER_DISPLACEMENT_ENCODER_H

#include "tests/builder/fixture.h"

#define ENCODER_EDGE 33 /* vertices of an edge at level 5 */

/* Values by weights of vertices 1 and 2, in units in which an edge is 2^level. */
struct encoder_values {
    uint16_t at[ENCODER_EDGE][ENCODER_EDGE]; /* [u][v] */
};

/* What a vertex should have. */
typedef uint16_t encoder_value(void *context, uint32_t triangle, uint32_t level, uint32_t u,
                               uint32_t v);

/* Displacements as a geometry has them, with a micromap of their own. */
struct displaced {
    struct builder_displacement displacement;
    VkMicromapUsageEXT usages[6];
    struct encoder_values *coded;
    void *micromap;
};

/* `vectors`: of bytes `vectors_size`. */
void open_displaced(struct displaced *displaced, uint32_t format, uint32_t count,
                    const uint8_t *levels, encoder_value *value, void *context,
                    const float *vectors, uint64_t vectors_size);

encoder_value random_value; /* its context: a state of fixture_random() */

#endif
