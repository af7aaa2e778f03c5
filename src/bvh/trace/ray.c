/* SPDX-License-Identifier: Apache-2.0 */
/* Prepares rays, and transforms them into the space of an instance. */
#include "src/bvh/trace/ray.h"

/* The rounding error per plane of a box: the difference, the scale and the product each err by
 * 2^-24 of their value (subtraction is exact if the result is subnormal), together less than 3.1 *
 * 2^-24. */
#define SLAB_PAD (5 * 0x1p-24)

/* Relative to the origin: more than the world-space error of rounding a ray to float (2^-24). */
#define WORLD_PAD 0x1p-20

/* Ize, "Robust BVH Ray Traversal", 2013: padding the reciprocals suffices and costs nothing. If the
 * reciprocal of a small component overflows, near planes use the largest float and far planes
 * infinity; both are conservative. If a component is exactly 0, both use infinity, which excludes
 * rays outside the slab and gives NaN for rays on its planes. */
static void make_scales(double direction, double pad, float *near, float *far)
{
    double reciprocal = SLAB_UNITS / fabs(direction);
    *near = direction == 0 ? INFINITY : fminf((float)(reciprocal * (1 - pad)), FLT_MAX);
    *far = (float)(reciprocal * (1 + pad));
    *near = copysignf(*near, (float)direction);
    *far = copysignf(*far, (float)direction);
}

static void make_slab(struct local_ray *ray, enum trace_accuracy accuracy, double origin_pad)
{
    struct slab *slab = &ray->slab;
    for (uint32_t axis = 0; axis < 3; axis++) {
        double direction = ray->direction[axis], origin = ray->origin[axis];
        bool is_negative = signbit(direction);
        float low = ray->near_origin[axis], high = low, near_scale, far_scale;
        if (accuracy == TRACE_EXACT) {
            low = rounded_down(origin);
            high = rounded_up(origin);
        }
        if (origin_pad > 0) {
            low = rounded_down(low - origin_pad);
            high = rounded_up(high + origin_pad);
        }
        make_scales(direction, accuracy == TRACE_FAST ? 0 : SLAB_PAD, &near_scale, &far_scale);
        slab->near_origin[axis] = float4_all(is_negative ? low : high);
        slab->far_origin[axis] = float4_all(is_negative ? high : low);
        slab->near_scale[axis] = float4_all(near_scale);
        slab->far_scale[axis] = float4_all(far_scale);
        slab->near_plane[axis] = NODE_WIDTH * (axis + (is_negative ? 3 : 0));
        slab->far_plane[axis] = NODE_WIDTH * (axis + (is_negative ? 0 : 3));
    }
    slab->t_min = rounded_down(ray->t_min * SLAB_UNITS);
}

static void make_shear(struct local_ray *ray)
{
    uint32_t largest = 0;
    for (uint32_t axis = 1; axis < 3; axis++)
        if (fabs(ray->direction[axis]) > fabs(ray->direction[largest]))
            largest = axis;
    bool is_negative = ray->direction[largest] < 0;
    ray->axis[0] = (largest + (is_negative ? 2 : 1)) % 3;
    ray->axis[1] = (largest + (is_negative ? 1 : 2)) % 3;
    ray->axis[2] = largest;
    for (int i = 0; i < 3; i++) {
        ray->near_origin[i] = (float)ray->origin[i];
        ray->near_direction[i] = (float)ray->direction[i];
    }
    float z = ray->near_direction[largest];
    ray->shear[0] = ray->near_direction[ray->axis[0]] / z;
    ray->shear[1] = ray->near_direction[ray->axis[1]] / z;
    ray->shear[2] = 1 / z;
}

/* Scales the direction. Returns false if it is zero or not finite. */
static bool make_unit(struct local_ray *ray)
{
    double largest = 0;
    for (int i = 0; i < 3; i++) {
        if (!isfinite(ray->direction[i]) || !isfinite(ray->origin[i]))
            return false;
        largest = fmax(largest, fabs(ray->direction[i]));
    }
    if (largest == 0)
        return false;
    int exponent = ilogb(largest);
    double down = ldexp(1, -exponent);
    for (int i = 0; i < 3; i++)
        ray->direction[i] *= down;
    ray->unit = ldexp(1, exponent);
    return true;
}

void ray_limit(struct local_ray *local, double t_max)
{
    local->slab.t_max = rounded_up(t_max * local->unit * SLAB_UNITS);
}

static void finish(struct local_ray *local, const struct trace_ray *ray,
                   enum trace_accuracy accuracy, double origin_pad)
{
    local->t_min = ray->t_min * local->unit;
    make_shear(local);
    make_slab(local, accuracy, origin_pad);
    ray_limit(local, ray->t_max);
}

bool ray_make(struct local_ray *local, const struct trace_ray *ray, enum trace_accuracy accuracy,
              bool is_world)
{
    if (!(ray->t_min >= 0) || !(ray->t_max >= ray->t_min))
        return false;
    double farthest = 0;
    for (int i = 0; i < 3; i++) {
        local->origin[i] = ray->origin[i];
        local->direction[i] = ray->direction[i];
        farthest = fmax(farthest, fabs(local->origin[i]));
    }
    if (!make_unit(local))
        return false;
    finish(local, ray, accuracy, is_world ? farthest * WORLD_PAD : 0);
    return true;
}

/* Rounds to a multiple of the grid, so that products of the ray's components stay within the range
 * in which expansions are exact (expansion.h). Adding 1.5 * 2^52 times the grid removes all bits
 * below the grid. */
static double rounded_to(double x, double grid)
{
    double large = 0x1.8p52 * grid;
    return fabs(x) < 0x1p51 * grid ? (x + large) - large : x;
}

/* A ray in an instance's space is rounded once, in double. All triangles of an instance are tested
 * with the same ray, so edges stay watertight. The grids are far below the smallest subnormal float
 * (2^-149); vertices are multiples of that float. */
bool ray_enter(struct local_ray *local, const struct trace_ray *ray, enum trace_accuracy accuracy,
               const struct instance_record *instance)
{
    const double *m = instance->inverse;
    double from[3];
    for (int i = 0; i < 3; i++)
        from[i] = (double)ray->origin[i] - instance->instance.transform.matrix[i][3];
    for (int i = 0; i < 3; i++) {
        double x = m[3 * i], y = m[3 * i + 1], z = m[3 * i + 2];
        double origin = x * from[0] + y * from[1] + z * from[2];
        local->origin[i] = rounded_to(origin, 0x1p-300);
        local->direction[i] = x * ray->direction[0] + y * ray->direction[1] + z * ray->direction[2];
    }
    if (!make_unit(local))
        return false;
    for (int i = 0; i < 3; i++)
        local->direction[i] = rounded_to(local->direction[i], 0x1p-150);
    finish(local, ray, accuracy, 0);
    return true;
}
