/* SPDX-License-Identifier: Apache-2.0 */
/* Makes the rays: of the camera, random ones, and adversarial ones. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "src/bvh/motion.h"
#include "src/scene/report/report.h"

enum { SAMPLES = 4096, SAMPLES_OFF = SAMPLES / 100 }; /* `off`: that do not count as the scene */
#define FIELD_OF_VIEW 0.7                             /* radians */

uint64_t rays_random(uint64_t *random) /* splitmix64 */
{
    uint64_t z = *random += 0x9e3779b97f4a7c15;
    z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9;
    z = (z ^ z >> 27) * 0x94d049bb133111eb;
    return z ^ z >> 31;
}

double rays_random_between(uint64_t *random, double low, double high)
{
    return low + (high - low) * ((double)(rays_random(random) >> 11) * 0x1p-53);
}

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void cross(const double a[3], const double b[3], double to[3])
{
    for (int i = 0; i < 3; i++)
        to[i] = a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3];
}

static bool normalize(double vector[3])
{
    const double length = sqrt(dot(vector, vector));
    for (int i = 0; i < 3; i++)
        vector[i] /= length;
    return length > 0 && isfinite(length);
}

static void random_direction(uint64_t *random, double to[3])
{
    do {
        for (int i = 0; i < 3; i++)
            to[i] = rays_random_between(random, -1, 1);
    } while (dot(to, to) > 1 || !normalize(to));
}

/* ---- points of primitives */

/* Reads three points of a primitive: corners of a triangle, or of a face of a box. */
static bool read_corners(const struct report_mesh *mesh, uint32_t geometry, uint32_t primitive,
                         uint64_t *random, double corners[3][3])
{
    struct triangle_record triangle;
    struct aabb_record box;
    if (mesh->input.geometries[geometry].type == VK_GEOMETRY_TYPE_TRIANGLES_KHR) {
        if (source_triangle(&mesh->sources[geometry], primitive, &triangle) != SOURCE_ACTIVE)
            return false;
        for (int i = 0; i < 3; i++) {
            corners[0][i] = triangle.a[i];
            corners[1][i] = triangle.b[i];
            corners[2][i] = triangle.c[i];
        }
    } else {
        if (source_aabb(&mesh->sources[geometry], primitive, &box) != SOURCE_ACTIVE)
            return false;
        const uint64_t bits = rays_random(random);
        for (int corner = 0; corner < 3; corner++)
            for (int i = 0; i < 3; i++)
                corners[corner][i] = (bits >> i & 1) ^ (corner > 0 && i == (int)(bits >> 8) % 3) ^
                                             (corner > 1 && i == (int)((bits >> 8) + 1) % 3)
                                         ? box.upper[i]
                                         : box.lower[i];
    }
    double sum = 0;
    for (int i = 0; i < 9; i++)
        sum += corners[i / 3][i % 3];
    return isfinite(sum);
}

static void move(const VkTransformMatrixKHR *matrix, const double from[3], double to[3])
{
    for (int i = 0; i < 3; i++) {
        const float *row = matrix->matrix[i];
        to[i] = row[0] * from[0] + row[1] * from[1] + row[2] * from[2] + row[3];
    }
}

/* Chooses a primitive of an instance, and reads its corners in the world. */
static bool choose_corners(const struct report *report, uint64_t *random, double corners[3][3])
{
    for (int tries = 0; tries < 64 && report->instance_count; tries++) {
        const VkAccelerationStructureInstanceKHR *instance =
            &report->instances[rays_random(random) % report->instance_count];
        if (!instance->accelerationStructureReference || !instance->mask)
            continue;
        const struct report_mesh *mesh =
            &report->meshes[instance->accelerationStructureReference - 1];
        uint64_t primitive = mesh->primitives ? rays_random(random) % mesh->primitives : 0;
        uint32_t geometry = 0;
        while (geometry < mesh->input.geometry_count &&
               primitive >= mesh->input.ranges[geometry].primitiveCount)
            primitive -= mesh->input.ranges[geometry++].primitiveCount;
        double local[3][3];
        if (geometry == mesh->input.geometry_count ||
            !read_corners(mesh, geometry, (uint32_t)primitive, random, local))
            continue;
        for (int i = 0; i < 3; i++)
            move(&instance->transform, local[i], corners[i]);
        return true;
    }
    return false;
}

static void point_of(const double corners[3][3], uint64_t *random, double to[3])
{
    double u = rays_random_between(random, 0, 1), v = rays_random_between(random, 0, 1);
    if (u + v > 1) {
        u = 1 - u;
        v = 1 - v;
    }
    for (int i = 0; i < 3; i++)
        to[i] = corners[0][i] * (1 - u - v) + corners[1][i] * u + corners[2][i] * v;
}

static void point_of_edge(const double corners[3][3], uint64_t *random, double to[3])
{
    const int edge = (int)(rays_random(random) % 3);
    const double at = rays_random_between(random, 0, 1);
    for (int i = 0; i < 3; i++)
        to[i] = corners[edge][i] * (1 - at) + corners[(edge + 1) % 3][i] * at;
}

/* ---- the camera */

static int compare_doubles(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* Points of the scene, by axis. */
struct samples {
    double at[3][SAMPLES];
    int count;
};

/* Finds where most of the scene is: outliers would make the rest a dot. */
static void find_center(struct report *report, struct samples *samples)
{
    uint64_t random = 1;
    samples->count = 0;
    for (int i = 0; i < SAMPLES; i++) {
        double corners[3][3], point[3];
        if (!choose_corners(report, &random, corners))
            continue;
        point_of((const double(*)[3])corners, &random, point);
        for (int axis = 0; axis < 3; axis++)
            samples->at[axis][samples->count] = point[axis];
        samples->count++;
    }
    report->radius = 0;
    for (int axis = 0; axis < 3 && samples->count; axis++) {
        double sorted[SAMPLES];
        memcpy(sorted, samples->at[axis], sizeof(sorted));
        qsort(sorted, (size_t)samples->count, sizeof(*sorted), compare_doubles);
        const int off = samples->count * SAMPLES_OFF / SAMPLES;
        const double low = sorted[off], high = sorted[samples->count - 1 - off];
        report->center[axis] = low / 2 + high / 2;
        report->radius = hypot(report->radius, high / 2 - low / 2);
    }
    if (!(report->radius > 0) || !isfinite(report->radius))
        report->radius = 1;
}

/* Returns how far from the center the camera must be to see most of the samples. */
static double find_distance(const struct report *report, const struct samples *samples)
{
    const double(*axes)[3] = report->camera.axes;
    double *distances = capture_allocate(NULL, SAMPLES, sizeof(*distances));
    for (int i = 0; i < samples->count; i++) {
        double at[3], to[3];
        for (int axis = 0; axis < 3; axis++)
            at[axis] = samples->at[axis][i] - report->center[axis];
        for (int axis = 0; axis < 3; axis++) /* the first two are as long as the picture's half */
            to[axis] = dot(at, axes[axis]) / dot(axes[axis], axes[axis]);
        distances[i] = fmax(fabs(to[0]), fabs(to[1])) - to[2];
    }
    qsort(distances, (size_t)samples->count, sizeof(*distances), compare_doubles);
    const int last = samples->count - 1 - samples->count * SAMPLES_OFF / SAMPLES;
    const double most = samples->count ? distances[last] : 0;
    free(distances);
    return most > 0 && isfinite(most) ? 1.05 * most : report->radius;
}

void rays_fit_camera(struct report *report)
{
    struct camera *camera = &report->camera;
    const double *given = report->options->camera;
    double up[3] = {0, 1, 0}, *forward = camera->axes[2];
    struct samples *samples = capture_allocate(NULL, 1, sizeof(*samples));
    find_center(report, samples);
    for (int i = 0; i < 3; i++)
        forward[i] = report->options->has_camera ? given[3 + i] - given[i]
                                                 : (const double[]){-0.55, -0.45, -0.7}[i];
    if (!normalize(forward)) {
        forward[0] = forward[1] = 0;
        forward[2] = -1;
    }
    if (fabs(forward[1]) > 0.999) {
        up[1] = 0;
        up[2] = 1;
    }
    cross(forward, up, camera->axes[0]);
    normalize(camera->axes[0]);
    cross(camera->axes[0], forward, camera->axes[1]);
    for (int i = 0; i < 3; i++) {
        camera->axes[1][i] *= tan(FIELD_OF_VIEW / 2);
        camera->axes[0][i] *= tan(FIELD_OF_VIEW / 2) * REPORT_PICTURE_WIDTH / REPORT_PICTURE_HEIGHT;
    }
    const double distance = find_distance(report, samples);
    for (int i = 0; i < 3; i++)
        camera->eye[i] =
            report->options->has_camera ? given[i] : report->center[i] - distance * forward[i];
    free(samples);
}

static struct trace_ray make_ray(const double origin[3], const double direction[3])
{
    struct trace_ray ray = {.t_max = INFINITY, .cull_mask = 0xff};
    for (int i = 0; i < 3; i++) {
        ray.origin[i] = (float)origin[i];
        ray.direction[i] = (float)direction[i];
    }
    return ray;
}

struct trace_ray camera_ray(const struct report *report, double x, double y)
{
    const struct camera *camera = &report->camera;
    double direction[3];
    for (int i = 0; i < 3; i++)
        direction[i] = camera->axes[2][i] + x * camera->axes[0][i] - y * camera->axes[1][i];
    struct trace_ray ray = make_ray(camera->eye, direction);
    ray.time = report->has_motion ? 0.5f : 0;
    return ray;
}

/* ---- sets */

/* A ray from the origin to the target, at t = 1. The difference is that of the rounded origin. */
static struct trace_ray ray_to(const double origin[3], const double target[3])
{
    double direction[3];
    for (int i = 0; i < 3; i++)
        direction[i] = (double)(float)target[i] - (double)(float)origin[i];
    return make_ray(origin, direction);
}

static void random_point(const struct report *report, uint64_t *random, double reach, double to[3])
{
    double direction[3];
    random_direction(random, direction);
    for (int i = 0; i < 3; i++)
        to[i] = report->center[i] + reach * report->radius * direction[i];
}

static struct trace_ray surface_ray(const struct report *report, uint64_t *random,
                                    const double corners[3][3])
{
    double at[3], direction[3];
    point_of(corners, random, at);
    random_direction(random, direction);
    struct trace_ray ray = make_ray(at, direction);
    if (rays_random(random) % 2) { /* from before the surface, with the surface at tmin */
        for (int i = 0; i < 3; i++)
            ray.origin[i] = (float)(at[i] - direction[i] * report->radius);
        ray.t_min = (float)report->radius;
    }
    return ray;
}

static struct trace_ray axis_ray(const struct report *report, uint64_t *random,
                                 const double corners[3][3])
{
    double at[3];
    point_of(corners, random, at);
    const uint64_t bits = rays_random(random);
    const int axis = (int)(bits % 3);
    const double sign = bits >> 8 & 1 ? 1 : -1;
    at[axis] = report->center[axis] - sign * 2 * report->radius;
    struct trace_ray ray = make_ray(at, (const double[3]){0, 0, 0});
    ray.direction[axis] = (float)(sign * pow(10, rays_random_between(random, -15, 15)));
    ray.direction[(axis + 1) % 3] = bits >> 9 & 1 ? -0.f : 0.f;
    return ray;
}

/* Aims at an edge, in the plane of the triangle but for one part in 100,000. */
static struct trace_ray grazing_ray(const struct report *report, uint64_t *random,
                                    const double corners[3][3])
{
    double sides[2][3], normal[3], across[3], at[3], origin[3];
    point_of_edge(corners, random, at);
    for (int i = 0; i < 3; i++) {
        sides[0][i] = corners[1][i] - corners[0][i];
        sides[1][i] = corners[2][i] - corners[0][i];
    }
    cross(sides[0], sides[1], normal);
    const double turn = rays_random_between(random, 0, 6.28318530718);
    if (!normalize(normal) || !normalize(sides[0]))
        random_direction(random, normal);
    cross(normal, sides[0], across);
    for (int i = 0; i < 3; i++)
        origin[i] = at[i] + report->radius * (cos(turn) * sides[0][i] + sin(turn) * across[i] +
                                              1e-5 * normal[i]);
    return ray_to(origin, at);
}

static struct trace_ray make_one(const struct report *report, enum ray_set_kind kind,
                                 uint64_t *random)
{
    double corners[3][3] = {{0}}, from[3], to[3];
    if (kind == RAYS_CAMERA) {
        const double x = rays_random_between(random, -1, 1), y = rays_random_between(random, -1, 1);
        return camera_ray(report, x, y);
    }
    if (!choose_corners(report, random, corners))
        memcpy(corners[0], report->center, sizeof(corners[0]));
    const double(*c)[3] = (const double(*)[3])corners;
    switch (kind) {
    case RAYS_SURFACE:
        return surface_ray(report, random, c);
    case RAYS_AXIS:
        return axis_ray(report, random, c);
    case RAYS_GRAZING:
        return grazing_ray(report, random, c);
    case RAYS_VERTICES:
        random_point(report, random, 1.5, from);
        return ray_to(from, corners[rays_random(random) % 3]);
    case RAYS_EDGES:
        random_point(report, random, 1.5, from);
        break;
    case RAYS_FAR:
        random_point(report, random, pow(10, rays_random_between(random, 2, 4)), from);
        break;
    default:
        random_point(report, random, rays_random_between(random, 0, 1), from);
        random_point(report, random, rays_random_between(random, 0, 1), to);
        return ray_to(from, to);
    }
    point_of_edge(c, random, to);
    return ray_to(from, to);
}

#define RAY_SET_TEXTS(name, text, says) {text, says, 0, NULL},

void rays_make(const struct report *report, struct ray_set sets[RAY_SETS])
{
    static const struct ray_set empty[RAY_SETS] = {RAY_SET_LIST(RAY_SET_TEXTS)};
    const uint32_t count = report->options->rays ? report->options->rays : REPORT_RAYS;
    for (enum ray_set_kind kind = 0; kind < RAY_SETS; kind++) {
        uint64_t random = 1000 + kind;
        sets[kind] = empty[kind];
        sets[kind].count = count;
        sets[kind].rays = capture_allocate(NULL, count, sizeof(*sets[kind].rays));
        for (uint32_t i = 0; i < count; i++) {
            sets[kind].rays[i] = make_one(report, kind, &random);
            if (report->has_motion)
                sets[kind].rays[i].time = (float)rays_random_between(&random, 0, 1);
        }
    }
}

void rays_free(struct ray_set sets[RAY_SETS])
{
    for (int i = 0; i < RAY_SETS; i++)
        free(sets[i].rays);
}

bool rays_aim(const struct report_mesh *mesh, uint32_t geometry, uint32_t primitive, bool at_edge,
              const VkAccelerationStructureInstanceKHR *instance, uint64_t *random,
              struct trace_ray *ray)
{
    double corners[3][3], at[3], from[3], size = 0;
    if (geometry >= mesh->input.geometry_count || !mesh->sources[geometry].count ||
        !read_corners(mesh, geometry, primitive, random, corners))
        return false;
    if (at_edge)
        point_of_edge((const double(*)[3])corners, random, at);
    else
        point_of((const double(*)[3])corners, random, at);
    for (int i = 0; i < 9; i++)
        size = fmax(size, fabs(corners[i / 3][i % 3] - corners[0][i % 3]));
    random_direction(random, from);
    const double reach = (size > 0 ? size : 1) * rays_random_between(random, 1, 100);
    for (int i = 0; i < 3; i++)
        from[i] = at[i] + reach * from[i];
    if (instance) {
        double moved[2][3];
        move(&instance->transform, from, moved[0]);
        move(&instance->transform, at, moved[1]);
        *ray = ray_to(moved[0], moved[1]);
    } else {
        *ray = ray_to(from, at);
    }
    return true;
}
