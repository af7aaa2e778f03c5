/* SPDX-License-Identifier: Apache-2.0 */
/* Traverses trees without recursion: one stack of fixed size for a BLAS, another for the TLAS above
 * it, both sized for the maximum depth (structure.h). "Ray Intersection Candidate Determination"
 * and "Ray Intersection Culling" define the candidates.
 *
 * This file is compiled once for each instruction set, with WALK_SCENE as the name of its only
 * external function. All of them do the same operations in the same order, so the hits are the
 * same. */
#include "src/bvh/input/displaced.h"
#include "src/bvh/motion.h"
#include "src/bvh/trace/four.h"
#include "src/bvh/trace/prepare.h"

static bool geometry_is_opaque(const struct view *view, uint32_t geometry)
{
    return structure_geometries(view->blas)[geometry].flags & VK_GEOMETRY_OPAQUE_BIT_KHR;
}

/* Finds the triangles among up to four that the ray may hit. */
static ALWAYS_INLINE void find_hits(const struct walk *walk, struct view *view,
                                    const void *triangles, uint64_t size, uint32_t count)
{
    struct four_triangles four;
    view->lane = 0;
    view->hits.found = 15;
    if (walk->scene->accuracy == TRACE_FAST)
        return;
    load_triangles(triangles, size, count, &four);
    if (walk->scene->accuracy == TRACE_ROBUST)
        four_robust(&view->ray, &four, &view->hits);
    else
        four_exact(&view->ray, &four, &view->hits);
}

/* A hit of the same leaf may have made the ray shorter. */
static ALWAYS_INLINE bool hits_triangle(struct walk *walk, const struct view *view,
                                        const struct triangle_record *triangle,
                                        struct local_hit *local)
{
    const struct four_hits *hits = &view->hits;
    uint32_t lane = view->lane;
    double t_max = walk->t_max * view->ray.unit;
    if (walk->scene->accuracy == TRACE_FAST)
        return triangle_fast(&view->ray, triangle, t_max, local);
    if (walk->scene->accuracy == TRACE_EXACT)
        return triangle_exact(&view->ray, triangle, &hits->edges[lane], t_max, local,
                              &walk->counters.exact_calls);
    if (hits->open >> lane & 1)
        return triangle_robust(&view->ray, triangle, t_max, local);
    *local = (struct local_hit){hits->t[lane] / SLAB_UNITS, hits->u[lane], hits->v[lane],
                                hits->front >> lane & 1};
    return hits->t[lane] < view->ray.slab.t_max;
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
        candidate_visit(walk, view, hit, local->t);
}

static ALWAYS_INLINE void visit_triangle(struct walk *walk, struct view *view,
                                         const struct triangle_record *triangle,
                                         struct trace_hit *hit)
{
    struct local_hit local;
    if (hits_triangle(walk, view, triangle, &local))
        visit_hit(walk, view, triangle, &local, hit);
}

static ALWAYS_INLINE void test_triangle(struct walk *walk, struct view *view,
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
    candidate_visit(walk, view, &hit, t);
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
    candidate_visit(walk, view, &hit, local.t);
}

static void test_motion_triangle(struct walk *walk, struct view *view,
                                 const struct motion_triangle_record *record)
{
    struct triangle_record now;
    motion_triangle_at(record, walk->ray->time, &now);
    find_hits(walk, view, &now, 0, 1);
    if (view->hits.found != 0)
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
    find_hits(walk, view, &now, 0, 1);
    if (view->hits.found != 0)
        test_displaced(walk, view, &now, record->part);
}

/* Not inline, because plain triangles are by far the most frequent kind. */
static __attribute__((noinline)) void test_record(struct walk *walk, struct view *view,
                                                  const void *record)
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

/* What is walked: the nodes, the records of the leaves, and the ray. */
struct tree {
    const struct structure_header *header;
    const struct wide_node *nodes;
    const uint8_t *records;
    uint64_t record_size;
    const struct slab *slab;
};

static struct tree open_tree(const struct structure_header *header, const struct slab *slab)
{
    return (struct tree){header, structure_nodes(header), structure_records(header),
                         structure_record_size(header->kind), slab};
}

static void test_leaf(struct walk *walk, struct view *view, const struct tree *tree, uint32_t child)
{
    enum structure_kind kind = view->blas->kind;
    uint32_t count = leaf_count(child);
    const uint8_t *records = tree->records + leaf_first(child) * tree->record_size;
    unsigned left = (1u << count) - 1;
    walk->counters.primitives += count;
    if (structure_has_fours(kind)) {
        find_hits(walk, view, records, tree->record_size, count);
        left &= view->hits.found;
    }
    for (; left != 0 && !walk->is_stopped; left &= left - 1) {
        view->lane = (uint32_t)__builtin_ctz(left);
        const void *record = records + view->lane * tree->record_size;
        if (kind == STRUCTURE_TRIANGLES)
            test_triangle(walk, view, record);
        else
            test_record(walk, view, record);
    }
}

/* ---- Nodes. Boxes are tested in vectors of LANES floats. */

#ifdef __AVX2__
#define LANES 8
#define LANE_NUMBERS 0, 1, 2, 3, 4, 5, 6, 7
typedef float float_lanes __attribute__((vector_size(32)));
typedef int32_t int_lanes __attribute__((vector_size(32)));
#define lanes_min _mm256_min_ps
#define lanes_max _mm256_max_ps
#else
#define LANES 4
#define LANE_NUMBERS 0, 1, 2, 3
typedef float4 float_lanes;
typedef int4 int_lanes;
#define lanes_min float4_min
#define lanes_max float4_max
#endif

/* Children that wait, the nearest last. A key is the distance at which the ray enters the box, as
 * bits, which compare like the distance; the lowest bits are the child's lane. */
#define LANE_BITS 7
#define STACK_BOTTOM 2u /* next_child() looks at the two children below */
struct waiting {
    int32_t key[STACK_BOTTOM + TRACE_STACK + NODE_WIDTH];
    uint32_t child[STACK_BOTTOM + TRACE_STACK + NODE_WIDTH];
};

/* Returns the count, which the walk keeps in a variable: memory would be slower. */
static ALWAYS_INLINE uint32_t clear_waiting(struct waiting *waiting)
{
    waiting->child[0] = waiting->child[1] = 0;
    return STACK_BOTTOM;
}

/* Returns the keys of LANES children from `lane` on, and -1 for boxes that the ray misses and for
 * empty children. If a ray lies in a plane, 0 times infinity gives NaN; the minimum and maximum
 * then are those of other planes, which may make the interval longer. */
static ALWAYS_INLINE void test_boxes(const struct slab *slab, const struct wide_node *node,
                                     uint32_t lane, int_lanes *keys)
{
    const float *planes = &node->lower[0][lane];
    const float_lanes zero = {0};
    float_lanes near[3], far[3];
    for (int axis = 0; axis < 3; axis++) {
        memcpy(&near[axis], planes + slab->near_plane[axis], sizeof(near[0]));
        memcpy(&far[axis], planes + slab->far_plane[axis], sizeof(far[0]));
        near[axis] = (near[axis] - slab->near_origin[axis]) * slab->near_scale[axis];
        far[axis] = (far[axis] - slab->far_origin[axis]) * slab->far_scale[axis];
    }
    float_lanes enter =
        lanes_max(lanes_max(near[0], near[1]), lanes_max(near[2], slab->t_min - zero));
    float_lanes leave = lanes_min(lanes_min(far[0], far[1]), lanes_min(far[2], slab->t_max - zero));
    const int_lanes numbers = (int_lanes){LANE_NUMBERS} + (int32_t)lane;
    int_lanes children;
    memcpy(&children, &node->child[lane], sizeof(children));
    *keys = ((int_lanes)enter & ~LANE_BITS) | (numbers | (children == (int32_t)CHILD_EMPTY)) |
            ~(enter <= leave);
}

/* The latency of memory is most of the time of a ray in a large structure. Does not branch: whether
 * a child is a leaf cannot be predicted. */
static ALWAYS_INLINE void prefetch_child(const struct tree *tree, uint32_t child)
{
    uint64_t node = tree->header->nodes + child * sizeof(struct wide_node);
    uint64_t leaf = tree->header->records + leaf_first(child) * tree->record_size;
    uint64_t is_leaf = -(uint64_t)(child >> 31);
    const uint8_t *at = (const uint8_t *)tree->header + (node ^ ((node ^ leaf) & is_leaf));
    for (uint32_t line = 0; line < sizeof(struct wide_node); line += 64)
        __builtin_prefetch(at + line);
}

/* Takes the nearest child from the stack. Returns false if no child is near enough. */
static ALWAYS_INLINE bool take_child(const struct waiting *waiting, uint32_t *count,
                                     const struct slab *slab, uint32_t *child)
{
    int32_t limit = (int32_t)float_bits(slab->t_max) | LANE_BITS;
    while (*count > STACK_BOTTOM && waiting->key[*count - 1] > limit)
        --*count;
    if (*count == STACK_BOTTOM)
        return false;
    *child = waiting->child[--*count];
    return true;
}

#ifdef __AVX2__
/* A step of a bitonic sorting network, in descending order: p are the lanes to compare with, k
 * selects the greater (8 + i) or the lesser key (i). */
#define SORT_STEP(keys, p0, p1, p2, p3, p4, p5, p6, p7, k0, k1, k2, k3, k4, k5, k6, k7)            \
    do {                                                                                           \
        const int_lanes others =                                                                   \
            __builtin_shufflevector(keys, keys, p0, p1, p2, p3, p4, p5, p6, p7);                   \
        const __m256i lesser = _mm256_min_epi32((__m256i)(keys), (__m256i)others);                 \
        const __m256i greater = _mm256_max_epi32((__m256i)(keys), (__m256i)others);                \
        (keys) = __builtin_shufflevector((int_lanes)lesser, (int_lanes)greater, k0, k1, k2, k3,    \
                                         k4, k5, k6, k7);                                          \
    } while (0)

/* Sorts the hit children onto the stack and returns how many they are. Does not branch: how many
 * children a ray hits, and in which order, cannot be predicted. */
static ALWAYS_INLINE uint32_t push_children(const struct wide_node *node, int_lanes keys,
                                            struct waiting *waiting, uint32_t count)
{
    int_lanes children;
    uint32_t missed = (uint32_t)__builtin_popcount((unsigned)_mm256_movemask_ps((__m256)keys));
    SORT_STEP(keys, 1, 0, 3, 2, 5, 4, 7, 6, 8, 1, 10, 3, 12, 5, 14, 7);
    SORT_STEP(keys, 3, 2, 1, 0, 7, 6, 5, 4, 8, 9, 2, 3, 12, 13, 6, 7);
    SORT_STEP(keys, 1, 0, 3, 2, 5, 4, 7, 6, 8, 1, 10, 3, 12, 5, 14, 7);
    SORT_STEP(keys, 7, 6, 5, 4, 3, 2, 1, 0, 8, 9, 10, 11, 4, 5, 6, 7);
    SORT_STEP(keys, 2, 3, 0, 1, 6, 7, 4, 5, 8, 9, 2, 3, 12, 13, 6, 7);
    SORT_STEP(keys, 1, 0, 3, 2, 5, 4, 7, 6, 8, 1, 10, 3, 12, 5, 14, 7);
    memcpy(&children, node->child, sizeof(children));
    children = (int_lanes)_mm256_permutevar8x32_epi32((__m256i)children, (__m256i)keys);
    memcpy(waiting->key + count, &keys, sizeof(keys));
    memcpy(waiting->child + count, &children, sizeof(children));
    return NODE_WIDTH - missed;
}

/* The sorted children are known later than the nearest one. */
static ALWAYS_INLINE uint32_t nearest_child(const struct wide_node *node, int_lanes keys)
{
    const __m256i all = (__m256i)keys;
    __m256i children;
    __m128i least = _mm_min_epu32(_mm256_castsi256_si128(all), _mm256_extracti128_si256(all, 1));
    least = _mm_min_epu32(least, _mm_shuffle_epi32(least, 0x4e));
    least = _mm_min_epu32(least, _mm_shuffle_epi32(least, 0xb1));
    memcpy(&children, node->child, sizeof(children));
    children = _mm256_permutevar8x32_epi32(children, _mm256_castsi128_si256(least));
    return (uint32_t)_mm_cvtsi128_si32(_mm256_castsi256_si128(children));
}

/* Goes from a node to the nearest child that the ray may hit; the others wait. Returns false if
 * there is no child to go to. */
static ALWAYS_INLINE bool next_child(const struct tree *tree, struct waiting *waiting,
                                     uint32_t *count, uint32_t *child)
{
    const struct wide_node *node = &tree->nodes[*child];
    int_lanes keys;
    test_boxes(tree->slab, node, 0, &keys);
    uint32_t hits = push_children(node, keys, waiting, *count);
    prefetch_child(tree, waiting->child[*count + hits - 2]);
    if (hits == 0)
        return take_child(waiting, count, tree->slab, child);
    *child = nearest_child(node, keys);
    *count += hits - 1;
    return true;
}
#else
static ALWAYS_INLINE bool next_child(const struct tree *tree, struct waiting *waiting,
                                     uint32_t *count, uint32_t *child)
{
    const struct wide_node *node = &tree->nodes[*child];
    int32_t keys[NODE_WIDTH];
    uint32_t bottom = *count;
    for (uint32_t lane = 0; lane < NODE_WIDTH; lane += LANES) {
        int_lanes some;
        test_boxes(tree->slab, node, lane, &some);
        memcpy(keys + lane, &some, sizeof(some));
    }
    for (uint32_t lane = 0; lane < NODE_WIDTH; lane++) {
        uint32_t place = *count;
        if (keys[lane] < 0)
            continue;
        for (; place > bottom && waiting->key[place - 1] < keys[lane]; place--) {
            waiting->key[place] = waiting->key[place - 1];
            waiting->child[place] = waiting->child[place - 1];
        }
        waiting->key[place] = keys[lane];
        waiting->child[place] = node->child[lane];
        ++*count;
    }
    prefetch_child(tree, waiting->child[*count - 2]);
    return take_child(waiting, count, tree->slab, child);
}
#endif

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
    const struct tree tree = open_tree(view->blas, &view->ray.slab);
    struct waiting waiting;
    uint32_t child = 0, count = clear_waiting(&waiting);
    for (bool has_child = true; has_child;) {
        if (child & LEAF_BIT) {
            test_leaf(walk, view, &tree, child);
            has_child = !walk->is_stopped && take_child(&waiting, &count, tree.slab, &child);
        } else {
            walk->counters.nodes++;
            has_child = next_child(&tree, &waiting, &count, &child);
        }
    }
}

static void enter_instance(struct walk *walk, const struct instance_record *instance)
{
    const struct builder_resolver *resolver = &walk->scene->resolver;
    struct view view;
    if ((instance->instance.mask & walk->ray->cull_mask & 0xff) == 0)
        return;
    view.instance = instance;
    view.blas =
        resolver->find(resolver->context, instance->instance.accelerationStructureReference);
    if (!view.blas || !kind_is_visible(view.blas, walk->ray->flags) ||
        !ray_enter(&view.ray, walk->ray, walk->scene->accuracy, instance))
        return;
    walk->counters.instances++;
    ray_limit(&view.ray, walk->t_max * view.ray.unit);
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
    const struct tree tree = open_tree(tlas, &world.slab);
    struct waiting waiting;
    uint32_t child = 0, count = clear_waiting(&waiting);
    for (bool has_child = tlas->node_count > 0; has_child;) {
        if (child & LEAF_BIT) {
            const struct instance_record *instance = structure_instance(tlas, leaf_first(child));
            if (tlas->kind == STRUCTURE_INSTANCES)
                enter_instance(walk, instance);
            else
                enter_moving(walk, (const void *)instance);
            ray_limit(&world, walk->t_max * world.unit);
            has_child = !walk->is_stopped && take_child(&waiting, &count, tree.slab, &child);
        } else {
            walk->counters.nodes++;
            has_child = next_child(&tree, &waiting, &count, &child);
        }
    }
}

void WALK_SCENE(struct walk *walk)
{
    const struct structure_header *header = walk->scene->structure;
    struct view view;
    view.blas = header;
    view.instance = NULL;
    if (structure_is_top(header->kind))
        walk_tlas(walk, header);
    else if (ray_make(&view.ray, walk->ray, walk->scene->accuracy, false))
        walk_blas(walk, &view);
}
