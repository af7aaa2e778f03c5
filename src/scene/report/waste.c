/* SPDX-License-Identifier: Apache-2.0 */
/* What the scene wastes: the layer's advice, and trees that become worse with each update. */
#include <stdlib.h>
#include <string.h>

#include "src/scene/report/report.h"

enum { CURVES = 24, POINTS = 120 };

uint32_t report_find_root(const struct report *report, uint32_t command)
{
    const struct captured_command *commands = report->capture->commands;
    while (command != CAPTURE_NONE && commands[command].kind == CAPTURE_COMMAND_BUILD &&
           commands[command].mode == CAPTURE_UPDATE) {
        const uint32_t from = commands[command].src;
        while (command-- > 0 && !((commands[command].kind == CAPTURE_COMMAND_BUILD ||
                                   commands[command].kind == CAPTURE_COMMAND_COPY) &&
                                  commands[command].dst == from && from != CAPTURE_NONE))
            ;
        if (command != CAPTURE_NONE && commands[command].kind == CAPTURE_COMMAND_COPY) {
            uint32_t *builds = contents_find_builds(report->capture, command + 1);
            command = builds[from];
            free(builds);
        }
    }
    return command;
}

static json_t *make_advice(const struct report *report)
{
    const struct capture *capture = report->capture;
    json_t *advice = json_array();
    for (uint32_t i = 0; i < capture->finding_count; i++) {
        const struct captured_finding *finding = &capture->findings[i];
        if (strstr(finding->id, "-advice-"))
            json_array_append_new(
                advice, json_pack("{s:s, s:s}", "id", finding->id, "message", finding->message));
    }
    return advice;
}

static double sah_of(const struct report_mesh *mesh)
{
    struct builder_statistics statistics = {.nodes = 0};
    if (mesh->tree)
        builder_measure(mesh->tree, &statistics);
    return statistics.sah;
}

static void add_point(json_t *points, const struct captured_command *command,
                      const struct report_mesh *mesh, const struct report_mesh *rebuilt)
{
    json_array_append_new(points,
                          json_pack("{s:I, s:I, s:f, s:f}", "frame", (json_int_t)command->frame,
                                    "submission", (json_int_t)command->submission, "sah",
                                    sah_of(mesh), "rebuilt", sah_of(rebuilt)));
}

/* The cost of the tree of a structure after each of its builds and updates. */
static json_t *make_curve(struct report *report, uint32_t structure, uint32_t updates)
{
    struct report_mesh mesh = {.primitives = 0};
    json_t *points = json_array();
    uint32_t at = 0;
    const uint32_t step = updates / POINTS + 1;
    for (uint32_t i = 0; i < report->command_count; i++) {
        const struct captured_command *command = &report->capture->commands[i];
        if (command->kind != CAPTURE_COMMAND_BUILD || command->dst != structure)
            continue;
        struct report_mesh next = {.primitives = 0};
        report_read_mesh(report, i, &next);
        bool is_refitted = false;
        if (command->mode == CAPTURE_UPDATE) {
            const uint32_t root =
                command->src == structure ? CAPTURE_NONE : report_find_root(report, i);
            if (root != CAPTURE_NONE) {
                report_free_mesh(&mesh);
                report_read_mesh(report, root, &mesh);
                report_build_mesh(&mesh, BUILDER_BALANCED, 0, REPORT_THREADS);
                if (!at) /* the first point is the tree that it was updated from */
                    add_point(points, &report->capture->commands[root], &mesh, &mesh);
            }
            is_refitted = report_refit_mesh(&mesh, &next.input);
        }
        const bool is_shown = at++ % step == 0 || at == updates || !is_refitted;
        if (is_shown || !is_refitted)
            report_build_mesh(&next, BUILDER_BALANCED, 0, REPORT_THREADS);
        if (is_shown)
            add_point(points, command, is_refitted ? &mesh : &next, &next);
        if (!is_refitted) {
            struct report_mesh old = mesh;
            mesh = next;
            next = old;
        }
        report_free_mesh(&next);
    }
    report_free_mesh(&mesh);
    return points;
}

static json_t *make_curves(struct report *report, json_int_t *left_out)
{
    const uint32_t count = report->capture->structure_count;
    uint32_t *updates = capture_allocate(NULL, count, sizeof(*updates));
    json_t *curves = json_array();
    *left_out = 0;
    memset(updates, 0, count * sizeof(*updates));
    for (uint32_t i = 0; i < report->command_count; i++) {
        const struct captured_command *command = &report->capture->commands[i];
        if (command->kind == CAPTURE_COMMAND_BUILD && command->mode == CAPTURE_UPDATE &&
            command->dst != CAPTURE_NONE && !contents_is_top(report->capture, i))
            updates[command->dst]++;
    }
    for (;;) {
        uint32_t most = 0;
        for (uint32_t i = 0; i < count; i++)
            most = updates[i] > updates[most] ? i : most;
        if (!count || !updates[most])
            break;
        if (json_array_size(curves) < CURVES)
            json_array_append_new(
                curves, json_pack("{s:I, s:s, s:i, s:o}", "structure",
                                  (json_int_t)report->capture->structures[most].id, "name",
                                  report_name(report, most), "updates", updates[most], "points",
                                  make_curve(report, most, updates[most])));
        else
            ++*left_out;
        updates[most] = 0;
    }
    free(updates);
    return curves;
}

void waste_report(struct report *report)
{
    json_int_t left_out;
    report_progress(report, "waste");
    json_t *curves = make_curves(report, &left_out);
    json_object_set_new(report->root, "waste",
                        json_pack("{s:o, s:o, s:I}", "advice", make_advice(report), "refits",
                                  curves, "structures left out", left_out));
}
