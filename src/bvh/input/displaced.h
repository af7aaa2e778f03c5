/* SPDX-License-Identifier: Apache-2.0 */
/* Displaced triangles: the number of their parts, the vertices of the parts, and the records.
 *
 * If any triangle of a structure is displaced, all triangles are subdivided; undisplaced and
 * inactive triangles have one part. The primitives of the tree are then parts. All vertices are
 * computed once, into the scratch, in double and rounded to float at the end. Triangles that share
 * vertices, vectors, biases, scales and the values along an edge get bit-identical vertices on that
 * edge: a sum of two terms does not depend on their order. */
#ifndef ASSAY_BVH_INPUT_DISPLACED_H
#define ASSAY_BVH_INPUT_DISPLACED_H

#include "src/bvh/input/source.h"

/* Adds the maximum counts that the usages and the triangle count of a geometry allow. Returns
 * BUILDER_UNKNOWN_FORMAT if a usage has an invalid format or level. */
struct displaced_counts {
    uint64_t bases, parts, points;
};
enum builder_result displaced_count(const struct builder_displacement *displacement,
                                    uint32_t triangles, struct displaced_counts *counts);

/* The remaining room for those counts. Each geometry takes the room that it needs. */
struct displaced_room {
    struct displaced_base *bases;
    /* motion_points is NULL if the structure is static. */
    struct displaced_point *points, *motion_points;
    struct displaced_counts left;
};

/* Subdivides the triangles of an open source and sets its count to the number of parts.
 * `displacement` may be NULL. Returns false, with the triangle in `base`, if the parts exceed the
 * counts of the usages or the indices are not readable. */
bool displaced_cut(struct source *source, const struct builder_displacement *displacement,
                   uint32_t first_vertex, const struct builder_resolver *micromaps,
                   struct displaced_room *room, uint32_t *base);

/* Returns the base triangle of part `number` of the source. */
uint32_t displaced_base_of(const struct source *source, uint32_t number);

/* Read the record of a part except geometry and opacity; `primitive` is the number of the base
 * triangle. */
enum source_state displaced_read(const struct source *source, uint32_t number,
                                 struct displaced_record *record);
enum source_state displaced_read_motion(const struct source *source, uint32_t number,
                                        struct motion_displaced_record *record);
/* Read the record of a part whose base triangle is known. */
enum source_state displaced_read_part(const struct source *source, uint32_t base,
                                      struct displaced_part part, struct displaced_record *record);
enum source_state displaced_read_motion_part(const struct source *source, uint32_t base,
                                             struct displaced_part part,
                                             struct motion_displaced_record *record);

/* Returns whether the base triangle still has the level of the part, or is no longer active. */
bool displaced_level_matches(const struct source *source, uint32_t base,
                             struct displaced_part part);

/* Converts barycentrics of a microtriangle to barycentrics of its base triangle. */
void displaced_barycentrics(struct displaced_part part, float *u, float *v);

#endif
