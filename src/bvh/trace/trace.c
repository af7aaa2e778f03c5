/* SPDX-License-Identifier: Apache-2.0 */
/* The entry points of traversal. */
#include "src/bvh/trace.h"

#include "src/bvh/trace/ray.h"

/* Returns the traversal for the best instruction set that the processor has and the scene allows.
 */
static scene_walker *find_walker(enum trace_vectors limit)
{
    if (limit == TRACE_VECTORS_PLAIN)
        return walk_plain;
#ifdef BVH_HAS_AVX
    if (limit == TRACE_VECTORS_BEST && __builtin_cpu_supports("avx512vl") &&
        __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("bmi2"))
        return walk_avx512;
    if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("bmi2"))
        return walk_avx2;
#endif
    return walk_plain;
}

void trace_candidates(const struct trace_scene *scene, const struct trace_ray *ray,
                      const struct trace_visitor *visitor)
{
    struct walk walk = {.scene = scene, .ray = ray, .visitor = visitor, .t_max = ray->t_max};
    find_walker(scene->vectors)(&walk);
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
