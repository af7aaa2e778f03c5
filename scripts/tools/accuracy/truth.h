/* SPDX-License-Identifier: Apache-2.0 */
/* Which triangles of a closed mesh a ray meets, in rational arithmetic, and whether an answer of
 * the reference builder is that. */
#ifndef ASSAY_TOOLS_ACCURACY_TRUTH_H
#define ASSAY_TOOLS_ACCURACY_TRUTH_H

#include "exact.h"
#include "tests/builder/fixture.h"

/* What bounds runs of triangles, so that few of them need rational arithmetic. */
struct truth_sphere {
    double center[3], radius;
};

struct truth_mesh {
    const struct fixture_mesh *mesh;
    struct truth_sphere *groups, *triangles;
    uint32_t group_count;
};

void truth_open(struct truth_mesh *truth, const struct fixture_mesh *mesh);
void truth_close(struct truth_mesh *truth);

enum { TRUTH_MOST = 64 };

/* The true result of one ray. */
struct truth {
    uint32_t count;
    uint32_t primitives[TRUTH_MOST];
    struct exact_hit hits[TRUTH_MOST]; /* inside or on the boundary */
    double nearest;                    /* INFINITY: none */
};

/* Ends the program where a ray meets more triangles than there is room for. */
void truth_find(const struct truth_mesh *mesh, const struct trace_ray *ray, struct truth *truth);

/* All that the ray meets is found, once where it crosses the surface at an edge or a vertex, and
 * nothing else is. `crossings` is how much more often it leaves the closed surface than it enters
 * it: 1 from within, 0 from outside. */
bool truth_allows(const struct truth *truth, const struct fixture_hits *hits, int crossings);

/* The nearest hit is a nearest one, at most one part in a thousand off; there is none only where
 * the ray meets nothing, or touches from outside. */
bool truth_allows_nearest(const struct truth *truth, bool is_hit, const struct trace_hit *hit,
                          int crossings);

#endif
