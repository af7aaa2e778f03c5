/* SPDX-License-Identifier: Apache-2.0 */
/* Cases 23 and 24 in bulk: rays from inside a closed sphere of 159,000 triangles, aimed at points
 * of its edges and at its vertices. Each has to leave through exactly one triangle. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "src/platform/aligned.h"
#include "tests/builder/fixture.h"

#define SIDE 115 /* 12 * 115 * 115 = 158,700 triangles */

struct tally {
    uint32_t missed, doubled;
    double nanoseconds;
};

static const char *const quality_names[] = {"fast", "balanced", "high"};
static const char *const accuracy_names[] = {"fast", "robust", "exact"};

static double now(void)
{
    struct timespec time;
    clock_gettime(CLOCK_MONOTONIC, &time);
    return (double)time.tv_sec * 1e9 + (double)time.tv_nsec;
}

static struct trace_ray aimed_ray(const struct fixture_mesh *mesh, const float center[3],
                                  bool at_vertex, uint64_t *random)
{
    struct trace_ray ray = fixture_ray(0, 0, 0, 0, 0, 0);
    uint32_t triangle = (uint32_t)(fixture_random(random) % mesh->triangle_count);
    uint32_t corner = (uint32_t)(fixture_random(random) % 3);
    const float *a = &mesh->positions[3 * mesh->indices[3 * triangle + corner]];
    const float *b = &mesh->positions[3 * mesh->indices[3 * triangle + (corner + 1) % 3]];
    float along = at_vertex ? 0 : fixture_uniform(random, 0, 1);
    for (int i = 0; i < 3; i++) {
        ray.origin[i] = center[i] + fixture_uniform(random, -0.4f, 0.4f);
        ray.direction[i] = a[i] + along * (b[i] - a[i]) - ray.origin[i];
    }
    return ray;
}

static struct tally shoot(const void *structure, const struct fixture_mesh *mesh,
                          const float center[3], enum trace_accuracy accuracy, bool at_vertex,
                          uint32_t rays)
{
    struct tally tally = {0};
    uint64_t random = 88172645463325252u;
    double begin = now();
    for (uint32_t i = 0; i < rays; i++) {
        struct trace_ray ray = aimed_ray(mesh, center, at_vertex, &random);
        struct fixture_hits hits;
        fixture_trace_all(structure, accuracy, &ray, &hits);
        tally.missed += hits.count == 0;
        tally.doubled += hits.count > 1;
    }
    tally.nanoseconds = (now() - begin) / rays;
    return tally;
}

/* What each accuracy may do wrong: fast misses up to a quarter, robust none; both count twice. */
static bool is_allowed(const struct tally *tally, enum trace_accuracy accuracy, uint32_t rays)
{
    return tally->missed <= (accuracy == TRACE_FAST ? rays / 4 : 0) &&
           (accuracy != TRACE_EXACT || tally->doubled == 0);
}

struct sphere {
    struct fixture_mesh mesh; /* where the rays are aimed */
    float center[3];
    uint32_t rays;
};

static bool check_rays(const char *what, const void *structure, const struct sphere *sphere,
                       enum trace_accuracy accuracy)
{
    bool is_good = true;
    for (int at_vertex = 0; at_vertex <= 1; at_vertex++) {
        struct tally tally =
            shoot(structure, &sphere->mesh, sphere->center, accuracy, at_vertex, sphere->rays);
        bool is_fine = is_allowed(&tally, accuracy, sphere->rays);
        printf(
            "offset %5g  %-18s accuracy %-6s  %u rays at %-8s: %6u missed, %6u double, "
            "%5.0f ns a ray%s\n",
            sphere->center[0], what, accuracy_names[accuracy], sphere->rays,
            at_vertex ? "vertices" : "edges", tally.missed, tally.doubled, tally.nanoseconds,
            is_fine ? "" : "  NOT ALLOWED");
        is_good &= is_fine;
    }
    return is_good;
}

static bool check_sphere(float offset, uint32_t rays)
{
    struct sphere sphere = {.center = {offset, offset, offset}, .rays = rays};
    char what[32];
    bool is_good = true;
    sphere.mesh = fixture_sphere(SIDE, 1, sphere.center);
    INPUT(mesh, input, &sphere.mesh);
    for (int quality = BUILDER_FAST; quality <= BUILDER_HIGH; quality++) {
        input.input.quality = quality;
        input.input.threads = 1 + quality % 2;
        void *structure = fixture_build(&input.input, NULL);
        snprintf(what, sizeof(what), "quality %s", quality_names[quality]);
        for (int accuracy = TRACE_FAST; accuracy <= TRACE_EXACT; accuracy++)
            is_good &= check_rays(what, structure, &sphere, accuracy);
        aligned_free(structure);
    }
    fixture_mesh_free(&sphere.mesh);
    return is_good;
}

static const VkTransformMatrixKHR turned = {
    {{1.2f, -2.1f, 0.3f, 5}, {1.7f, 0.9f, -0.4f, -70}, {0.2f, 0.6f, 0.8f, 300}}};

/* The rays are aimed in the world at where the sphere's vertices come to lie. */
static bool check_instance(uint32_t rays)
{
    struct sphere sphere = {.rays = rays};
    bool is_good = true;
    sphere.mesh = fixture_sphere(SIDE, 1, sphere.center);
    INPUT(mesh, input, &sphere.mesh);
    void *blas = fixture_build(&input.input, NULL);
    VkAccelerationStructureInstanceKHR instance = fixture_instance(blas);
    instance.transform = turned;
    fixture_input_instances(&input, &instance, 1);
    void *tlas = fixture_build(&input.input, NULL);
    for (uint32_t i = 0; i < sphere.mesh.vertex_count; i++) {
        float *at = sphere.mesh.positions + 3 * (size_t)i, from[3] = {at[0], at[1], at[2]};
        for (int row = 0; row < 3; row++) {
            const float *m = turned.matrix[row];
            at[row] = m[0] * from[0] + m[1] * from[1] + m[2] * from[2] + m[3];
            sphere.center[row] = m[3];
        }
    }
    for (int accuracy = TRACE_ROBUST; accuracy <= TRACE_EXACT; accuracy++)
        is_good &= check_rays("turned instance", tlas, &sphere, accuracy);
    aligned_free(tlas);
    aligned_free(blas);
    fixture_mesh_free(&sphere.mesh);
    return is_good;
}

int main(int count, char **arguments)
{
    uint32_t rays = count > 1 ? (uint32_t)strtoul(arguments[1], NULL, 10) : 200000;
    bool is_good = check_sphere(0, rays);
    is_good &= check_sphere(1000, rays);
    is_good &= check_instance(rays);
    return is_good ? 0 : 1;
}
