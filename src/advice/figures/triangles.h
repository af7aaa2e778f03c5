/* SPDX-License-Identifier: Apache-2.0 */
/* Figures of the triangles of one geometry, as a build reads them: before the geometry's transform.
 *
 * The functions read each triangle a few times and allocate nothing. They need the environment of
 * src/base/float_environment.h. */
#ifndef ASSAY_ADVICE_FIGURES_TRIANGLES_H
#define ASSAY_ADVICE_FIGURES_TRIANGLES_H

#include "src/bvh/input/source.h"

/* The extent of a triangle, or of all, is the longest side of its axis-aligned box. */
struct triangle_figures {
    uint64_t count;
    /* No ray can hit a triangle that is inactive, or degenerate: active, with two equal positions.
     */
    uint64_t inactive, degenerate;
    uint32_t first_inactive, first_degenerate;
    /* Neither of these: a vertex has NaN in Y or Z, and none has NaN in X. What a build makes of
     * such a triangle is undefined. */
    uint64_t undefined;
    uint32_t first_undefined;

    /* Figures of the other triangles whose coordinates are all finite: how many these are. */
    uint64_t measured;
    float lower[3], upper[3];
    double extent;
    /* At least the median of the triangles' extents, and less than twice as large. If there are
     * more than 128 triangles, it is that of a sample. */
    double median;
    double farthest; /* the largest magnitude of a coordinate */
    double step;     /* from that coordinate to the next float */
    /* Triangles whose coordinates are so large that a step to the next float is larger than a
     * thousandth of the triangle's extent. Only of formats with 32 bits each, and if `farthest`
     * is at least eight times `extent`. */
    uint64_t coarse;
    uint32_t first_coarse;
    double smallest_coarse; /* the extent of the first coarse one */
};

/* Returns false if an index is out of range. */
bool triangle_figures_read(const struct source *source, struct triangle_figures *figures);

/* The one position that makes a geometry large: without it the extent is at most a thousandth. */
struct stray_vertex {
    uint32_t triangle; /* the first one that has it */
    float position[3];
    double extent; /* without it */
};
/* Returns false if there is no such position. `figures` are those of the same source. */
bool stray_vertex_find(const struct source *source, const struct triangle_figures *figures,
                       struct stray_vertex *stray);

/* Another stride of the vertices, with which triangles that jump across the geometry are small. */
struct other_stride {
    uint64_t stride;
    double extent, small; /* of all triangles that were read so, and what nearly all are within */
};
/* `figures` are those of the same source, and `size` the bytes of its vertices that can be read.
 * Returns false if there is no such stride, or if the triangles do not jump. */
bool other_stride_find(const struct source *source, const struct triangle_figures *figures,
                       uint64_t size, struct other_stride *other);

#endif
