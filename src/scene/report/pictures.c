/* SPDX-License-Identifier: Apache-2.0 */
/* Pictures of the scene: shaded, how much work each pixel is, and where accuracies differ. The page
 * draws them on canvases, so that it can say the numbers of a pixel. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "src/scene/report/report.h"

enum { WIDTH = REPORT_PICTURE_WIDTH, HEIGHT = REPORT_PICTURE_HEIGHT, PIXELS = WIDTH * HEIGHT };
enum { WRONG_FAST = 1, WRONG_ROBUST = 2, STEP_MOST = 32 };
#define WORK_MOST 1e9 /* nodes and primitives of a picture; beyond, pixels share rays */

/* Planes of pixels, from the left and the top. */
struct planes {
    uint8_t shade[PIXELS]; /* 0: nothing is there */
    uint8_t mesh[PIXELS];  /* its number, modulo 256 */
    uint8_t wrong[PIXELS]; /* flags */
    uint16_t nodes[PIXELS], primitives[PIXELS];
};
struct painter {
    struct report *report;
    uint32_t step; /* pixels that share one ray, in both directions */
    struct planes *planes;
};

static void corner_of(const VkTransformMatrixKHR *matrix, const float from[3], double to[3])
{
    for (int i = 0; i < 3; i++)
        to[i] = matrix->matrix[i][0] * (double)from[0] + matrix->matrix[i][1] * (double)from[1] +
                matrix->matrix[i][2] * (double)from[2] + matrix->matrix[i][3];
}

/* The cosine between the ray and the surface; boxes have none, and look flat. */
static double cosine_of(const struct report *report, const struct trace_ray *ray,
                        const struct trace_hit *hit, const struct report_mesh *mesh)
{
    struct triangle_record triangle;
    double corners[3][3], normal[3], product = 0, squares[2] = {0};
    if (hit->is_aabb ||
        source_triangle(&mesh->sources[hit->geometry], hit->primitive, &triangle) != SOURCE_ACTIVE)
        return 0.7;
    const VkTransformMatrixKHR *matrix = &report->instances[hit->instance].transform;
    corner_of(matrix, triangle.a, corners[0]);
    corner_of(matrix, triangle.b, corners[1]);
    corner_of(matrix, triangle.c, corners[2]);
    for (int i = 0; i < 3; i++) {
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        normal[i] = (corners[1][j] - corners[0][j]) * (corners[2][k] - corners[0][k]) -
                    (corners[1][k] - corners[0][k]) * (corners[2][j] - corners[0][j]);
    }
    for (int i = 0; i < 3; i++) {
        product += normal[i] * ray->direction[i];
        squares[0] += normal[i] * normal[i];
        squares[1] += (double)ray->direction[i] * ray->direction[i];
    }
    const double cosine = fabs(product) / sqrt(squares[0] * squares[1]);
    return isfinite(cosine) ? fmin(cosine, 1) : 0;
}

static uint16_t narrow(uint64_t count)
{
    return count < UINT16_MAX ? (uint16_t)count : UINT16_MAX;
}

/* Copies a pixel to those that share its ray. */
static void fill(struct planes *planes, uint32_t x, uint32_t y, uint32_t step)
{
    const size_t from = (size_t)y * WIDTH + x;
    for (uint32_t row = y; row < y + step && row < HEIGHT; row++)
        for (uint32_t column = x; column < x + step && column < WIDTH; column++) {
            const size_t to = (size_t)row * WIDTH + column;
            planes->shade[to] = planes->shade[from];
            planes->mesh[to] = planes->mesh[from];
            planes->wrong[to] = planes->wrong[from];
            planes->nodes[to] = planes->nodes[from];
            planes->primitives[to] = planes->primitives[from];
        }
}

static void paint_row(void *context, uint32_t index)
{
    const struct painter *painter = context;
    struct report *report = painter->report;
    struct planes *planes = painter->planes;
    const uint32_t y = index * painter->step;
    for (uint32_t x = 0; x < WIDTH; x += painter->step) {
        const struct trace_ray ray =
            camera_ray(report, (x + 0.5) * 2 / WIDTH - 1, (y + 0.5) * 2 / HEIGHT - 1);
        const size_t at = (size_t)y * WIDTH + x;
        struct trace_counters work = {0};
        struct trace_scene scene = report_scene(report, TRACE_ROBUST);
        struct trace_hit hit;
        struct answer answers[3];
        struct wrong wrong = {.rays = 0};
        scene.counters = &work;
        if (trace_closest(&scene, &ray, &hit)) {
            const uint32_t mesh =
                (uint32_t)report->instances[hit.instance].accelerationStructureReference - 1;
            planes->shade[at] =
                (uint8_t)lrint(40 + 215 * cosine_of(report, &ray, &hit, &report->meshes[mesh]));
            planes->mesh[at] = (uint8_t)mesh;
        }
        planes->nodes[at] = narrow(work.nodes);
        planes->primitives[at] = narrow(work.primitives);
        scene.counters = NULL;
        for (int accuracy = TRACE_FAST; accuracy <= TRACE_EXACT; accuracy++) {
            scene.accuracy = (enum trace_accuracy)accuracy;
            answer_find(&scene, &ray, &answers[accuracy]);
        }
        planes->wrong[at] =
            (wrong_add(&wrong, &answers[TRACE_EXACT], &answers[TRACE_FAST]) ? WRONG_FAST : 0) |
            (wrong_add(&wrong, &answers[TRACE_EXACT], &answers[TRACE_ROBUST]) ? WRONG_ROBUST : 0);
        fill(planes, x, y, painter->step);
    }
}

static json_t *encode(const void *from, size_t size)
{
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    const uint8_t *bytes = from;
    char *text = capture_allocate(NULL, (size + 2) / 3 + 1, 4), *to = text;
    for (size_t i = 0; i < size; i += 3) {
        const uint32_t bits = (uint32_t)bytes[i] << 16 |
                              (i + 1 < size ? (uint32_t)bytes[i + 1] << 8 : 0) |
                              (i + 2 < size ? bytes[i + 2] : 0);
        for (size_t n = 0; n < 4; n++)
            *to++ = i + n < size + 1 ? digits[bits >> (18 - 6 * n) & 63] : '=';
    }
    json_t *string = json_stringn(text, (size_t)(to - text));
    free(text);
    return string;
}

static json_t *summarize(const struct planes *planes)
{
    uint64_t nodes = 0, primitives = 0, wrong[2] = {0}, most[2] = {0};
    for (int i = 0; i < PIXELS; i++) {
        nodes += planes->nodes[i];
        primitives += planes->primitives[i];
        most[0] = planes->nodes[i] > most[0] ? planes->nodes[i] : most[0];
        most[1] = planes->primitives[i] > most[1] ? planes->primitives[i] : most[1];
        wrong[0] += (planes->wrong[i] & WRONG_FAST) != 0;
        wrong[1] += (planes->wrong[i] & WRONG_ROBUST) != 0;
    }
    return json_pack("{s:i, s:i, s:f, s:I, s:f, s:I, s:I, s:I}", "width", WIDTH, "height", HEIGHT,
                     "nodes a pixel", (double)nodes / PIXELS, "most nodes", (json_int_t)most[0],
                     "primitives a pixel", (double)primitives / PIXELS, "most primitives",
                     (json_int_t)most[1], "pixels wrong at fast", (json_int_t)wrong[0],
                     "pixels wrong at robust", (json_int_t)wrong[1]);
}

void pictures_report(struct report *report)
{
    struct painter painter = {report, 1, capture_allocate(NULL, 1, sizeof(*painter.planes))};
    struct planes *planes = painter.planes;
    report_progress(report, "pictures");
    memset(planes, 0, sizeof(*planes));
    while (4 * report->camera_work * PIXELS > WORK_MOST * painter.step * painter.step &&
           painter.step < STEP_MOST)
        painter.step *= 2;
    report_parallel((HEIGHT + painter.step - 1) / painter.step, paint_row, &painter);
    json_object_set_new(report->root, "pictures", summarize(planes));
    json_object_set_new(
        report->root, "planes",
        json_pack("{s:o, s:o, s:o, s:o, s:o}", "shade", encode(planes->shade, PIXELS), "mesh",
                  encode(planes->mesh, PIXELS), "wrong", encode(planes->wrong, PIXELS), "nodes",
                  encode(planes->nodes, 2 * PIXELS), "primitives",
                  encode(planes->primitives, 2 * PIXELS)));
    free(planes);
}
