/* SPDX-License-Identifier: Apache-2.0 */
/* Processes what rays meet. */
#include "src/bvh/trace/ray.h"

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
        /* fmax() and fmin() would make 0 or -0 of both. An infinite plane makes a NaN, which is
         * left out. */
        near -= fabs(near) * AABB_PAD;
        far += fabs(far) * AABB_PAD;
        enter = near > enter ? near : enter;
        leave = far < leave ? far : leave;
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
    double distance = t / view->ray.unit;
    float before = hit->t = (float)distance;
    enum trace_answer answer = walk->visitor->visit(walk->visitor->context, hit);
    if (answer == TRACE_ACCEPT) {
        bool is_same = hit->t == before;
        walk->t_max = is_same ? distance : hit->t;
        ray_limit(&view->ray, is_same ? t : walk->t_max * view->ray.unit);
    }
    if (answer == TRACE_STOP || (answer == TRACE_ACCEPT && flags & TRACE_TERMINATE_ON_FIRST_HIT))
        walk->is_stopped = true;
}
