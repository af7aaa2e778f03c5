/* SPDX-License-Identifier: Apache-2.0 */
/* Follows all paths of a few rows at once, because a call that traces many rays costs least. */

#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "shade.h"
#include "tests/fixture/trace.h"

#define ROWS 4 /* of a batch */
#define BOUNCES 2
#define THREADS_MAX 16
#define RAY_TERMINATE 0x4

struct path {
    vec3 origin, direction, sum;
    struct surface hit;
    struct light light;
    float weight; /* 0: at its end */
    uint32_t pixel, sample;
};

struct batch {
    struct trace *trace;
    struct path *paths;
    uint32_t path_count;
    AssayRay *rays;
    AssayHit *hits;
    uint32_t *owners; /* whose path a ray is */
    uint32_t ray_count;
};

struct trace {
    struct gpu *gpu;
    PFN_vkTraceRaysASSAY trace_rays;
    VkAccelerationStructureKHR top;
    struct shade_scene shading;
    uint32_t width, height;
    uint32_t *pixels;
    atomic_uint next_row;
};

/* ---- rays */

static vec3 load(const float from[3])
{
    return (vec3){from[0], from[1], from[2], 0};
}

static void add_ray(struct batch *batch, uint32_t path, vec3 origin, vec3 direction, float limit,
                    uint32_t flags)
{
    batch->owners[batch->ray_count] = path;
    batch->rays[batch->ray_count++] = (AssayRay){
        .origin = {origin[0], origin[1], origin[2]},
        .direction = {direction[0], direction[1], direction[2]},
        .tMax = limit,
        .flags = flags,
        .cullMask = 0xff,
    };
}

/* What the boxes hold is met, or not. */
static AssayAnswer answer(void *data, uint32_t ray, AssayHit *candidate)
{
    const struct batch *batch = data;
    const struct shade_scene *shading = &batch->trace->shading;
    if (!candidate->isAabb)
        return ASSAY_ANSWER_ACCEPT;
    const AssayRay *from = &batch->rays[ray];
    candidate->t =
        shade_box(shading, candidate->primitive,
                  shade_to_object(shading, candidate->instance, load(from->origin), true),
                  shade_to_object(shading, candidate->instance, load(from->direction), false));
    return candidate->t > 0 ? ASSAY_ANSWER_ACCEPT : ASSAY_ANSWER_IGNORE;
}

static void trace_rays(struct batch *batch)
{
    const struct trace *trace = batch->trace;
    AssayTraceInfo info = trace_info((uint64_t)trace->top, ASSAY_ACCURACY_EXACT, batch->ray_count,
                                     batch->rays, batch->hits);
    info.candidate = answer;
    info.userData = batch;
    tool_check(trace->trace_rays(trace->gpu->device, &info), "vkTraceRaysASSAY");
}

/* ---- a bounce of all paths */

static void look(struct batch *batch)
{
    batch->ray_count = 0;
    for (uint32_t i = 0; i < batch->path_count; ++i)
        if (batch->paths[i].weight > 0)
            add_ray(batch, i, batch->paths[i].origin, batch->paths[i].direction, FAR, 0);
    trace_rays(batch);
    for (uint32_t i = 0; i < batch->ray_count; ++i) {
        struct path *path = &batch->paths[batch->owners[i]];
        const AssayHit *hit = &batch->hits[i];
        const struct shade_meeting meeting = {
            path->origin, path->direction, hit->instance, hit->primitive, hit->t, hit->u, hit->v};
        path->hit.t = -1;
        if (hit->isHit)
            path->hit = (hit->isAabb ? shade_field : shade_mesh)(&batch->trace->shading, &meeting);
        shade_plain(path->origin, path->direction, &path->hit);
        if (path->hit.t < 0) {
            path->sum += path->weight * sky(path->direction);
            path->weight = 0;
        }
    }
}

static vec3 above(const struct path *path)
{
    return path->origin + path->hit.t * path->direction + path->hit.normal * 2e-3f;
}

static void look_for_light(struct batch *batch, uint32_t bounce)
{
    batch->ray_count = 0;
    for (uint32_t i = 0; i < batch->path_count; ++i) {
        struct path *path = &batch->paths[i];
        if (path->weight == 0)
            continue;
        struct light *light = &path->light;
        vec3 sunwards = to_sun(chance(path->pixel, 2 * bounce, path->sample));
        light->around =
            cosine_direction(path->hit.normal, chance(path->pixel, 2 * bounce + 1, path->sample));
        light->facing = fmaxf(dot(path->hit.normal, sunwards), 0);
        light->in_sun = light->facing > 0;
        light->in_open = true;
        if (light->in_sun)
            add_ray(batch, i, above(path), sunwards, FAR, RAY_TERMINATE);
        if (light->around[1] >= 0)
            add_ray(batch, i, above(path), light->around, REACH, RAY_TERMINATE);
    }
    trace_rays(batch);
    for (uint32_t i = 0; i < batch->ray_count; ++i) {
        struct light *light = &batch->paths[batch->owners[i]].light;
        if (batch->hits[i].isHit)
            *(batch->rays[i].tMax == FAR ? &light->in_sun : &light->in_open) = false;
    }
}

static void shade(struct batch *batch, uint32_t bounce)
{
    for (uint32_t i = 0; i < batch->path_count; ++i) {
        struct path *path = &batch->paths[i];
        if (path->weight == 0)
            continue;
        float mirror = bounce + 1 < BOUNCES ? mirror_share(path->hit, path->direction) : 0;
        path->sum += path->weight * (1 - mirror) * lit(path->hit, path->direction, path->light);
        path->weight *= mirror;
        if (path->weight < 0.01f)
            path->weight = 0;
        path->origin = above(path);
        path->direction -= 2 * dot(path->hit.normal, path->direction) * path->hit.normal;
    }
}

/* ---- the picture */

static void start_paths(struct batch *batch, uint32_t first_row)
{
    const struct trace *trace = batch->trace;
    batch->path_count = 0;
    for (uint32_t y = first_row; y < first_row + ROWS && y < trace->height; ++y)
        for (uint32_t x = 0; x < trace->width; ++x)
            for (uint32_t i = 0; i < RENDER_GRID * RENDER_GRID; ++i) {
                const uint32_t column = i % RENDER_GRID, row = i / RENDER_GRID;
                const float within_x = ((float)column + 0.5f) / RENDER_GRID;
                const float within_y = ((float)row + 0.5f) / RENDER_GRID;
                batch->paths[batch->path_count++] = (struct path){
                    .origin = CAMERA,
                    .direction = camera_ray((float)x + within_x, (float)y + within_y, trace->width,
                                            trace->height),
                    .weight = 1,
                    .pixel = y * trace->width + x,
                    .sample = i,
                };
            }
}

static void draw_rows(struct batch *batch, uint32_t first_row)
{
    start_paths(batch, first_row);
    for (uint32_t bounce = 0; bounce < BOUNCES; ++bounce) {
        look(batch);
        look_for_light(batch, bounce);
        shade(batch, bounce);
    }
    const uint32_t samples = RENDER_GRID * RENDER_GRID;
    for (uint32_t i = 0; i < batch->path_count; i += samples) {
        vec3 sum = {0};
        for (uint32_t j = 0; j < samples; ++j)
            sum += batch->paths[i + j].sum;
        batch->trace->pixels[batch->paths[i].pixel] = shade_encode(sum / (float)samples);
    }
}

static void *draw(void *data)
{
    struct trace *trace = data;
    const size_t paths = (size_t)ROWS * trace->width * RENDER_GRID * RENDER_GRID;
    struct batch batch = {
        .trace = trace,
        .paths = tool_alloc(paths, sizeof(struct path)),
        .rays = tool_alloc(2 * paths, sizeof(AssayRay)),
        .hits = tool_alloc(2 * paths, sizeof(AssayHit)),
        .owners = tool_alloc(2 * paths, sizeof(uint32_t)),
    };
    for (uint32_t row; (row = atomic_fetch_add(&trace->next_row, ROWS)) < trace->height;)
        draw_rows(&batch, row);
    free(batch.paths);
    free(batch.rays);
    free(batch.hits);
    free(batch.owners);
    return NULL;
}

void trace_scene(struct gpu *gpu, const struct scene *scene, uint32_t width, uint32_t height,
                 uint32_t *pixels)
{
    struct trace trace = {
        .gpu = gpu,
        .trace_rays =
            (PFN_vkTraceRaysASSAY)gpu->get_device_command(gpu->device, "vkTraceRaysASSAY"),
        .top = scene->top.structure.handle,
        .width = width,
        .height = height,
        .pixels = pixels,
    };
    if (!trace.trace_rays)
        tool_fail("the device has no vkTraceRaysASSAY: its backend isn't cpu");
    shade_scene_open(&trace.shading, scene);
    pthread_t threads[THREADS_MAX];
    long wanted = sysconf(_SC_NPROCESSORS_ONLN) - 1, count = 0;
    while (count < wanted && count < THREADS_MAX &&
           pthread_create(&threads[count], NULL, draw, &trace) == 0)
        ++count;
    draw(&trace);
    while (count > 0)
        pthread_join(threads[--count], NULL);
}
