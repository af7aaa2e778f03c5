/* SPDX-License-Identifier: Apache-2.0 */
/* Embree 3, the measure of the reference builder: the same meshes, its builders and its rays. */
#ifndef ASSAY_TOOLS_ACCURACY_EMBREE_H
#define ASSAY_TOOLS_ACCURACY_EMBREE_H

#include "tests/builder/fixture.h"

struct embree_tree {
    double seconds; /* of rtcBuildBVH alone */
    double sah;     /* as builder_measure() counts it: width and leaf sizes are the same */
};

enum embree_quality { EMBREE_LOW, EMBREE_MEDIUM, EMBREE_HIGH };

/* One thread. */
struct embree_tree embree_build(const struct fixture_mesh *mesh, enum embree_quality quality);

struct embree_scene;
struct embree_scene *embree_scene_create(const struct fixture_mesh *mesh,
                                         enum embree_quality quality);
void embree_scene_destroy(struct embree_scene *scene);
bool embree_trace(struct embree_scene *scene, const struct trace_ray *ray, struct trace_hit *hit);

/* ---- meshes from files that assimp reads, with one vertex a position, and rays (model.c) */

/* Says on stderr why not. */
bool model_load(const char *path, struct fixture_mesh *mesh);

/* A ray from a point in or about a box to one in it. The margin around the box is in terms of its
 * size. */
struct trace_ray model_random_ray(const float lower[3], const float upper[3], float margin,
                                  uint64_t *random);

#endif
