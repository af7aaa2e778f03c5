/* SPDX-License-Identifier: Apache-2.0 */
/* assay-scene report: calls the parts, and writes what they made. */
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "src/scene/report/report.h"

/* The page, of page.html, page.css and page.js, before and after the place of its data (CMake). */
extern const char page_before[], page_after[];

static bool fail_to_write(const struct report *report, const char *path)
{
    snprintf(report->error->text, sizeof(report->error->text), "%.512s: %s", path, strerror(errno));
    return false;
}

/* JSON inside an element of a page must not end the element. */
static void write_escaped(FILE *file, const char *text)
{
    for (size_t length; *text; text += length) {
        length = strcspn(text, "<");
        fwrite(text, 1, length, file);
        if (text[length]) {
            fputs("\\u003c", file);
            length++;
        }
    }
}

static bool write_file(const struct report *report, const char *path, const char *text,
                       bool is_page)
{
    FILE *file = fopen(path, "wb");
    if (!file)
        return fail_to_write(report, path);
    if (is_page) {
        fputs(page_before, file);
        write_escaped(file, text);
        fputs(page_after, file);
    } else {
        fprintf(file, "%s\n", text);
    }
    const bool is_written = !ferror(file), is_closed = fclose(file) == 0;
    return (is_written && is_closed) || fail_to_write(report, path);
}

bool write_report(const struct report *report)
{
    bool is_written = true;
    char *page = json_dumps(report->root, JSON_COMPACT | JSON_REAL_PRECISION(6));
    if (!page)
        capture_allocate(NULL, SIZE_MAX, 2);
    if (report->options->html)
        is_written = write_file(report, report->options->html, page, true);
    free(page);
    json_object_del(report->root, "planes"); /* of the page alone */
    char *text = json_dumps(report->root, JSON_INDENT(1) | JSON_REAL_PRECISION(6));
    if (!text)
        capture_allocate(NULL, SIZE_MAX, 2);
    if (is_written && report->options->json)
        is_written = write_file(report, report->options->json, text, false);
    free(text);
    return is_written;
}

static json_t *make_left_out(const struct report *report)
{
    json_t *object = json_object();
    for (int i = 0; i < LEFT_OUT; i++)
        if (report->left_out[i])
            json_object_set_new(object, left_out_names[i],
                                json_integer((json_int_t)report->left_out[i]));
    return object;
}

/* What the parts of the report look at: a point of the capture, and a top-level structure. */
static void add_subject(struct report *report)
{
    const struct camera *camera = &report->camera;
    json_object_set_new(report->root, "version", json_string(ASSAY_VERSION));
    json_object_set_new(
        report->root, "subject",
        json_pack("{s:s, s:s, s:i, s:i, s:[f,f,f,f,f,f], s:[f,f,f], s:f, s:o}", "at",
                  report->options->at ? report->options->at : "the end", "top level",
                  report->top == CAPTURE_NONE ? "none: each structure at the origin"
                                              : report_name(report, report->top),
                  "structures", report->mesh_count, "instances", report->instance_count, "camera",
                  camera->eye[0], camera->eye[1], camera->eye[2],
                  camera->eye[0] + camera->axes[2][0], camera->eye[1] + camera->axes[2][1],
                  camera->eye[2] + camera->axes[2][2], "center", report->center[0],
                  report->center[1], report->center[2], "radius", report->radius, "left out",
                  make_left_out(report)));
}

bool report_capture(struct capture *capture, const struct report_options *options,
                    struct capture_error *error)
{
    struct report report = {.capture = capture,
                            .options = options,
                            .error = error,
                            .top = CAPTURE_NONE,
                            .root = json_object()};
    report_progress(&report, "reading");
    bool is_done = report_assemble(&report);
    if (is_done) {
        struct ray_set sets[RAY_SETS];
        rays_fit_camera(&report);
        add_subject(&report);
        rays_make(&report, sets);
        accuracy_report(&report, sets);
        fragile_report(&report);
        effects_report(&report, &sets[RAYS_CAMERA]);
        if (options->html)
            pictures_report(&report);
        waste_report(&report);
        device_report(&report, sets);
        rays_free(sets);
        is_done = !error->text[0] && write_report(&report);
    }
    report_release(&report);
    json_decref(report.root);
    return is_done;
}
