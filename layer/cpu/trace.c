/* SPDX-License-Identifier: Apache-2.0 */
/* Commands of assay.h on backend cpu: tracing, and counters. */
#include "layer/assay.h"

#include <stddef.h>
#include <string.h>

#include "layer/cpu/overlay.h"
#include "layer/snapshots/snapshots.h"
#include "observers.h"
#include "src/cpu/trees/trees.h"
#include "src/snapshots/memory.h"

_Static_assert((int)ASSAY_ACCURACY_FAST == TRACE_FAST &&
                   (int)ASSAY_ACCURACY_ROBUST == TRACE_ROBUST &&
                   (int)ASSAY_ACCURACY_EXACT == TRACE_EXACT,
               "accuracies");

/* The size of rays before they had a time. */
enum { UNTIMED_RAY_SIZE = offsetof(AssayRay, time) };

static AssayRay ray_at(const AssayTraceInfo *info, uint32_t index)
{
    AssayRay ray = {.time = 0};
    memcpy(&ray, (const char *)info->rays + index * info->raySize, info->raySize);
    return ray;
}

static struct trace_ray ray_of(const AssayRay *from)
{
    struct trace_ray ray = {.t_min = from->tMin,
                            .t_max = from->tMax,
                            .flags = from->flags,
                            .cull_mask = from->cullMask,
                            .time = from->time};
    memcpy(ray.origin, from->origin, sizeof(ray.origin));
    memcpy(ray.direction, from->direction, sizeof(ray.direction));
    return ray;
}

static AssayHit hit_of(const struct trace_hit *from)
{
    return (AssayHit){
        .isHit = VK_TRUE,
        .t = from->t,
        .u = from->u,
        .v = from->v,
        .geometry = from->geometry,
        .primitive = from->primitive,
        .instance = from->instance,
        .customIndex = from->custom_index,
        .sbtOffset = from->sbt_offset,
        .isAabb = from->is_aabb,
        .isFrontFacing = from->front_face,
        .isOpaque = from->opaque,
    };
}

/* One ray whose candidates are passed to the application's function. */
struct candidate_filter {
    const AssayTraceInfo *info;
    uint32_t index; /* of the ray */
    AssayRay ray;
    AssayHit nearest;
};

static enum trace_answer filter_candidate(void *context, struct trace_hit *candidate)
{
    struct candidate_filter *filter = context;
    const AssayTraceInfo *info = filter->info;
    const AssayRay *ray = &filter->ray;
    AssayHit hit = hit_of(candidate);
    AssayAnswer answer = info->candidate(info->userData, filter->index, &hit);
    if (answer == ASSAY_ANSWER_STOP)
        return TRACE_STOP;
    float limit = filter->nearest.isHit ? filter->nearest.t : ray->tMax;
    if (answer != ASSAY_ANSWER_ACCEPT || !(hit.t >= ray->tMin && hit.t <= limit))
        return TRACE_IGNORE;
    if (candidate->is_aabb)
        candidate->t = hit.t;
    filter->nearest = hit_of(candidate);
    return TRACE_ACCEPT;
}

static AssayHit trace_ray(struct cpu_scene *scene, const AssayTraceInfo *info, uint32_t index)
{
    const AssayRay given = ray_at(info, index);
    const struct trace_ray ray = ray_of(&given);
    struct trace_hit hit;
    scene->rays++;
    if (!info->candidate)
        return trace_closest(&scene->traced, &ray, &hit) ? hit_of(&hit)
                                                         : (AssayHit){.isHit = VK_FALSE};
    struct candidate_filter filter = {.info = info, .index = index, .ray = given};
    const struct trace_visitor visitor = {filter_candidate, &filter};
    trace_candidates(&scene->traced, &ray, &visitor);
    return filter.nearest;
}

static bool is_ray_size(size_t size)
{
    return size == sizeof(AssayRay) || size == UNTIMED_RAY_SIZE;
}

VKAPI_ATTR VkResult VKAPI_CALL cpu_TraceRaysASSAY(VkDevice device, const AssayTraceInfo *info)
{
    struct readable_cache cache = {0};
    if (!readable(&cache, info, sizeof(*info)) || !is_ray_size(info->raySize) ||
        info->hitSize != sizeof(AssayHit) || (uint32_t)info->accuracy > ASSAY_ACCURACY_EXACT ||
        !readable(&cache, info->rays, info->rayCount * info->raySize) ||
        !memory_is_writable(info->hits, info->rayCount * sizeof(AssayHit)))
        return VK_ERROR_VALIDATION_FAILED;
    const struct layer_device *state = layer_find_device(device);
    struct cpu_scene scene;
    VkResult result = cpu_scene_open(state->cpu->device, info->accelerationStructure,
                                     (enum trace_accuracy)info->accuracy, &scene);
    if (result != VK_SUCCESS) {
        cpu_overlay_warn_of_occurrences(state);
        return result;
    }
    for (uint32_t i = 0; i < info->rayCount && !scene.micromaps.out_of_memory; i++)
        info->hits[i] = trace_ray(&scene, info, i);
    result = scene.micromaps.out_of_memory ? VK_ERROR_OUT_OF_HOST_MEMORY : VK_SUCCESS;
    cpu_scene_close(&scene);
    cpu_overlay_warn_of_occurrences(state);
    return result;
}

VKAPI_ATTR void VKAPI_CALL cpu_GetCountersASSAY(VkDevice device, size_t size,
                                                AssayCounters *counters)
{
    const struct layer_device *state = layer_find_device(device);
    struct cpu_counters *from = &state->cpu->device->counters;
    AssayCounters now = {.bytesSnapshot = atomic_load(&state->snapshots->bytes_copied)};
#define COUNTER(name, public) now.public = atomic_load_explicit(&from->name, memory_order_relaxed);
    CPU_COUNTERS(COUNTER)
#undef COUNTER
    memset(counters, 0, size);
    memcpy(counters, &now, size < sizeof(now) ? size : sizeof(now));
}
