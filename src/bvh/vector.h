/* SPDX-License-Identifier: Apache-2.0 */
/* Vectors of four floats, and boxes of such vectors. */
#ifndef ASSAY_BVH_VECTOR_H
#define ASSAY_BVH_VECTOR_H

#include <float.h>
#include <math.h>
#include <stdint.h>
#include <string.h>
#ifdef __SSE2__
#include <immintrin.h>
#endif

/* The compiler's vector types need a typedef. */
typedef float float4 __attribute__((vector_size(16)));
typedef int32_t int4 __attribute__((vector_size(16)));

static inline float4 float4_load(const float *from)
{
    float4 v;
    memcpy(&v, from, sizeof(v));
    return v;
}

static inline float4 float4_all(float x)
{
    return (float4){x, x, x, x};
}

/* float4_min and float4_max return `b` if `a` is NaN. */
static inline float4 float4_min(float4 a, float4 b)
{
#ifdef __SSE2__
    return _mm_min_ps(a, b);
#else
    for (int i = 0; i < 4; i++)
        a[i] = a[i] < b[i] ? a[i] : b[i];
    return a;
#endif
}

static inline float4 float4_max(float4 a, float4 b)
{
#ifdef __SSE2__
    return _mm_max_ps(a, b);
#else
    for (int i = 0; i < 4; i++)
        a[i] = a[i] > b[i] ? a[i] : b[i];
    return a;
#endif
}

/* Returns one bit per lane of a comparison's result. */
static inline unsigned int4_mask(int4 lanes)
{
#ifdef __SSE2__
    return (unsigned)_mm_movemask_ps((float4)lanes);
#else
    unsigned mask = 0;
    for (int i = 0; i < 4; i++)
        mask |= (unsigned)(lanes[i] != 0) << i;
    return mask;
#endif
}

static inline uint32_t float_bits(float x)
{
    uint32_t bits;
    memcpy(&bits, &x, sizeof(bits));
    return bits;
}

static inline float float_from_bits(uint32_t bits)
{
    float x;
    memcpy(&x, &bits, sizeof(x));
    return x;
}

/* For functions that are too short to justify a call. */
#define ALWAYS_INLINE inline __attribute__((always_inline))

/* Boxes use lanes 0 to 2. The owner of a box defines lane 3. */
struct box {
    float4 lower, upper;
};

static inline struct box box_empty(void)
{
    return (struct box){float4_all(INFINITY), float4_all(-INFINITY)};
}

static inline void box_add(struct box *box, float4 lower, float4 upper)
{
    box->lower = float4_min(lower, box->lower);
    box->upper = float4_max(upper, box->upper);
}

static inline float box_half_area(struct box box)
{
    float4 e = box.upper - box.lower;
    return e[0] * (e[1] + e[2]) + e[1] * e[2];
}

/* Returns a unit in which the longest side of the box is 1. In this unit the areas of contained
 * boxes do not overflow, and underflow is negligible. */
static inline float4 box_unit(struct box box)
{
    float4 extent = box.upper - box.lower;
    float longest = fmaxf(extent[0], fmaxf(extent[1], extent[2]));
    return float4_all(longest > 0x1p-126f ? 1 / longest : 0x1p126f);
}

static inline float box_half_area_in(struct box box, float4 unit)
{
    return box_half_area((struct box){box.lower * unit, box.upper * unit});
}

/* The least float not below `x`. Adds or subtracts 1 from the bits of the nearest float:
 * nextafterf() would be a call. */
static inline float rounded_up(double x)
{
    float near = (float)x;
    uint32_t bits = float_bits(near + 0.0f), step = bits >> 31 ? UINT32_MAX : 1;
    return float_from_bits((double)near < x ? bits + step : float_bits(near));
}

/* The greatest float not above `x`. */
static inline float rounded_down(double x)
{
    return -rounded_up(-x);
}

#endif
