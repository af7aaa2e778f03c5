/* SPDX-License-Identifier: Apache-2.0 */
/* accuracy_rays RAYS: what each accuracy of the reference traversal costs, and how often it is
 * wrong, by sets of that many rays: lines of comma-separated values on stdout, a word of progress
 * on stderr. Exits with 1 where accuracy exact was wrong. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "ray_sets.h"
#include "tests/tools/measure.h"
#include "truth.h"

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
        bench->rays[i] = set->make(&bench->sphere, &random);
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
