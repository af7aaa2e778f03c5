/* SPDX-License-Identifier: Apache-2.0 */
/* Filters: test up to four triangles at once and reject those that the test of an accuracy
 * certainly rejects, by the same operations on each. */
#ifndef ASSAY_BVH_TRACE_FILTER_H
#define ASSAY_BVH_TRACE_FILTER_H

#include "src/bvh/trace/ray.h"

/* Below this value a product may have lost bits to underflow; above its reciprocal sums may
 * overflow. */
#define FLOAT_RANGE 0x1p-100f

/* Differences, two products, their difference, the product by the direction and two sums: at most 8
 * roundings of 2^-53 for each term of the sum of magnitudes. */
#define EDGE_BOUND (16 * 0x1p-53)

/* at[vertex][axis] of four triangles; if there are fewer, the last one fills the lanes. */
struct four_triangles {
    float4 at[3][3];
};

static ALWAYS_INLINE void load_triangles(const uint8_t *records, uint64_t size, uint32_t count,
                                         struct four_triangles *four)
{
    const float *from[4];
    for (uint32_t i = 0; i < 4; i++)
        from[i] = (const void *)(records + (i < count ? i : count - 1) * size);
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

/* The signs of triangle_robust(). Keeps triangles whose products are out of range. */
static ALWAYS_INLINE unsigned filter_robust(const struct local_ray *ray,
                                            const struct four_triangles *four)
{
    uint32_t along = ray->axis[2];
    float4 x[3], y[3];
    for (int i = 0; i < 3; i++) {
        float4 depth = four->at[i][along] - ray->near_origin[along];
        x[i] = four->at[i][ray->axis[0]] - ray->near_origin[ray->axis[0]] - ray->shear[0] * depth;
        y[i] = four->at[i][ray->axis[1]] - ray->near_origin[ray->axis[1]] - ray->shear[1] * depth;
    }
    float4 u = x[2] * y[1] - y[2] * x[1];
    float4 v = x[0] * y[2] - y[0] * x[2];
    float4 w = x[1] * y[0] - y[1] * x[0];
    float4 least = float4_min(float4_abs(u), float4_min(float4_abs(v), float4_abs(w)));
    float4 sum = float4_abs(u) + float4_abs(v) + float4_abs(w);
    int4 is_in_range = (least > FLOAT_RANGE) & (sum < 1 / FLOAT_RANGE);
    int4 differ = ((int4)u ^ (int4)v) | ((int4)u ^ (int4)w);
    return ~int4_mask(is_in_range & differ) & 15;
}

/* The edges of triangle_exact(). Rejects triangles of which two edges certainly have opposite
 * signs. */
static ALWAYS_INLINE unsigned filter_exact(const struct local_ray *ray,
                                           const struct four_triangles *four)
{
    double4 at[3][3];
    int64x4 negative = {0}, positive = {0};
    for (int i = 0; i < 3; i++)
        for (int axis = 0; axis < 3; axis++)
            at[i][axis] = __builtin_convertvector(four->at[i][axis], double4) - ray->origin[axis];
    for (int i = 0; i < 3; i++) {
        const double4 *p = at[(i + 1) % 3], *q = at[(i + 2) % 3];
        double4 value = {0}, bound = {0};
        for (int axis = 0; axis < 3; axis++) {
            int j = (axis + 1) % 3, k = (axis + 2) % 3;
            double4 a = p[j] * q[k], b = p[k] * q[j];
            value += ray->direction[axis] * (a - b);
            bound += fabs(ray->direction[axis]) * (DOUBLE4_ABS(a) + DOUBLE4_ABS(b));
        }
        bound *= EDGE_BOUND;
        positive |= value > bound;
        negative |= value < -bound;
    }
    return ~int4_mask(__builtin_convertvector(positive & negative, int4)) & 15;
}

#endif
