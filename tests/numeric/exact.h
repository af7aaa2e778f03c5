/* SPDX-License-Identifier: Apache-2.0 */
/* Brute force in rational arithmetic (GMP): what a ray does to a triangle, beyond doubt. */
#ifndef ASSAY_TESTS_NUMERIC_EXACT_H
#define ASSAY_TESTS_NUMERIC_EXACT_H

#include "tests/builder/fixture.h"

enum exact_class {
    EXACT_OUTSIDE,
    EXACT_BOUNDARY, /* on an edge or a vertex, at a t that counts */
    EXACT_INSIDE,
};

struct exact_hit {
    enum exact_class class;
    double t; /* where it isn't outside; rounded once */
    bool front_face;
};

/* Three corners of finite floats. Outside, too, where t isn't between t_min and t_max. */
struct exact_hit exact_triangle(const struct trace_ray *ray, const float corners[9]);

/* Where the ray enters a sphere from outside; on the boundary: it touches it. */
struct exact_hit exact_sphere(const struct trace_ray *ray, const float center[3], float radius);

/* The sign of a 3x3 determinant. */
int exact_determinant_sign(const VkTransformMatrixKHR *transform);

#endif
