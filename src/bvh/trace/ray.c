/* SPDX-License-Identifier: Apache-2.0 */
/* Prepares rays, transforms them into the space of an instance, and processes what they meet. */
#include "src/bvh/trace/ray.h"

/* The distance of a plane is (plane - origin) * scale. Near and far planes have separate origins
 * and scales, padded so that no box is missed. Distances are scaled by 2^24, so that small ones do
 * not become subnormal, where rounding is no longer relative. */
#define SLAB_UNITS 0x1p24

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

static void finish_local_ray(struct local_ray *local, const struct trace_ray *ray,
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
    finish_local_ray(local, ray, accuracy, is_world ? farthest * WORLD_PAD : 0);
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
    finish_local_ray(local, ray, accuracy, 0);
    return true;
}

/* ---- AABBs as primitives: all intervals include their ends */

/* The relative error of the difference, the division and both sides of the comparison is below 4 *
 * 2^-53. The specification allows candidates outside the box; the pad can produce some. */
#define AABB_PAD (8 * 0x1p-53)

bool aabb_hit(const struct local_ray *ray, const struct aabb_record *box, double t_max, double *t)
{
    double enter = ray->t_min, leave = t_max;
    for (int axis = 0; axis < 3; axis++) {
        double direction = ray->direction[axis], origin = ray->origin[axis];
        double lower = box->lower[axis] - origin, upper = box->upper[axis] - origin;
        if (direction == 0) {
            if (lower > 0 || upper < 0)
                return false;
            continue;
        }
        double near = (direction > 0 ? lower : upper) / direction;
        double far = (direction > 0 ? upper : lower) / direction;
        enter = fmax(enter, near - fabs(near) * AABB_PAD);
        leave = fmin(leave, far + fabs(far) * AABB_PAD);
    }
    *t = enter;
    return enter <= leave;
}

/* ---- processes a candidate: opacity, culling, visitor */

static bool is_opaque(uint32_t ray_flags, const struct instance_record *instance, bool opaque)
{
    uint32_t flags = instance ? instance->instance.flags : 0;
    if (flags & VK_GEOMETRY_INSTANCE_FORCE_OPAQUE_BIT_KHR)
        opaque = true;
    else if (flags & VK_GEOMETRY_INSTANCE_FORCE_NO_OPAQUE_BIT_KHR)
        opaque = false;
    if (ray_flags & TRACE_OPAQUE)
        opaque = true;
    else if (ray_flags & TRACE_NO_OPAQUE)
        opaque = false;
    return opaque;
}

static bool is_culled(uint32_t ray_flags, const struct instance_record *instance,
                      const struct trace_hit *hit)
{
    if (ray_flags & (hit->opaque ? TRACE_CULL_OPAQUE : TRACE_CULL_NO_OPAQUE))
        return true;
    bool has_faces = !hit->is_aabb && !hit->is_sphere && !hit->is_swept;
    if (!has_faces || (instance && instance->instance.flags &
                                       VK_GEOMETRY_INSTANCE_TRIANGLE_FACING_CULL_DISABLE_BIT_KHR))
        return false;
    return ray_flags & (hit->front_face ? TRACE_CULL_FRONT_FACING : TRACE_CULL_BACK_FACING);
}

/* Facing is defined in object space. The transform of an instance does not change it; the
 * instance's flip flag does. */
static void set_instance(const struct instance_record *instance, struct trace_hit *hit)
{
    if (!instance)
        return;
    hit->instance = instance->primitive;
    hit->custom_index = instance->instance.instanceCustomIndex;
    hit->sbt_offset = instance->instance.instanceShaderBindingTableRecordOffset;
    if (instance->instance.flags & VK_GEOMETRY_INSTANCE_TRIANGLE_FLIP_FACING_BIT_KHR)
        hit->front_face = !hit->front_face;
}

/* Returns MICROMAP_NONE if no micromap defines the opacity. */
static enum micromap_state find_state(struct walk *walk, const struct view *view,
                                      const struct triangle_record *triangle,
                                      const struct local_hit *local)
{
    const struct builder_resolver *micromaps = &walk->scene->micromaps;
    uint32_t flags = view->instance ? view->instance->instance.flags : 0;
    if (flags & VK_GEOMETRY_INSTANCE_DISABLE_OPACITY_MICROMAPS_BIT_KHR)
        return MICROMAP_NONE;
    if (triangle->opacity >= OPACITY_SPECIAL)
        return (enum micromap_state) ~triangle->opacity;
    if (!micromaps->find || view->blas->micromap_count == 0)
        return MICROMAP_NONE;
    const void *micromap =
        micromaps->find(micromaps->context, structure_micromaps(view->blas)[triangle->geometry]);
    if (!micromap)
        return MICROMAP_NONE;
    walk->counters.micromaps++;
    return micromap_opacity(micromap, triangle->opacity - 1, local->u, local->v);
}

bool candidate_opacity(struct walk *walk, const struct view *view,
                       const struct triangle_record *triangle, const struct local_hit *local,
                       bool *opaque)
{
    enum micromap_state state = find_state(walk, view, triangle, local);
    bool has_two_states =
        walk->ray->flags & TRACE_FORCE_2_STATE ||
        (view->instance && view->instance->instance.flags &
                               VK_GEOMETRY_INSTANCE_FORCE_OPACITY_MICROMAP_2_STATE_BIT_KHR);
    switch (state) {
    case MICROMAP_TRANSPARENT:
        return false;
    case MICROMAP_OPAQUE:
        *opaque = true;
        return true;
    case MICROMAP_UNKNOWN_TRANSPARENT:
        *opaque = false;
        return !has_two_states;
    case MICROMAP_UNKNOWN_OPAQUE:
        *opaque = has_two_states;
        return true;
    case MICROMAP_NONE:
        return true;
    }
    return true;
}

void candidate_visit(struct walk *walk, struct view *view, struct trace_hit *hit, double t)
{
    uint32_t flags = walk->ray->flags;
    set_instance(view->instance, hit);
    hit->opaque = is_opaque(flags, view->instance, hit->opaque);
    if (is_culled(flags, view->instance, hit))
        return;
    float before = hit->t = (float)t;
    enum trace_answer answer = walk->visitor->visit(walk->visitor->context, hit);
    if (answer == TRACE_ACCEPT) {
        walk->t_max = hit->t == before ? t : hit->t;
        ray_limit(&view->ray, walk->t_max);
    }
    if (answer == TRACE_STOP || (answer == TRACE_ACCEPT && flags & TRACE_TERMINATE_ON_FIRST_HIT))
        walk->is_stopped = true;
}
