/* SPDX-License-Identifier: Apache-2.0 */
/* Prepares rays, and transforms them into the space of an instance. Signs and axes of rays are
 * random, so nothing here branches on them. */
#ifndef ASSAY_BVH_TRACE_PREPARE_H
#define ASSAY_BVH_TRACE_PREPARE_H

#include "src/bvh/trace/ray.h"

/* The rounding error per plane of a box: the difference, the scale and the product each err by
 * 2^-24 of their value (subtraction is exact if the result is subnormal), together less than 3.1 *
 * 2^-24. */
#define SLAB_PAD (5 * 0x1p-24)

/* Relative to the origin: more than the world-space error of rounding a ray to float (2^-24). */
#define WORLD_PAD 0x1p-20

static inline double double_from_bits(uint64_t bits)
{
    double x;
    memcpy(&x, &bits, sizeof(x));
    return x;
}

/* The origins of near and far planes, before they are exchanged for negative directions. */
static inline void pad_origins(const struct local_ray *ray, double pad, float4 *low, float4 *high)
{
    for (int axis = 0; axis < 3; axis++) {
        (*low)[axis] = rounded_down(ray->origin[axis] - pad);
        (*high)[axis] = rounded_up(ray->origin[axis] + pad);
    }
}

/* Ize, "Robust BVH Ray Traversal", 2013: padding the reciprocals suffices and costs nothing. If the
 * reciprocal of a small component overflows, near planes use the largest float and far planes
 * infinity; both are conservative. If a component is exactly 0, both use infinity, which excludes
 * rays outside the slab and gives NaN for rays on its planes. */
static ALWAYS_INLINE void make_slab(struct local_ray *ray, const double4 *direction,
                                    const double4 *reciprocal, enum trace_accuracy accuracy,
                                    double origin_pad)
{
    struct slab *slab = &ray->slab;
    const double pad = accuracy == TRACE_FAST ? 0 : SLAB_PAD;
    const int4 axes = {0, 1, 2, 0}, zero = __builtin_convertvector(*direction == 0, int4);
    const int4 signs = (int4)ray->near_direction & INT32_MIN, negative = signs >> 31;
    float4 near_scale = __builtin_convertvector(*reciprocal * (1 - pad), float4);
    float4 far_scale = __builtin_convertvector(*reciprocal * (1 + pad), float4);
    float4 low = ray->near_origin, high = low;
    if (origin_pad >= 0)
        pad_origins(ray, origin_pad, &low, &high);
    near_scale = float4_min(near_scale, float4_all(FLT_MAX));
    near_scale = (float4)(((int4)near_scale & ~zero) | ((int4)float4_all(INFINITY) & zero));
    slab->near_scale = (float4)((int4)near_scale | signs);
    slab->far_scale = (float4)((int4)far_scale | signs);
    slab->near_origin = (float4)(((int4)low & negative) | ((int4)high & ~negative));
    slab->far_origin = (float4)(((int4)high & negative) | ((int4)low & ~negative));
    slab->near_plane = (axes + (negative & 3)) * (int)NODE_WIDTH;
    slab->far_plane = (axes + (~negative & 3)) * (int)NODE_WIDTH;
    slab->t_min = rounded_down(ray->t_min * SLAB_UNITS) + 0.0f; /* never -0 */
}

static ALWAYS_INLINE void make_shear(struct local_ray *ray, const double4 *direction)
{
    static const uint8_t next[] = {0, 1, 2, 0, 1};
    const double4 size = DOUBLE4_ABS(*direction);
    uint32_t y_wins = size[1] > size[0], z_wins = (size[2] > size[0]) & (size[2] > size[1]);
    uint32_t largest = z_wins << 1 | (y_wins & ~z_wins);
    uint32_t is_negative = float_bits(ray->near_direction[largest]) >> 31;
    ray->axis[0] = next[largest + 1 + is_negative];
    ray->axis[1] = next[largest + 2 - is_negative];
    ray->axis[2] = largest;
    float4 d = ray->near_direction;
    ray->shear = (float4){d[ray->axis[0]], d[ray->axis[1]], SLAB_UNITS, 1} / d[largest];
}

/* Scales the direction. Returns false if it is zero or not finite. */
static ALWAYS_INLINE bool make_unit(const double4 *origin, double4 *direction, double *unit)
{
    const double4 size = DOUBLE4_ABS(*direction);
    double largest = size[0] > size[1] ? size[0] : size[1];
    largest = size[2] > largest ? size[2] : largest;
    /* Infinity - infinity is NaN. */
    const double4 zero = (*direction - *direction) + (*origin - *origin);
    if (!(zero[0] + zero[1] + zero[2] == 0) || largest == 0)
        return false;
    uint64_t bits, exponent;
    memcpy(&bits, &largest, sizeof(bits));
    exponent = bits >> 52;
    double scale = double_from_bits((2046 - exponent) << 52);
    *unit = double_from_bits(exponent << 52);
    if (exponent == 0 || exponent > 2045) { /* the number or its reciprocal is subnormal */
        *unit = ldexp(1, ilogb(largest));
        scale = ldexp(1, -ilogb(largest));
    }
    *direction *= scale;
    return true;
}

/* `unit` is that of make_unit(), `reciprocal` that of the direction in slab units. `origin_pad` is
 * negative if the origin as floats is exact or exact enough. */
static ALWAYS_INLINE void finish_local_ray(struct local_ray *local, const struct trace_ray *ray,
                                           const double4 *origin, const double4 *direction,
                                           const double4 *reciprocal, double unit,
                                           enum trace_accuracy accuracy, double origin_pad)
{
    memcpy(local->origin, origin, sizeof(*origin));
    memcpy(local->direction, direction, sizeof(*direction));
    local->near_origin = __builtin_convertvector(*origin, float4);
    local->near_direction = __builtin_convertvector(*direction, float4);
    local->unit = unit;
    local->t_min = ray->t_min * unit;
    make_shear(local, direction);
    make_slab(local, direction, reciprocal, accuracy, origin_pad);
    ray_limit(local, ray->t_max * unit);
}

/* Returns false if the ray cannot hit anything. `is_world` pads for the rounding of rays that enter
 * instances. */
static ALWAYS_INLINE bool ray_make(struct local_ray *local, const struct trace_ray *ray,
                                   enum trace_accuracy accuracy, bool is_world)
{
    const float *o = ray->origin, *d = ray->direction;
    /* Zeros would become an instruction that Valgrind 3.19 lacks. */
    double4 origin = {o[0], o[1], o[2], o[2]}, direction = {d[0], d[1], d[2], d[2]};
    /* Does not wait for the unit, by which it is multiplied exactly. */
    double4 reciprocal = SLAB_UNITS / DOUBLE4_ABS(direction);
    double unit, pad = -1;
    if (!(ray->t_min >= 0) || !(ray->t_max >= ray->t_min) || !make_unit(&origin, &direction, &unit))
        return false;
    if (is_world)
        pad = fmax(fabs(origin[0]), fmax(fabs(origin[1]), fabs(origin[2]))) * WORLD_PAD;
    reciprocal *= unit;
    finish_local_ray(local, ray, &origin, &direction, &reciprocal, unit, accuracy, pad);
    return true;
}

/* Rounds to a multiple of the grid, so that products of the ray's components stay within the range
 * in which expansions are exact (expansion.h). Adding 1.5 * 2^52 times the grid removes all bits
 * below the grid. */
static inline double rounded_to(double x, double grid)
{
    double large = 0x1.8p52 * grid;
    return fabs(x) < 0x1p51 * grid ? (x + large) - large : x;
}

/* A ray in an instance's space is rounded once, in double. All triangles of an instance are tested
 * with the same ray, so edges stay watertight. The grids are far below the smallest subnormal float
 * (2^-149); vertices are multiples of that float. Returns false if the matrix is singular. */
static ALWAYS_INLINE bool ray_enter(struct local_ray *local, const struct trace_ray *ray,
                                    enum trace_accuracy accuracy,
                                    const struct instance_record *instance)
{
    const double *m = instance->inverse;
    double4 origin = {0}, direction = {0};
    double from[3], unit;
    for (int i = 0; i < 3; i++)
        from[i] = (double)ray->origin[i] - instance->instance.transform.matrix[i][3];
    for (int i = 0; i < 3; i++) {
        double x = m[3 * i], y = m[3 * i + 1], z = m[3 * i + 2];
        origin[i] = rounded_to(x * from[0] + y * from[1] + z * from[2], 0x1p-300);
        direction[i] = x * ray->direction[0] + y * ray->direction[1] + z * ray->direction[2];
    }
    if (!make_unit(&origin, &direction, &unit))
        return false;
    for (int i = 0; i < 3; i++)
        direction[i] = rounded_to(direction[i], 0x1p-150);
    const double4 reciprocal = SLAB_UNITS / DOUBLE4_ABS(direction);
    finish_local_ray(local, ray, &origin, &direction, &reciprocal, unit, accuracy,
                     accuracy == TRACE_EXACT ? 0 : -1);
    return true;
}

#endif
