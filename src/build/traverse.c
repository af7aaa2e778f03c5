/* SPDX-License-Identifier: Apache-2.0 */
/* Walks trees without recursion: a stack of fixed size for a BLAS, another for the TLAS above it,
 * both as deep as trees may be (structure.h).
 * "Ray Intersection Candidate Determination" and "Ray Intersection Culling" say what counts. */
#include "build/motion.h"
#include "build/ray.h"

struct waiting_child {
    uint32_t child;
    float enter;
};

struct walk {
    const struct trace_scene *scene;
    const struct trace_ray *ray;
    const struct trace_visitor *visitor;
    struct trace_counters counters;
    double t_max; /* in the caller's distances; what has been accepted shortens it */
    bool is_stopped;
};

/* The instance that a BLAS is seen through; NULL: none. */
struct view {
    const struct structure_header *blas;
    const struct instance_record *instance;
    struct local_ray ray;
};

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

/* Facing is that of object space: an instance's transform leaves it alone, its flag turns it. */
static void name_instance(const struct instance_record *instance, struct trace_hit *hit)
{
    if (!instance)
        return;
    hit->instance = instance->primitive;
    hit->custom_index = instance->instance.instanceCustomIndex;
    hit->sbt_offset = instance->instance.instanceShaderBindingTableRecordOffset;
    if (instance->instance.flags & VK_GEOMETRY_INSTANCE_TRIANGLE_FLIP_FACING_BIT_KHR)
        hit->front_face = !hit->front_face;
}

/* MICROMAP_NONE where none says anything. */
static enum micromap_state look_up(struct walk *walk, const struct view *view,
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

/* "Ray Opacity Micromap": what the instance and the ray may then override; false: ignored. */
static bool begin_opacity(struct walk *walk, const struct view *view,
                          const struct triangle_record *triangle, const struct local_hit *local,
                          bool *opaque)
{
    enum micromap_state state = look_up(walk, view, triangle, local);
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

/* `opaque` in the hit is what its geometry or micromap says. */
static void offer(struct walk *walk, struct view *view, struct trace_hit *hit, double t)
{
    uint32_t flags = walk->ray->flags;
    name_instance(view->instance, hit);
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

static bool geometry_is_opaque(const struct view *view, uint32_t geometry)
{
    return structure_geometries(view->blas)[geometry].flags & VK_GEOMETRY_OPAQUE_BIT_KHR;
}

static void test_triangle(struct walk *walk, struct view *view,
                          const struct triangle_record *triangle)
{
    struct local_hit local;
    double t_max = walk->t_max * view->ray.unit;
    bool is_hit = false;
    switch (walk->scene->accuracy) {
    case TRACE_FAST:
        is_hit = triangle_fast(&view->ray, triangle, t_max, &local);
        break;
    case TRACE_ROBUST:
        is_hit = triangle_robust(&view->ray, triangle, t_max, &local);
        break;
    case TRACE_EXACT:
        is_hit = triangle_exact(&view->ray, triangle, t_max, &local, &walk->counters.exact_calls);
        break;
    }
    if (!is_hit)
        return;
    struct trace_hit hit = {.u = local.u,
                            .v = local.v,
                            .geometry = triangle->geometry,
                            .primitive = triangle->primitive,
                            .front_face = local.front_face,
                            .opaque = geometry_is_opaque(view, triangle->geometry)};
    if (triangle->opacity != 0 && !begin_opacity(walk, view, triangle, &local, &hit.opaque))
        return;
    offer(walk, view, &hit, local.t / view->ray.unit);
}

static void test_aabb(struct walk *walk, struct view *view, const struct aabb_record *box)
{
    double t;
    if (!aabb_hit(&view->ray, box, walk->t_max * view->ray.unit, &t))
        return;
    struct trace_hit hit = {
        .geometry = box->geometry,
        .primitive = box->primitive,
        .is_aabb = true,
        .opaque = geometry_is_opaque(view, box->geometry),
    };
    offer(walk, view, &hit, t / view->ray.unit);
}

static void test_sphere(struct walk *walk, struct view *view, const void *record)
{
    bool is_swept = view->blas->kind == STRUCTURE_SWEPT_SPHERES;
    bool is_exact = walk->scene->accuracy == TRACE_EXACT;
    double t_max = walk->t_max * view->ray.unit;
    const struct sphere_record *sphere = record; /* swept ones have their numbers there, too */
    struct local_hit local;
    if (!(is_swept
              ? swept_hit(&view->ray, record, is_exact, t_max, &local, &walk->counters.exact_calls)
              : sphere_hit(&view->ray, record, is_exact, t_max, &local,
                           &walk->counters.exact_calls)))
        return;
    struct trace_hit hit = {
        .u = local.u,
        .geometry = sphere->geometry,
        .primitive = sphere->primitive,
        .is_sphere = !is_swept,
        .is_swept = is_swept,
        .opaque = geometry_is_opaque(view, sphere->geometry),
    };
    offer(walk, view, &hit, local.t / view->ray.unit);
}

static void test_motion_triangle(struct walk *walk, struct view *view,
                                 const struct motion_triangle_record *record)
{
    struct triangle_record now;
    motion_triangle_at(record, walk->ray->time, &now);
    test_triangle(walk, view, &now);
}

static void test_record(struct walk *walk, struct view *view, const void *record)
{
    switch ((enum structure_kind)view->blas->kind) {
    case STRUCTURE_TRIANGLES:
        test_triangle(walk, view, record);
        return;
    case STRUCTURE_AABBS:
        test_aabb(walk, view, record);
        return;
    case STRUCTURE_MOTION_TRIANGLES:
        test_motion_triangle(walk, view, record);
        return;
    case STRUCTURE_SPHERES:
    case STRUCTURE_SWEPT_SPHERES:
        test_sphere(walk, view, record);
        return;
    case STRUCTURE_INSTANCES:
    case STRUCTURE_MOTION_INSTANCES:
        return;
    }
}

static void test_leaf(struct walk *walk, struct view *view, uint32_t child)
{
    uint32_t first = leaf_first(child), count = leaf_count(child);
    uint64_t size = structure_record_size(view->blas->kind);
    const uint8_t *record = (const uint8_t *)structure_records(view->blas) + first * size;
    walk->counters.primitives += count;
    for (; count > 0 && !walk->is_stopped; count--, record += size)
        test_record(walk, view, record);
}

/* Puts the children that the ray may meet on the stack, the nearest on top. */
static uint32_t push_children(const struct wide_node *node, const struct slab *slab,
                              struct waiting_child *stack, uint32_t count)
{
    float4 enter;
    uint32_t bottom = count;
    for (unsigned mask = slab_test(slab, node, &enter); mask != 0; mask &= mask - 1) {
        uint32_t lane = (uint32_t)__builtin_ctz(mask), place = count;
        struct waiting_child child = {node->child[lane], enter[lane]};
        if (child.child == CHILD_EMPTY)
            continue;
        for (; place > bottom && stack[place - 1].enter < child.enter; place--)
            stack[place] = stack[place - 1];
        stack[place] = child;
        count++;
    }
    return count;
}

/* Whether the BLAS has any primitive that the flags let through. */
static bool kind_is_wanted(const struct structure_header *blas, uint32_t flags)
{
    if (blas->record_count == 0 || structure_is_top(blas->kind))
        return false;
    return !(flags & (blas->kind == STRUCTURE_AABBS ? TRACE_SKIP_AABBS : TRACE_SKIP_TRIANGLES));
}

static void walk_blas(struct walk *walk, struct view *view)
{
    if (!kind_is_wanted(view->blas, walk->ray->flags))
        return;
    const struct wide_node *nodes = structure_nodes(view->blas);
    struct waiting_child stack[TRACE_STACK];
    uint32_t count = 1;
    stack[0] = (struct waiting_child){0, view->ray.slab.t_min};
    while (count > 0 && !walk->is_stopped) {
        struct waiting_child now = stack[--count];
        if (now.enter > view->ray.slab.t_max)
            continue;
        if (now.child & LEAF_BIT) {
            test_leaf(walk, view, now.child);
            continue;
        }
        walk->counters.nodes++;
        count = push_children(&nodes[now.child], &view->ray.slab, stack, count);
    }
}

static void enter_instance(struct walk *walk, const struct instance_record *instance)
{
    const struct builder_resolver *resolver = &walk->scene->resolver;
    struct view view = {.instance = instance};
    if ((instance->instance.mask & walk->ray->cull_mask & 0xff) == 0)
        return;
    view.blas =
        resolver->find(resolver->context, instance->instance.accelerationStructureReference);
    if (!view.blas || !kind_is_wanted(view.blas, walk->ray->flags) ||
        !ray_enter(&view.ray, walk->ray, walk->scene->accuracy, instance))
        return;
    walk->counters.instances++;
    ray_limit(&view.ray, walk->t_max);
    walk_blas(walk, &view);
}

/* As it is at the ray's time. */
static void enter_moving(struct walk *walk, const struct motion_instance_record *record)
{
    struct instance_record now;
    motion_instance_at(record, walk->ray->time, &now);
    enter_instance(walk, &now);
}

static void walk_tlas(struct walk *walk, const struct structure_header *tlas)
{
    struct local_ray world;
    if (!ray_make(&world, walk->ray, walk->scene->accuracy, true))
        return;
    const struct wide_node *nodes = structure_nodes(tlas);
    struct waiting_child stack[TRACE_STACK];
    uint32_t count = tlas->node_count > 0 ? 1 : 0;
    stack[0] = (struct waiting_child){0, world.slab.t_min};
    while (count > 0 && !walk->is_stopped) {
        struct waiting_child now = stack[--count];
        if (now.enter > world.slab.t_max)
            continue;
        if (now.child & LEAF_BIT) {
            const struct instance_record *instance =
                structure_instance(tlas, leaf_first(now.child));
            if (tlas->kind == STRUCTURE_INSTANCES)
                enter_instance(walk, instance);
            else
                enter_moving(walk, (const void *)instance);
            ray_limit(&world, walk->t_max);
            continue;
        }
        walk->counters.nodes++;
        count = push_children(&nodes[now.child], &world.slab, stack, count);
    }
}

void trace_candidates(const struct trace_scene *scene, const struct trace_ray *ray,
                      const struct trace_visitor *visitor)
{
    const struct structure_header *header = scene->structure;
    struct walk walk = {.scene = scene, .ray = ray, .visitor = visitor, .t_max = ray->t_max};
    if (structure_is_top(header->kind)) {
        walk_tlas(&walk, header);
    } else {
        struct view view = {.blas = header};
        if (ray_make(&view.ray, ray, scene->accuracy, false))
            walk_blas(&walk, &view);
    }
    if (scene->counters) {
        scene->counters->nodes += walk.counters.nodes;
        scene->counters->primitives += walk.counters.primitives;
        scene->counters->instances += walk.counters.instances;
        scene->counters->exact_calls += walk.counters.exact_calls;
        scene->counters->micromaps += walk.counters.micromaps;
    }
}

struct closest {
    struct trace_hit *hit;
    bool is_found;
};

static enum trace_answer keep_closest(void *context, struct trace_hit *candidate)
{
    struct closest *closest = context;
    *closest->hit = *candidate;
    closest->is_found = true;
    return TRACE_ACCEPT;
}

bool trace_closest(const struct trace_scene *scene, const struct trace_ray *ray,
                   struct trace_hit *hit)
{
    struct closest closest = {hit, false};
    struct trace_visitor visitor = {keep_closest, &closest};
    trace_candidates(scene, ray, &visitor);
    return closest.is_found;
}
