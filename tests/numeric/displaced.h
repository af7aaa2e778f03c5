/* SPDX-License-Identifier: Apache-2.0 */
/* What cases of displaced triangles share. */
#ifndef ASSAY_TESTS_NUMERIC_DISPLACED_H
#define ASSAY_TESTS_NUMERIC_DISPLACED_H

#include "displacement_encoder.h"
#include "tests/builder/fixture.h"

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
