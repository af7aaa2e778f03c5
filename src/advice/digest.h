/* SPDX-License-Identifier: Apache-2.0 */
/* Whether two builds have read the same input. A digest is a hash of the parameters
 * of a build and of the bytes that it reads, without addresses and offsets. It also has bytes that
 * the build skips between two elements: if these differ, so do the digests. */
#ifndef ASSAY_ADVICE_DIGEST_H
#define ASSAY_ADVICE_DIGEST_H

#include "src/advice/uses.h"
#include "src/snapshots/recorded_build.h"

struct content;

/* The digest of a build whose geometries are being read. */
struct input_digesting {
    struct input_digest digest;
    uint32_t geometries; /* whose data is in the digest */
};

/* Call before the first geometry of a build is read. */
void digest_begin(struct input_digesting *digesting, const struct build_parameters *given);
/* Adds a geometry that was read. */
void digest_add(struct input_digesting *digesting, const struct content *content);
/* Returns whether the digest has all that the build has read. An update reads its source, too: it
 * is known in place only. `point`: when the build executed; NULL: unknown. */
bool digest_end(struct input_digesting *digesting, const struct build_parameters *given,
                const struct execution_point *point);

#endif
