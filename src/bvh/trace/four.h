/* SPDX-License-Identifier: Apache-2.0 */
/* Tests up to four triangles at once, by the same operations on each. */
#ifndef ASSAY_BVH_TRACE_FOUR_H
#define ASSAY_BVH_TRACE_FOUR_H

#include "src/bvh/trace/ray.h"

/* Below this value a product may have lost bits to underflow; above its reciprocal sums may
 * overflow. */
#define FLOAT_RANGE 0x1p-100f

/* at[vertex][axis] of four triangles; if there are fewer, the last one fills the lanes. */
struct four_triangles {
    float4 at[3][3];
};

static ALWAYS_INLINE void load_triangles(const uint8_t *records, uint64_t size, uint32_t count,
                                         struct four_triangles *four)
{
    const float *from[4] = {(const void *)records};
    for (uint32_t i = 1; i < 4; i++) { /* no branch: counts cannot be predicted */
        records += size & -(uint64_t)(i < count);
        from[i] = (const void *)records;
    }
    for (int vertex = 0; vertex < 3; vertex++) {
        float4 a = float4_load(from[0] + 4 * vertex), b = float4_load(from[1] + 4 * vertex);
        float4 c = float4_load(from[2] + 4 * vertex), d = float4_load(from[3] + 4 * vertex);
        float4 ab = __builtin_shufflevector(a, b, 0, 4, 1, 5);
        float4 cd = __builtin_shufflevector(c, d, 0, 4, 1, 5);
        four->at[vertex][0] = __builtin_shufflevector(ab, cd, 0, 1, 4, 5);
        four->at[vertex][1] = __builtin_shufflevector(ab, cd, 2, 3, 6, 7);
        ab = __builtin_shufflevector(a, b, 2, 6, 3, 7);
        cd = __builtin_shufflevector(c, d, 2, 6, 3, 7);
        four->at[vertex][2] = __builtin_shufflevector(ab, cd, 0, 1, 4, 5);
    }
}

static ALWAYS_INLINE float4 float4_abs(float4 v)
{
    return (float4)((int4)v & INT32_MAX);
}

/* Accuracy robust: Woop, Benthin, Wald, "Watertight Ray/Triangle Intersection", 2013. Both
 * triangles of an edge compute its function from the same rounded coordinates. Triangles whose
 * products are out of range are left to triangle_robust(). */
static ALWAYS_INLINE void four_robust(const struct local_ray *ray,
                                      const struct four_triangles *four, struct four_hits *hits)
{
    uint32_t along = ray->axis[2];
    float4 x[3], y[3], z[3];
    for (int i = 0; i < 3; i++) {
        float4 depth = four->at[i][along] - ray->near_origin[along];
        x[i] = four->at[i][ray->axis[0]] - ray->near_origin[ray->axis[0]] - ray->shear[0] * depth;
        y[i] = four->at[i][ray->axis[1]] - ray->near_origin[ray->axis[1]] - ray->shear[1] * depth;
        z[i] = ray->shear[2] * depth;
    }
    float4 u = x[2] * y[1] - y[2] * x[1];
    float4 v = x[0] * y[2] - y[0] * x[2];
    float4 w = x[1] * y[0] - y[1] * x[0];
    float4 least = float4_min(float4_abs(u), float4_min(float4_abs(v), float4_abs(w)));
    float4 sum = float4_abs(u) + float4_abs(v) + float4_abs(w);
    int4 is_in_range = (least > FLOAT_RANGE) & (sum < 1 / FLOAT_RANGE);
    int4 differ = ((int4)u ^ (int4)v) | ((int4)u ^ (int4)w);
    hits->found = ~int4_mask(is_in_range & (differ < 0)) & 15;
    if (hits->found == 0)
        return;
    float4 determinant = u + v + w, inverse = 1.0f / determinant;
    float4 t = (u * z[0] + v * z[1] + w * z[2]) / determinant;
    is_in_range &= float4_abs(t) < 1 / FLOAT_RANGE;
    hits->open = ~int4_mask(is_in_range) & 15;
    hits->found &= hits->open | int4_mask((t > ray->slab.t_min) & (t < ray->slab.t_max));
    hits->front = int4_mask(determinant > 0);
    u = v * inverse;
    v = w * inverse;
    memcpy(hits->t, &t, sizeof(t));
    memcpy(hits->u, &u, sizeof(u));
    memcpy(hits->v, &v, sizeof(v));
}

/* ---- accuracy exact */

#ifdef __AVX__
#define DOUBLE4_FROM(v) _mm256_cvtps_pd(v)
#define DOUBLE4_MASK(lanes) (unsigned)_mm256_movemask_pd((double4)(lanes))
#else
#define DOUBLE4_FROM(v) __builtin_convertvector(v, double4)
#define DOUBLE4_MASK(lanes) int4_mask(__builtin_convertvector(lanes, int4))
#endif

/* On which side of each edge the ray passes: see triangle.c. The side of an edge from P to Q is the
 * sign of (Q - P) . (d x P); little cancels in the difference if the origin is far away. Seven
 * roundings of 2^-53 err by less than 8 * 2^-53 of the sum of the magnitudes of the terms, which is
 * at most 4 * size * reach, since d is below 2. Leaves out triangles of which two edges certainly
 * have opposite signs. */
#define SIDE_BOUND (64 * 0x1p-53)

static ALWAYS_INLINE void four_exact(const struct local_ray *ray, const struct four_triangles *four,
                                     struct four_hits *hits)
{
    const double *d = ray->direction;
    double4 at[3][3], from[3][3], value[3], size = {0};
    int64x4 negative = {0}, positive = {0};
    for (int i = 0; i < 3; i++)
        for (int axis = 0; axis < 3; axis++) {
            at[i][axis] = DOUBLE4_FROM(four->at[i][axis]);
            from[i][axis] = at[i][axis] - ray->origin[axis];
        }
    for (int i = 0; i < 3; i++) {
        const double4 *p = at[(i + 1) % 3], *q = at[(i + 2) % 3], *a = from[(i + 1) % 3];
        double4 x = q[0] - p[0], y = q[1] - p[1], z = q[2] - p[2];
        value[i] = x * (d[1] * a[2] - d[2] * a[1]) + y * (d[2] * a[0] - d[0] * a[2]) +
                   z * (d[0] * a[1] - d[1] * a[0]);
        size += DOUBLE4_ABS(x) + DOUBLE4_ABS(y) + DOUBLE4_ABS(z);
    }
    double4 reach =
        size + DOUBLE4_ABS(from[0][0]) + DOUBLE4_ABS(from[0][1]) + DOUBLE4_ABS(from[0][2]);
    double4 bound = SIDE_BOUND * size * reach;
    for (int i = 0; i < 3; i++) {
        positive |= value[i] > bound;
        negative |= value[i] < -bound;
    }
    hits->found = ~DOUBLE4_MASK(positive & negative) & 15;
    if (hits->found == 0)
        return;
    for (int lane = 0; lane < 4; lane++)
        hits->edges[lane] =
            (struct exact_edges){{value[0][lane], value[1][lane], value[2][lane]}, bound[lane]};
}

#endif
