/* SPDX-License-Identifier: Apache-2.0 */
/* Four floats at once, and boxes of them. */
#ifndef ASSAY_BVH_VECTOR_H
#define ASSAY_BVH_VECTOR_H

#include <float.h>
#include <math.h>
#include <stdint.h>
#include <string.h>
#ifdef __SSE2__
#include <immintrin.h>
#endif

/* The compiler's vectors have no name without a typedef. */
typedef float float4 __attribute__((vector_size(16)));
typedef int32_t int4 __attribute__((vector_size(16)));

static inline float4 float4_load(const float *from)
{
    float4 v;
    memcpy(&v, from, sizeof(v));
    return v;
}

static inline void float4_store(float *to, float4 v)
{
    memcpy(to, &v, sizeof(v));
}

static inline float4 float4_all(float x)
{
    return (float4){x, x, x, x};
}

/* Both return `b` where `a` is NaN. */
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

/* One bit a lane of a comparison's result. */
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

/* For what most calls give too little work to pay for the call. */
#define ALWAYS_INLINE inline __attribute__((always_inline))

/* Boxes use lanes 0 to 2; what lane 3 holds is its owner's business. */
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

/* A unit in which the box's longest side is 1: areas of what it holds don't overflow, and what
 * underflows is too small to matter. */
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

/* The greatest float that is not above `x`, and the least that is not below it. */
static inline float rounded_down(double x)
{
    float near = (float)x;
    return (double)near > x ? nextafterf(near, -INFINITY) : near;
}

static inline float rounded_up(double x)
{
    float near = (float)x;
    return (double)near < x ? nextafterf(near, INFINITY) : near;
}

#endif
