/* SPDX-License-Identifier: Apache-2.0 */
/* Commands of backend cpu that are the layer's own (assay.h): tracing, and counters. */
#include "assay.h"

#include <string.h>

#include "cpu/commands.h"
#include "cpu/memory.h"
#include "cpu/overlay.h"
#include "cpu/scene.h"

_Static_assert((int)ASSAY_ACCURACY_FAST == TRACE_FAST &&
                   (int)ASSAY_ACCURACY_ROBUST == TRACE_ROBUST &&
                   (int)ASSAY_ACCURACY_EXACT == TRACE_EXACT,
               "accuracies");

static AssayHit trace_ray(struct cpu_scene *scene, const AssayRay *ray)
{
    struct trace_ray from = {
        .t_min = ray->tMin, .t_max = ray->tMax, .flags = ray->flags, .cull_mask = ray->cullMask};
    memcpy(from.origin, ray->origin, sizeof(from.origin));
    memcpy(from.direction, ray->direction, sizeof(from.direction));
    struct trace_hit hit;
    scene->rays++;
    if (!trace_closest(&scene->traced, &from, &hit))
        return (AssayHit){.isHit = VK_FALSE};
    return (AssayHit){
        .isHit = VK_TRUE,
        .t = hit.t,
        .u = hit.u,
        .v = hit.v,
        .geometry = hit.geometry,
        .primitive = hit.primitive,
        .instance = hit.instance,
        .customIndex = hit.custom_index,
        .sbtOffset = hit.sbt_offset,
        .isAabb = hit.is_aabb,
        .isFrontFacing = hit.front_face,
        .isOpaque = hit.opaque,
    };
}

VKAPI_ATTR VkResult VKAPI_CALL cpu_TraceRaysASSAY(VkDevice device, const AssayTraceInfo *info)
{
    struct readable_cache cache = {0};
    if (!readable(&cache, info, sizeof(*info)) || info->raySize != sizeof(AssayRay) ||
        info->hitSize != sizeof(AssayHit) || (uint32_t)info->accuracy > ASSAY_ACCURACY_EXACT ||
        !readable(&cache, info->rays, info->rayCount * sizeof(AssayRay)) ||
        !cpu_is_writable(info->hits, info->rayCount * sizeof(AssayHit)))
        return VK_ERROR_VALIDATION_FAILED;
    struct cpu_scene scene;
    VkResult result = cpu_scene_open(cpu_overlay_of(device)->device, info->accelerationStructure,
                                     (enum trace_accuracy)info->accuracy, &scene);
    if (result != VK_SUCCESS)
        return result;
    for (uint32_t i = 0; i < info->rayCount; i++)
        info->hits[i] = trace_ray(&scene, &info->rays[i]);
    cpu_scene_close(&scene);
    return VK_SUCCESS;
}

VKAPI_ATTR void VKAPI_CALL cpu_GetCountersASSAY(VkDevice device, size_t size,
                                                AssayCounters *counters)
{
    struct cpu_counters *from = &cpu_overlay_of(device)->device->counters;
    AssayCounters now = {0};
#define COUNTER(name, public) now.public = atomic_load_explicit(&from->name, memory_order_relaxed);
    CPU_COUNTERS(COUNTER)
#undef COUNTER
    memset(counters, 0, size);
    memcpy(counters, &now, size < sizeof(now) ? size : sizeof(now));
}
