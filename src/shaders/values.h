/* SPDX-License-Identifier: Apache-2.0 */
/* Values of a shader, as far as they are known: scalars and vectors of 32-bit numbers and
 * booleans. */
#ifndef ASSAY_SHADERS_VALUES_H
#define ASSAY_SHADERS_VALUES_H

#include "src/shaders/spirv.h"

enum { VALUE_PARTS = 4 };

struct value {
    uint32_t parts[VALUE_PARTS]; /* of those that are known; booleans are 0 or 1 */
    unsigned char known;         /* a bit for each part */
    unsigned char positive;      /* likewise: parts that are unknown, but 1 to INT32_MAX */
};

/* Returns a value of which all parts are that number. */
struct value value_of_number(uint32_t number);
/* Returns a value whose parts are unknown but not 0, such as the size of an image. */
struct value value_positive(void);
struct value value_part(const struct value *value, uint32_t part);
bool value_is_known(const struct value *value, uint32_t *number);

/* Returns the result of an instruction on one to three operands. Unknown for each `op` that is not
 * computed here. */
struct value value_compute(uint32_t op, const struct value *operands, uint32_t count);

#endif
