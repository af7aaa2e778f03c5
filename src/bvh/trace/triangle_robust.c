/* SPDX-License-Identifier: Apache-2.0 */
/* Accuracy robust: Woop, Benthin, Wald, "Watertight Ray/Triangle Intersection", 2013. */
#include "src/bvh/trace/ray.h"

/* Below this value a product may have lost bits to underflow; above its reciprocal sums may
 * overflow. */
#define FLOAT_RANGE 0x1p-100f

/* Vertices relative to the origin, sheared so that the ray runs along the third axis. */
struct sheared {
    float x[3], y[3], z[3];
};

static void shear(const struct local_ray *ray, const struct triangle_record *triangle,
                  struct sheared *to)
{
    const float *corners[3] = {triangle->a, triangle->b, triangle->c};
    uint32_t x = ray->axis[0], y = ray->axis[1], z = ray->axis[2];
    for (int i = 0; i < 3; i++) {
        float depth = corners[i][z] - ray->near_origin[z];
        to->x[i] = corners[i][x] - ray->near_origin[x] - ray->shear[0] * depth;
        to->y[i] = corners[i][y] - ray->near_origin[y] - ray->shear[1] * depth;
        to->z[i] = ray->shear[2] * depth;
    }
}

/* Both triangles of an edge compute its function from the same rounded coordinates. In double the
 * products are exact, so a zero is exact. */
static bool hit_in_double(const struct sheared *s, double t_min, double t_max,
                          struct local_hit *hit)
{
    double u = (double)s->x[2] * s->y[1] - (double)s->y[2] * s->x[1];
    double v = (double)s->x[0] * s->y[2] - (double)s->y[0] * s->x[2];
    double w = (double)s->x[1] * s->y[0] - (double)s->y[1] * s->x[0];
    if ((u < 0 || v < 0 || w < 0) && (u > 0 || v > 0 || w > 0))
        return false;
    double determinant = u + v + w;
    double t = (u * s->z[0] + v * s->z[1] + w * s->z[2]) / determinant;
    if (determinant == 0 || !(t > t_min && t < t_max))
        return false;
    *hit =
        (struct local_hit){t, (float)(v / determinant), (float)(w / determinant), determinant > 0};
    return true;
}

bool triangle_robust(const struct local_ray *ray, const struct triangle_record *triangle,
                     double t_max, struct local_hit *hit)
{
    struct sheared s;
    shear(ray, triangle, &s);
    float u = s.x[2] * s.y[1] - s.y[2] * s.x[1];
    float v = s.x[0] * s.y[2] - s.y[0] * s.x[2];
    float w = s.x[1] * s.y[0] - s.y[1] * s.x[0];
    float least = fminf(fabsf(u), fminf(fabsf(v), fabsf(w)));
    float sum = fabsf(u) + fabsf(v) + fabsf(w);
    if (!(least > FLOAT_RANGE && sum < 1 / FLOAT_RANGE))
        return hit_in_double(&s, ray->t_min, t_max, hit);
    if ((u < 0 || v < 0 || w < 0) && (u > 0 || v > 0 || w > 0))
        return false;
    float determinant = u + v + w;
    float t = (u * s.z[0] + v * s.z[1] + w * s.z[2]) / determinant;
    if (!isfinite(t))
        return hit_in_double(&s, ray->t_min, t_max, hit);
    if (!(t > ray->t_min && t < t_max))
        return false;
    float inverse = 1 / determinant;
    *hit = (struct local_hit){t, v * inverse, w * inverse, determinant > 0};
    return true;
}
