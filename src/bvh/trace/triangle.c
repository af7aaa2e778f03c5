/* SPDX-License-Identifier: Apache-2.0 */
/* Accuracy fast: Moeller and Trumbore, "Fast, Minimum Storage Ray/Triangle Intersection", 1997. */
#include "src/bvh/expansion.h"
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
    const float *direction = (const float *)&ray->near_direction;
    float ab[3], ac[3], to_origin[3], p[3], q[3];
    for (int i = 0; i < 3; i++) {
        ab[i] = triangle->b[i] - triangle->a[i];
        ac[i] = triangle->c[i] - triangle->a[i];
        to_origin[i] = ray->near_origin[i] - triangle->a[i];
    }
    cross(direction, ac, p);
    cross(to_origin, ab, q);
    float determinant = dot(ab, p), inverse = 1 / determinant;
    float u = dot(to_origin, p) * inverse, v = dot(direction, q) * inverse;
    float t = dot(ac, q) * inverse;
    if (!(u >= 0 && v >= 0 && u + v <= 1 && t > ray->t_min && t < t_max))
        return false;
    *hit = (struct local_hit){t, u, v, determinant > 0};
    return true;
}

/* ---- Accuracy robust, for coordinates whose products may leave the range of floats: the products
 * of floats are exact in double, so a zero is exact. */

bool triangle_robust(const struct local_ray *ray, const struct triangle_record *triangle,
                     double t_max, struct local_hit *hit)
{
    const float *corners[3] = {triangle->a, triangle->b, triangle->c};
    uint32_t axis = ray->axis[0], other = ray->axis[1], along = ray->axis[2];
    double x[3], y[3], z[3]; /* relative to the origin, sheared so that the ray runs along z */
    for (int i = 0; i < 3; i++) {
        float depth = corners[i][along] - ray->near_origin[along];
        x[i] = corners[i][axis] - ray->near_origin[axis] - ray->shear[0] * depth;
        y[i] = corners[i][other] - ray->near_origin[other] - ray->shear[1] * depth;
        z[i] = ray->shear[2] * depth;
    }
    double u = x[2] * y[1] - y[2] * x[1];
    double v = x[0] * y[2] - y[0] * x[2];
    double w = x[1] * y[0] - y[1] * x[0];
    if ((u < 0 || v < 0 || w < 0) && (u > 0 || v > 0 || w > 0))
        return false;
    double determinant = u + v + w;
    double t = (u * z[0] + v * z[1] + w * z[2]) / determinant / SLAB_UNITS;
    if (determinant == 0 || !(t > ray->t_min && t < t_max))
        return false;
    *hit =
        (struct local_hit){t, (float)(v / determinant), (float)(w / determinant), determinant > 0};
    return true;
}

/* ---- Accuracy exact: decides without error on which side of each edge the ray passes.
 *
 * With A, B, C relative to the origin and direction d, the ray's line hits the triangle if d . (A x
 * B), d . (B x C), d . (C x A) have the same sign. four.h computes them in double with an error
 * bound; a sign within the bound is computed with expansions. A zero is resolved by an
 * infinitesimal perturbation of the direction: d + e f + e^2 g, where f and g are the two axes
 * other than the direction's largest (simulation of simplicity, Edelsbrunner and Muecke 1990). The
 * perturbation depends only on the ray, and the functions of an edge are exact opposites in its two
 * triangles. Therefore every ray, like a generic ray, hits each shared edge and closed fan exactly
 * once. If the result is still zero, the edge and the origin are collinear, and the ray sees the
 * triangle edge-on. */

/* Differences, products, their difference, the product with it and two sums: at most 8 roundings of
 * 2^-53 for each term of a sum of magnitudes. */
#define SUM_BOUND (16 * 0x1p-53)
/* If numerator and denominator are this accurate, t is computed in double. */
#define CERTAIN 0x1p-40
/* The resulting error of t is smaller than this; closer comparisons are exact. */
#define T_BOUND 0x1p-38

struct exact_corner {
    double terms[3][2];
    int count[3];
};

static void exact_difference(const double from[3], const float to[3], struct exact_corner *corner)
{
    for (int i = 0; i < 3; i++)
        corner->count[i] = expansion_difference(to[i], from[i], corner->terms[i]);
}

struct exact_normal {
    double terms[3][16];
    int count[3];
};

static void exact_cross(const struct exact_corner *p, const struct exact_corner *q,
                        struct exact_normal *normal)
{
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        double a[8], b[8];
        int m = expansion_product(p->count[j], p->terms[j], q->count[k], q->terms[k], a);
        int n = expansion_product(p->count[k], p->terms[k], q->count[j], q->terms[j], b);
        normal->count[i] = expansion_subtract(m, a, n, b, normal->terms[i]);
    }
}

/* Computes direction . normal, in at most 96 terms. */
static int exact_along(const double direction[3], const struct exact_normal *normal, double to[96])
{
    double part[3][32], sum[64];
    int n[3];
    for (int i = 0; i < 3; i++)
        n[i] = expansion_scale(normal->count[i], normal->terms[i], direction[i], part[i]);
    int m = expansion_sum(n[0], part[0], n[1], part[1], sum);
    return expansion_sum(m, sum, n[2], part[2], to);
}

static int exact_edge_sign(const struct local_ray *ray, const float p[3], const float q[3])
{
    struct exact_corner a, b;
    struct exact_normal normal;
    double sum[96];
    exact_difference(ray->origin, p, &a);
    exact_difference(ray->origin, q, &b);
    exact_cross(&a, &b, &normal);
    int sign = expansion_sign(exact_along(ray->direction, &normal, sum), sum);
    for (int i = 0; i < 2 && sign == 0; i++)
        sign = expansion_sign(normal.count[ray->axis[i]], normal.terms[ray->axis[i]]);
    return sign;
}

/* t as a quotient of expansions: A . (B x C) / d . ((B - A) x (C - A)). */
struct exact_t {
    double numerator[192], denominator[96];
    int numerator_count, denominator_count;
};

static void make_exact_t(const struct local_ray *ray, const struct triangle_record *triangle,
                         struct exact_t *t)
{
    struct exact_corner a, b, c;
    struct exact_normal normal;
    exact_difference(ray->origin, triangle->a, &a);
    exact_difference(ray->origin, triangle->b, &b);
    exact_difference(ray->origin, triangle->c, &c);
    exact_cross(&b, &c, &normal);
    double part[3][64], sum[128];
    int n[3];
    for (int i = 0; i < 3; i++)
        n[i] = expansion_product(normal.count[i], normal.terms[i], a.count[i], a.terms[i], part[i]);
    int m = expansion_sum(n[0], part[0], n[1], part[1], sum);
    t->numerator_count = expansion_sum(m, sum, n[2], part[2], t->numerator);

    double corner[3] = {triangle->a[0], triangle->a[1], triangle->a[2]};
    exact_difference(corner, triangle->b, &b);
    exact_difference(corner, triangle->c, &c);
    exact_cross(&b, &c, &normal);
    t->denominator_count = exact_along(ray->direction, &normal, t->denominator);
}

/* Returns the sign of t - limit. */
static int compare_exact_t(const struct exact_t *t, double limit)
{
    int sign = expansion_sign(t->denominator_count, t->denominator);
    if (isinf(limit))
        return -1;
    double scaled[192], difference[384];
    int n = expansion_scale(t->denominator_count, t->denominator, limit, scaled);
    int m = expansion_subtract(t->numerator_count, t->numerator, n, scaled, difference);
    return sign * expansion_sign(m, difference);
}

static bool is_close(double t, double limit)
{
    return fabs(t - limit) <= T_BOUND * fabs(t);
}

/* Returns whether t is within the limits, and the best double approximation of t: A . N / d . N
 * with the normal N = (B - A) x (C - A), in which less cancels than in products of the corners. */
static bool compute_t(const struct local_ray *ray, const struct triangle_record *triangle,
                      double t_max, double *t, uint64_t *exact_calls)
{
    double ab[3], ac[3], numerator = 0, bound = 0, along = 0, along_bound = 0;
    for (int i = 0; i < 3; i++) {
        ab[i] = (double)triangle->b[i] - triangle->a[i];
        ac[i] = (double)triangle->c[i] - triangle->a[i];
    }
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        double left = ab[j] * ac[k], right = ab[k] * ac[j], size = fabs(left) + fabs(right);
        double from = triangle->a[i] - ray->origin[i];
        numerator += from * (left - right);
        bound += fabs(from) * size;
        along += ray->direction[i] * (left - right);
        along_bound += fabs(ray->direction[i]) * size;
    }
    *t = numerator / along;
    bool is_certain = bound * SUM_BOUND <= CERTAIN * fabs(numerator) &&
                      along_bound * SUM_BOUND <= CERTAIN * fabs(along);
    if (is_certain && !is_close(*t, ray->t_min) && !is_close(*t, t_max))
        return *t > ray->t_min && *t < t_max;
    struct exact_t exact;
    ++*exact_calls;
    make_exact_t(ray, triangle, &exact);
    if (exact.denominator_count == 0) /* the ray lies in the triangle's plane */
        return false;
    *t = expansion_estimate(exact.numerator_count, exact.numerator) /
         expansion_estimate(exact.denominator_count, exact.denominator);
    return compare_exact_t(&exact, ray->t_min) > 0 && compare_exact_t(&exact, t_max) < 0;
}

bool triangle_exact(const struct local_ray *ray, const struct triangle_record *triangle,
                    const struct exact_edges *edges, double t_max, struct local_hit *hit,
                    uint64_t *exact_calls)
{
    const float *vertices[3] = {triangle->a, triangle->b, triangle->c};
    int signs = 0; /* signs found: 1 negative, 2 positive */
    if (!isfinite(edges->bound))
        return false;
    for (int i = 0; i < 3; i++)
        if (fabs(edges->value[i]) > edges->bound)
            signs |= edges->value[i] > 0 ? 2 : 1;
    for (int i = 0; i < 3; i++) {
        if (fabs(edges->value[i]) > edges->bound)
            continue;
        ++*exact_calls;
        int sign = exact_edge_sign(ray, vertices[(i + 1) % 3], vertices[(i + 2) % 3]);
        signs |= sign > 0 ? 2 : 1;
        if (sign == 0 || signs == 3)
            return false;
    }
    if (!compute_t(ray, triangle, t_max, &hit->t, exact_calls))
        return false;
    double sum = edges->value[0] + edges->value[1] + edges->value[2];
    hit->u = (float)(edges->value[1] / sum);
    hit->v = (float)(edges->value[2] / sum);
    hit->front_face = signs == 1;
    return true;
}
