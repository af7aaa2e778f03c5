/* SPDX-License-Identifier: Apache-2.0 */
/* Which effects the scene uses, as info.c counts them, and what those cost that the reference
 * builder can leave out. */
#include <string.h>

#include "src/scene/report/report.h"

/* What rays meet besides the nearest opaque triangle. */
struct callbacks {
    uint64_t any_hits, boxes;
};

static enum trace_answer count_callback(void *context, struct trace_hit *candidate)
{
    struct callbacks *callbacks = context;
    callbacks->boxes += candidate->is_aabb;
    callbacks->any_hits += !candidate->is_aabb && !candidate->opaque;
    return candidate->is_aabb ? TRACE_IGNORE : TRACE_ACCEPT;
}

static struct callbacks count_callbacks(struct report *report, const struct ray_set *set)
{
    const struct trace_scene scene = report_scene(report, TRACE_ROBUST);
    struct callbacks callbacks = {0};
    const struct trace_visitor visitor = {count_callback, &callbacks};
    for (uint32_t i = 0; i < set->count; i++)
        trace_candidates(&scene, &set->rays[i], &visitor);
    return callbacks;
}

/* What building the scene took, and what tracing rays through it takes. */
static json_t *make_cost(struct report *report, const struct ray_set *set,
                         const struct report_built *built)
{
    struct trace_counters work = {0};
    struct trace_scene scene = report_scene(report, TRACE_ROBUST);
    struct trace_hit hit;
    scene.counters = &work;
    for (uint32_t i = 0; i < set->count; i++)
        trace_closest(&scene, &set->rays[i], &hit);
    return json_pack("{s:f, s:I, s:f, s:f, s:f}", "ms build", built->ms, "bytes",
                     (json_int_t)built->bytes, "nodes a ray", (double)work.nodes / set->count,
                     "primitives a ray", (double)work.primitives / set->count, "ns a ray",
                     accuracy_time(report, TRACE_ROBUST, set));
}

/* Adds what an effect costs to its object of info.c. */
static void set_cost(json_t *effects, const char *name, json_t *cost)
{
    size_t i;
    json_t *effect;
    json_array_foreach(effects, i,
                       effect) if (strcmp(json_string_value(json_object_get(effect, "effect")),
                                          name) == 0) json_object_set(effect, "cost", cost);
    json_decref(cost);
}

/* Replaces the trees of meshes that were updated by trees that were built and updated likewise. */
static uint32_t refit_meshes(struct report *report)
{
    uint32_t count = 0;
    for (uint32_t i = 0; i < report->mesh_count; i++) {
        struct report_mesh *mesh = &report->meshes[i], first = {.primitives = 0};
        const uint32_t root = report_find_root(report, mesh->command);
        if (root == CAPTURE_NONE || root == mesh->command)
            continue;
        report_read_mesh(report, root, &first);
        report_build_mesh(&first, BUILDER_BALANCED, 0, REPORT_THREADS);
        if (report_refit_mesh(&first, &mesh->input)) {
            void *tree = mesh->tree;
            mesh->tree = first.tree;
            first.tree = tree;
            count++;
        }
        report_free_mesh(&first);
    }
    return count;
}

void effects_report(struct report *report, const struct ray_set *set)
{
    json_t *info = info_make(report->capture, report->error);
    json_t *effects = json_object_get(info, "effects");
    const double rays = set->count;
    struct report_built built;
    report_progress(report, "effects");
    if (!info)
        return;
    report_build(report, BUILDER_BALANCED, 0, &built);
    json_t *base = make_cost(report, set, &built);
    const struct callbacks callbacks = count_callbacks(report, set);
    json_t *without =
        json_pack("{s:f, s:f}", "any-hit invocations a ray", (double)callbacks.any_hits / rays,
                  "intersection invocations a ray", (double)callbacks.boxes / rays);
    json_object_update(base, without);
    json_decref(without);
    set_cost(effects, "geometries of AABBs",
             json_pack("{s:f}", "intersection invocations a ray", (double)callbacks.boxes / rays));
    uint64_t sizes[2] = {0};
    for (uint32_t i = 0; i < report->command_count; i++) {
        const struct captured_command *copy = &report->capture->commands[i];
        if (copy->mode != CAPTURE_COMPACT || copy->src == CAPTURE_NONE || copy->dst == CAPTURE_NONE)
            continue;
        sizes[0] += report->capture->structures[copy->src].size;
        sizes[1] += report->capture->structures[copy->dst].size;
    }
    set_cost(effects, "compactions",
             json_pack("{s:{s:I}, s:{s:I}}", "with", "bytes", (json_int_t)sizes[1], "without",
                       "bytes", (json_int_t)sizes[0]));
    if (report->has_motion) {
        report_build(report, BUILDER_BALANCED, VK_BUILD_ACCELERATION_STRUCTURE_MOTION_BIT_NV,
                     &built);
        set_cost(effects, "builds with motion",
                 json_pack("{s:o, s:O}", "without", make_cost(report, set, &built), "with", base));
        report_build(report, BUILDER_BALANCED, 0, &built);
    }
    const uint32_t refits = refit_meshes(report);
    if (refits) {
        report_build_top(report, BUILDER_BALANCED, 0);
        set_cost(effects, "updates",
                 json_pack("{s:o, s:O, s:i}", "with", make_cost(report, set, &built), "without",
                           base, "structures", refits));
        report_build(report, BUILDER_BALANCED, 0, &built);
    }
    json_object_set_new(report->root, "scene", base);
    json_object_update(report->root, info);
    json_decref(info);
}
