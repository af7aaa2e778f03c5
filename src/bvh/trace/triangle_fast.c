/* SPDX-License-Identifier: Apache-2.0 */
/* Accuracy fast: Moeller and Trumbore, "Fast, Minimum Storage Ray/Triangle Intersection", 1997. */
#include "src/bvh/trace/ray.h"

static float dot(const float a[3], const float b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void cross(const float a[3], const float b[3], float to[3])
{
    to[0] = a[1] * b[2] - a[2] * b[1];
    to[1] = a[2] * b[0] - a[0] * b[2];
    to[2] = a[0] * b[1] - a[1] * b[0];
}

/* Comparisons with NaN are false, so an overflow is never a hit. */
bool triangle_fast(const struct local_ray *ray, const struct triangle_record *triangle,
                   double t_max, struct local_hit *hit)
{
    float ab[3], ac[3], to_origin[3], p[3], q[3];
    for (int i = 0; i < 3; i++) {
        ab[i] = triangle->b[i] - triangle->a[i];
        ac[i] = triangle->c[i] - triangle->a[i];
        to_origin[i] = ray->near_origin[i] - triangle->a[i];
    }
    cross(ray->near_direction, ac, p);
    cross(to_origin, ab, q);
    float determinant = dot(ab, p), inverse = 1 / determinant;
    float u = dot(to_origin, p) * inverse, v = dot(ray->near_direction, q) * inverse;
    float t = dot(ac, q) * inverse;
    if (!(u >= 0 && v >= 0 && u + v <= 1 && t > ray->t_min && t < t_max))
        return false;
    *hit = (struct local_hit){t, u, v, determinant > 0};
    return true;
}
