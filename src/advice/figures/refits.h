/* SPDX-License-Identifier: Apache-2.0 */
/* What an update makes of the tree of a build: it keeps the tree, however far its triangles have
 * moved. Judged by the reference builder, on a sample of the triangles of one geometry.
 *
 * The functions need the environment of src/base/float_environment.h. */
#ifndef ASSAY_ADVICE_FIGURES_REFITS_H
#define ASSAY_ADVICE_FIGURES_REFITS_H

#include <stdint.h>

#include "src/bvh/input/source.h"
#include "src/state/builds/built.h"

/* Immutable; any thread. */
struct triangle_sample {
    struct kept_block block;
    uint32_t count; /* of triangles in the sample */
    uint32_t of;    /* of triangles in the geometry */
    float corners[][3][3];
};

/* Reads triangles at equal distances. Returns NULL if the geometry has few triangles, if one of the
 * sample cannot be hit or is not finite, or if there is no memory. */
struct triangle_sample *triangle_sample_create(const struct source *source);
static inline struct triangle_sample *triangle_sample_share(struct triangle_sample *sample)
{
    return (struct triangle_sample *)kept_block_share(&sample->block);
}
static inline void triangle_sample_release(struct triangle_sample *sample) /* accepts NULL */
{
    kept_block_release((struct kept_block *)sample);
}

/* Returns how many times as much the tree of `built` costs after an update to the triangles of
 * `now` as a new tree of these (the surface area heuristic), or 0 if that is unknown. Takes some
 * 1.2 million instructions. */
double triangle_sample_refit_cost(const struct triangle_sample *built,
                                  const struct triangle_sample *now);

#endif
