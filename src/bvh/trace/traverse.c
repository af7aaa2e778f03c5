/* SPDX-License-Identifier: Apache-2.0 */
/* Traverses trees without recursion: one stack of fixed size for a BLAS, another for the TLAS above
 * it, both sized for the maximum depth (structure.h). "Ray Intersection Candidate Determination"
 * and "Ray Intersection Culling" define the candidates. */
#include "src/bvh/input/displaced.h"
#include "src/bvh/motion.h"
#include "src/bvh/trace/ray.h"

struct waiting_child {
    uint32_t child;
    float enter;
};

static bool geometry_is_opaque(const struct view *view, uint32_t geometry)
{
    return structure_geometries(view->blas)[geometry].flags & VK_GEOMETRY_OPAQUE_BIT_KHR;
}

static bool hits_triangle(struct walk *walk, const struct view *view,
                          const struct triangle_record *triangle, struct local_hit *local)
{
    double t_max = walk->t_max * view->ray.unit;
    switch (walk->scene->accuracy) {
    case TRACE_FAST:
        return triangle_fast(&view->ray, triangle, t_max, local);
    case TRACE_ROBUST:
        return triangle_robust(&view->ray, triangle, t_max, local);
    case TRACE_EXACT:
        return triangle_exact(&view->ray, triangle, t_max, local, &walk->counters.exact_calls);
    }
    return false;
}

/* `hit` has the numbers and the opacity before micromaps. */
static ALWAYS_INLINE void visit_hit(struct walk *walk, struct view *view,
                                    const struct triangle_record *triangle,
                                    const struct local_hit *local, struct trace_hit *hit)
{
    hit->u = local->u;
    hit->v = local->v;
    hit->front_face = local->front_face;
    if (triangle->opacity == 0 || candidate_opacity(walk, view, triangle, local, &hit->opaque))
        candidate_visit(walk, view, hit, local->t / view->ray.unit);
}

static void visit_triangle(struct walk *walk, struct view *view,
                           const struct triangle_record *triangle, struct trace_hit *hit)
{
    struct local_hit local;
    if (hits_triangle(walk, view, triangle, &local))
        visit_hit(walk, view, triangle, &local, hit);
}

static void test_triangle(struct walk *walk, struct view *view,
                          const struct triangle_record *triangle)
{
    struct trace_hit hit = {.geometry = triangle->geometry,
                            .primitive = triangle->primitive,
                            .opaque = geometry_is_opaque(view, triangle->geometry)};
    visit_triangle(walk, view, triangle, &hit);
}

static void test_dense(struct walk *walk, struct view *view, const struct dense_record *record)
{
    struct trace_hit hit = {.geometry = record->geometry,
                            .primitive = record->primitive,
                            .opaque = record->is_opaque != 0};
    visit_triangle(walk, view, &record->triangle, &hit);
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
    candidate_visit(walk, view, &hit, t / view->ray.unit);
}

static void test_sphere(struct walk *walk, struct view *view, const void *record)
{
    bool is_swept = view->blas->kind == STRUCTURE_SWEPT_SPHERES;
    bool is_exact = walk->scene->accuracy == TRACE_EXACT;
    double t_max = walk->t_max * view->ray.unit;
    /* A swept_record stores its numbers at the same offset. */
    const struct sphere_record *sphere = record;
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
    candidate_visit(walk, view, &hit, local.t / view->ray.unit);
}

static void test_motion_triangle(struct walk *walk, struct view *view,
                                 const struct motion_triangle_record *record)
{
    struct triangle_record now;
    motion_triangle_at(record, walk->ray->time, &now);
    test_triangle(walk, view, &now);
}

/* All properties but the position are those of the base triangle. */
static void test_displaced(struct walk *walk, struct view *view,
                           const struct triangle_record *triangle, struct displaced_part part)
{
    struct local_hit local;
    if (!hits_triangle(walk, view, triangle, &local))
        return;
    struct trace_hit hit = {.geometry = triangle->geometry,
                            .primitive = triangle->primitive,
                            .opaque = geometry_is_opaque(view, triangle->geometry)};
    displaced_barycentrics(part, &local.u, &local.v);
    visit_hit(walk, view, triangle, &local, &hit);
}

static void test_motion_displaced(struct walk *walk, struct view *view,
                                  const struct motion_displaced_record *record)
{
    struct triangle_record now;
    motion_triangle_at(&record->triangle, walk->ray->time, &now);
    test_displaced(walk, view, &now, record->part);
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
    case STRUCTURE_DENSE:
        test_dense(walk, view, record);
        return;
    case STRUCTURE_DISPLACED:
        test_displaced(walk, view, record, ((const struct displaced_record *)record)->part);
        return;
    case STRUCTURE_MOTION_DISPLACED:
        test_motion_displaced(walk, view, record);
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

/* Pushes the children that the ray may hit onto the stack, the nearest on top. */
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

/* Returns whether the BLAS has any primitive that the flags do not skip. */
static bool kind_is_visible(const struct structure_header *blas, uint32_t flags)
{
    if (blas->record_count == 0 || structure_is_top(blas->kind))
        return false;
    return !(flags & (blas->kind == STRUCTURE_AABBS ? TRACE_SKIP_AABBS : TRACE_SKIP_TRIANGLES));
}

static void walk_blas(struct walk *walk, struct view *view)
{
    if (!kind_is_visible(view->blas, walk->ray->flags))
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
    if (!view.blas || !kind_is_visible(view.blas, walk->ray->flags) ||
        !ray_enter(&view.ray, walk->ray, walk->scene->accuracy, instance))
        return;
    walk->counters.instances++;
    ray_limit(&view.ray, walk->t_max);
    walk_blas(walk, &view);
}

/* Enters a moving instance at the ray's time. */
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
