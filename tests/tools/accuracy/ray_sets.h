/* SPDX-License-Identifier: Apache-2.0 */
/* Sets of rays against a closed sphere of triangles, from harmless to hard. */
#ifndef ASSAY_TESTS_ACCURACY_RAY_SETS_H
#define ASSAY_TESTS_ACCURACY_RAY_SETS_H

#include "tests/builder/fixture.h"

enum { RAY_SETS = 6 };

struct ray_set {
    const char *name;
    int crossings; /* 1 for rays from within the sphere, 0 for those from outside */
    float scale;   /* of the sphere, which has its center at 0 and else radius 1 */
    struct trace_ray (*make)(const struct fixture_mesh *sphere, uint64_t *random);
};

extern const struct ray_set ray_sets[RAY_SETS];

/* The sphere of a set, as fine as `side` says (fixture_sphere). */
struct fixture_mesh ray_set_sphere(const struct ray_set *set, uint32_t side);

#endif
