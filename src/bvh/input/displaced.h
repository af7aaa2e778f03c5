/* SPDX-License-Identifier: Apache-2.0 */
/* Displaced triangles: how many parts they are cut into, where those are, and their records.
 *
 * In a structure of which any triangle is displaced, all are cut: those that aren't displaced, or
 * aren't active, into one part. Primitives are parts there, as far as trees are concerned. The
 * vertices of all are computed once, to the scratch, in double and rounded to float at the end.
 * Where triangles share vertices, vectors, biases, scales and the values of an edge, they get the
 * same vertices on it, bit by bit: a sum of two terms doesn't depend on their order. */
#ifndef ASSAY_BVH_INPUT_DISPLACED_H
#define ASSAY_BVH_INPUT_DISPLACED_H

#include "src/bvh/input/source.h"

/* What a geometry's usages and its count of triangles allow at most; adds to what is there.
 * BUILDER_UNKNOWN_FORMAT where a usage has a format or level that there isn't. */
struct displaced_counts {
    uint64_t bases, parts, points;
};
enum builder_result displaced_count(const struct builder_displacement *displacement,
                                    uint32_t triangles, struct displaced_counts *counts);

/* Room for those; each geometry takes what it needs. */
struct displaced_room {
    struct displaced_base *bases;
    struct displaced_point *points, *motion_points; /* the latter NULL where nothing may move */
    struct displaced_counts left;
};

/* Cuts the triangles of an open source, whose count is then that of their parts. `displacement` may
 * be NULL. False where there are more parts than the usages say, at `base`. */
bool displaced_cut(struct source *source, const struct builder_displacement *displacement,
                   uint32_t first_vertex, const struct builder_resolver *micromaps,
                   struct displaced_room *room, uint32_t *base);

/* The triangle of which part `number` of the source is. */
uint32_t displaced_base_of(const struct source *source, uint32_t number);

/* Records of a part, but for geometry and opacity; `primitive` is the base's number. */
enum source_state displaced_read(const struct source *source, uint32_t number,
                                 struct displaced_record *record);
enum source_state displaced_read_motion(const struct source *source, uint32_t number,
                                        struct motion_displaced_record *record);
/* The same, of a part that is known. */
enum source_state displaced_read_part(const struct source *source, uint32_t base,
                                      struct displaced_part part, struct displaced_record *record);
enum source_state displaced_read_motion_part(const struct source *source, uint32_t base,
                                             struct displaced_part part,
                                             struct motion_displaced_record *record);

/* Whether the base has the level that a part of it was cut by, or none any more. */
bool displaced_is_alike(const struct source *source, uint32_t base, struct displaced_part part);

/* From barycentrics of a microtriangle to those of its base. */
void displaced_barycentrics(struct displaced_part part, float *u, float *v);

#endif
