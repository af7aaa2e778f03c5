/* SPDX-License-Identifier: Apache-2.0 */
/* accuracy_rays RAYS: what each accuracy of the reference traversal costs, and how often it is
 * wrong, by sets of that many rays: lines of comma-separated values on stdout, a word of progress
 * on stderr. Exits with 1 where accuracy exact was wrong. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "scripts/tools/measure.h"
#include "truth.h"

/* ---- sets of rays against a closed sphere of triangles, from harmless to hard */

enum { RAY_SETS = 6 };
enum ray_kind {
    RAYS_FROM_OUTSIDE,
    RAYS_FROM_AFAR,
    RAYS_AT_EDGES,
    RAYS_AT_VERTICES,
    RAYS_GRAZING,
};

struct ray_set {
    const char *name;
    int crossings; /* 1 for rays from within the sphere, 0 for those from outside */
    float scale;   /* of the sphere, which has its center at 0 and else radius 1 */
    enum ray_kind kind;
};

/* Coordinates down there have 13 bits or fewer left. */
#define SUBNORMAL 0x1p-136f

static struct trace_ray ray_between(const double from[3], const double to[3])
{
    struct trace_ray ray = fixture_ray(0, 0, 0, 0, 0, 0);
    for (int i = 0; i < 3; i++) {
        ray.origin[i] = (float)from[i];
        ray.direction[i] = (float)(to[i] - ray.origin[i]);
    }
    return ray;
}

/* On a sphere of that radius. */
static void on_sphere(uint64_t *random, double radius, double at[3])
{
    double square;
    do {
        square = 0;
        for (int i = 0; i < 3; i++) {
            at[i] = fixture_uniform(random, -1, 1);
            square += at[i] * at[i];
        }
    } while (square > 1 || square < 0.01);
    for (int i = 0; i < 3; i++)
        at[i] *= radius / sqrt(square);
}

/* A vertex, or a point of an edge as far as floats have it. */
static void on_edge(const struct fixture_mesh *sphere, uint64_t *random, bool is_vertex,
                    double at[3])
{
    const uint32_t triangle = (uint32_t)(fixture_random(random) % sphere->triangle_count);
    const uint32_t corner = (uint32_t)(fixture_random(random) % 3);
    const uint32_t *indices = &sphere->indices[3 * (size_t)triangle];
    const float *a = &sphere->positions[3 * (size_t)indices[corner]];
    const float *b = &sphere->positions[3 * (size_t)indices[(corner + 1) % 3]];
    const double along = is_vertex ? 0 : fixture_uniform(random, 0, 1);
    for (int i = 0; i < 3; i++)
        at[i] = a[i] + along * ((double)b[i] - a[i]);
}

static struct trace_ray from_within(const struct fixture_mesh *sphere, uint64_t *random,
                                    bool at_vertex)
{
    double from[3], to[3];
    for (int i = 0; i < 3; i++)
        from[i] = fixture_uniform(random, -0.4f, 0.4f);
    on_edge(sphere, random, at_vertex, to);
    return ray_between(from, to);
}

/* From outside, at anything. */
static struct trace_ray from_outside(uint64_t *random, double scale, double distance)
{
    double from[3], to[3];
    on_sphere(random, scale * distance, from);
    for (int i = 0; i < 3; i++)
        to[i] = scale * fixture_uniform(random, -1, 1);
    return ray_between(from, to);
}

/* Tangent to the sphere where it has an edge or a vertex. */
static struct trace_ray grazing_ray(const struct fixture_mesh *sphere, uint64_t *random)
{
    double from[3], to[3], aside[3], tangent[3];
    on_edge(sphere, random, fixture_random(random) % 2 == 0, to);
    on_sphere(random, 1, aside);
    for (int i = 0; i < 3; i++) {
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        tangent[i] = to[j] * aside[k] - to[k] * aside[j];
    }
    const double length = hypot(hypot(tangent[0], tangent[1]), tangent[2]);
    for (int i = 0; i < 3; i++)
        from[i] = to[i] + 2 * tangent[i] / (length > 0 ? length : 1);
    return ray_between(from, to);
}

static const struct ray_set ray_sets[RAY_SETS] = {
    {"random", 0, 1, RAYS_FROM_OUTSIDE},  {"edges", 1, 1, RAYS_AT_EDGES},
    {"vertices", 1, 1, RAYS_AT_VERTICES}, {"grazing", 0, 1, RAYS_GRAZING},
    {"far origin", 0, 1, RAYS_FROM_AFAR}, {"subnormal", 0, SUBNORMAL, RAYS_FROM_OUTSIDE},
};

static struct trace_ray ray_set_ray(const struct ray_set *set, const struct fixture_mesh *sphere,
                                    uint64_t *random)
{
    switch (set->kind) {
    case RAYS_AT_EDGES:
    case RAYS_AT_VERTICES:
        return from_within(sphere, random, set->kind == RAYS_AT_VERTICES);
    case RAYS_GRAZING:
        return grazing_ray(sphere, random);
    case RAYS_FROM_AFAR:
        return from_outside(random, set->scale, pow(10, fixture_uniform(random, 3, 6)));
    default:
        return from_outside(random, set->scale, 2);
    }
}

/* The sphere of a set, as fine as `side` says (fixture_sphere). */
static struct fixture_mesh ray_set_sphere(const struct ray_set *set, uint32_t side)
{
    static const float center[3] = {0, 0, 0};
    struct fixture_mesh sphere = fixture_sphere(side, 1, center);
    for (uint32_t i = 0; i < 3 * sphere.vertex_count; i++)
        sphere.positions[i] *= set->scale;
    return sphere;
}

/* ---- what is measured */

enum { SIDE = 40, RUNS = 3, QUALITIES = 3, ACCURACIES = 3 };

static const char *const quality_names[QUALITIES] = {"fast", "balanced", "high"};
static const char *const accuracy_names[ACCURACIES] = {"fast", "robust", "exact"};

/* Rays of which something is wrong, and those of which the nearest hit is. */
struct mistakes {
    uint32_t any, nearest;
};

/* One set, its sphere and its rays. */
struct bench {
    const struct ray_set *set;
    struct fixture_mesh sphere;
    void *structures[QUALITIES];
    struct trace_ray *rays;
    uint32_t ray_count;
    struct mistakes mistakes[QUALITIES][ACCURACIES];
};

static void open_bench(struct bench *bench, const struct ray_set *set, uint32_t ray_count)
{
    uint64_t random = 88172645463325252u;
    struct fixture_input input;
    *bench = (struct bench){.set = set, .ray_count = ray_count};
    bench->sphere = ray_set_sphere(set, SIDE);
    fixture_input_mesh(&input, &bench->sphere);
    for (int i = 0; i < QUALITIES; i++) {
        input.input.quality = (enum builder_quality)i;
        bench->structures[i] = fixture_build(&input.input, NULL);
    }
    bench->rays = fixture_allocate(ray_count * sizeof(*bench->rays));
    for (uint32_t i = 0; i < ray_count; i++)
        bench->rays[i] = ray_set_ray(set, &bench->sphere, &random);
}

static void close_bench(struct bench *bench)
{
    for (int i = 0; i < QUALITIES; i++)
        free(bench->structures[i]);
    free(bench->rays);
    fixture_mesh_free(&bench->sphere);
}

/* ---- wrong answers */

static void judge(const struct bench *bench, const void *structure, enum trace_accuracy accuracy,
                  const struct trace_ray *ray, const struct truth *truth, struct mistakes *mistakes)
{
    const int crossings = bench->set->crossings;
    struct fixture_hits hits;
    struct trace_hit nearest;
    fixture_trace_all(structure, accuracy, ray, &hits);
    const bool is_hit = fixture_trace(structure, accuracy, ray, &nearest);
    const bool is_nearest =
        is_hit == (hits.count > 0) && truth_allows_nearest(truth, is_hit, &nearest, crossings);
    mistakes->nearest += !is_nearest;
    mistakes->any += !is_nearest || !truth_allows(truth, &hits, crossings);
}

static void count_wrong(struct bench *bench)
{
    struct truth_mesh mesh;
    truth_open(&mesh, &bench->sphere);
    for (uint32_t i = 0; i < bench->ray_count; i++) {
        struct truth truth;
        truth_find(&mesh, &bench->rays[i], &truth);
        for (int quality = 0; quality < QUALITIES; quality++)
            for (int accuracy = 0; accuracy < ACCURACIES; accuracy++)
                judge(bench, bench->structures[quality], (enum trace_accuracy)accuracy,
                      &bench->rays[i], &truth, &bench->mistakes[quality][accuracy]);
    }
    truth_close(&mesh);
}

/* ---- time */

/* Nanoseconds a ray, for its nearest hit: the best of several runs. */
static double measure(const struct bench *bench, int quality, int accuracy)
{
    double best = INFINITY;
    for (int run = 0; run < RUNS; run++) {
        const double begin = thread_time();
        struct trace_hit hit;
        for (uint32_t i = 0; i < bench->ray_count; i++)
            fixture_trace(bench->structures[quality], (enum trace_accuracy)accuracy,
                          &bench->rays[i], &hit);
        best = fmin(best, thread_time() - begin);
    }
    return best / bench->ray_count;
}

/* ---- all of it */

static bool run_set(const struct ray_set *set, uint32_t ray_count)
{
    struct bench bench;
    bool is_good = true;
    fprintf(stderr, "  rays: %s\n", set->name);
    open_bench(&bench, set, ray_count);
    count_wrong(&bench);
    for (int quality = 0; quality < QUALITIES; quality++)
        for (int accuracy = 0; accuracy < ACCURACIES; accuracy++) {
            const struct mistakes *mistakes = &bench.mistakes[quality][accuracy];
            printf("%s,%s,%s,%.1f,%u,%.0f,%.0f\n", set->name, quality_names[quality],
                   accuracy_names[accuracy], measure(&bench, quality, accuracy), ray_count,
                   1e6 * mistakes->any / ray_count, 1e6 * mistakes->nearest / ray_count);
            is_good = is_good && (accuracy != TRACE_EXACT || mistakes->any == 0);
        }
    close_bench(&bench);
    return is_good;
}

int main(int count, char **arguments)
{
    const uint32_t rays = count > 1 ? (uint32_t)strtoul(arguments[1], NULL, 10) : 200000;
    bool is_good = rays > 0;
    printf("rays,quality,accuracy,ns_a_ray,traced,wrong_in_a_million,nearest_wrong_in_a_million\n");
    for (int i = 0; i < RAY_SETS && rays > 0; i++)
        is_good = run_set(&ray_sets[i], rays) && is_good;
    return is_good ? EXIT_SUCCESS : EXIT_FAILURE;
}
