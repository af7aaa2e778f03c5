/* SPDX-License-Identifier: Apache-2.0 */
/* accuracy_builder [quick]: what each quality of the reference builder costs, and what its trees
 * are worth, beside Embree's: lines of comma-separated values on stdout, a word of progress on
 * stderr.
 *
 * One thread, CPU time, the best of several runs, in which both take turns: a machine that others
 * slow down slows down both. Rays of the reference builder are traced at accuracy robust, those of
 * Embree in its robust mode, both with the best instruction set that they know. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "embree.h"
#include "scripts/tools/measure.h"

enum { QUALITIES = 3 };

static uint32_t runs = 5, ray_count = 100000;

/* What is measured of one tree. */
struct figures {
    double seconds, sah, ray; /* of the build; in nanoseconds */
    uint32_t hits;
};

static void print_figures(const char *mesh, uint32_t triangles, const char *builder,
                          const char *quality, const struct figures *figures)
{
    printf("%s,%u,%s,%s,%.3f,%.2f,%.1f\n", mesh, triangles, builder, quality,
           triangles / figures->seconds / 1e6, figures->sah, figures->ray);
    fflush(stdout);
}

/* ---- rays through and about a mesh, the same for all */

static struct trace_ray *make_rays(const struct fixture_mesh *mesh)
{
    struct trace_ray *rays = fixture_allocate(ray_count * sizeof(*rays));
    float lower[3] = {INFINITY, INFINITY, INFINITY}, upper[3] = {-INFINITY, -INFINITY, -INFINITY};
    uint64_t random = 88172645463325252u;
    for (uint32_t i = 0; i < 3 * mesh->vertex_count; i++) {
        lower[i % 3] = fminf(lower[i % 3], mesh->positions[i]);
        upper[i % 3] = fmaxf(upper[i % 3], mesh->positions[i]);
    }
    for (uint32_t i = 0; i < ray_count; i++)
        rays[i] = model_random_ray(lower, upper, 0.1f, &random);
    return rays;
}

/* ---- the reference builder */

static void measure_ours(const struct fixture_mesh *mesh, enum builder_quality quality,
                         const struct trace_ray *rays, struct figures *figures)
{
    struct builder_statistics statistics;
    struct builder_sizes sizes;
    struct fixture_input input;
    fixture_input_mesh(&input, mesh);
    input.input.quality = quality;
    input.input.threads = 1;
    builder_get_sizes(&input.input, &mesh->triangle_count, &sizes);
    void *structure = fixture_allocate(sizes.structure),
         *scratch = fixture_allocate(sizes.build_scratch);
    double begin = thread_time();
    builder_build(&input.input, structure, sizes.structure, scratch, sizes.build_scratch, NULL);
    figures->seconds = fmin(figures->seconds, (thread_time() - begin) / 1e9);
    struct trace_hit hit;
    figures->hits = 0;
    begin = thread_time();
    for (uint32_t i = 0; i < ray_count; i++)
        figures->hits += fixture_trace(structure, TRACE_ROBUST, &rays[i], &hit);
    figures->ray = fmin(figures->ray, (thread_time() - begin) / ray_count);
    builder_measure(structure, &statistics);
    figures->sah = statistics.sah;
    free(structure);
    free(scratch);
}

/* ---- Embree */

static void measure_embree(const struct fixture_mesh *mesh, enum embree_quality quality,
                           const struct trace_ray *rays, struct figures *figures)
{
    struct embree_scene *scene = embree_scene_create(mesh, quality);
    const struct embree_tree tree = embree_build(mesh, quality);
    figures->seconds = fmin(figures->seconds, tree.seconds);
    figures->sah = tree.sah;
    struct trace_hit hit;
    figures->hits = 0;
    double begin = thread_time();
    for (uint32_t i = 0; i < ray_count; i++)
        figures->hits += embree_trace(scene, &rays[i], &hit);
    figures->ray = fmin(figures->ray, (thread_time() - begin) / ray_count);
    embree_scene_destroy(scene);
}

/* ---- all of it */

static void measure_mesh(const char *name, struct fixture_mesh mesh)
{
    static const char *const our_names[QUALITIES] = {"fast", "balanced", "high"};
    static const char *const their_names[QUALITIES] = {"LOW", "MEDIUM", "HIGH"};
    struct trace_ray *rays = make_rays(&mesh);
    fprintf(stderr, "  builder: %s, %u triangles\n", name, mesh.triangle_count);
    for (int i = 0; i < QUALITIES; i++) {
        struct figures ours = {INFINITY, 0, INFINITY, 0}, theirs = ours;
        for (uint32_t run = 0; run < runs; run++) {
            measure_ours(&mesh, (enum builder_quality)i, rays, &ours);
            measure_embree(&mesh, (enum embree_quality)i, rays, &theirs);
        }
        /* Both may miss a few at edges. */
        if (abs((int)ours.hits - (int)theirs.hits) > (int)(ray_count / 1000)) {
            fprintf(stderr, "%s: %u hits, Embree's are %u\n", name, ours.hits, theirs.hits);
            exit(EXIT_FAILURE);
        }
        print_figures(name, mesh.triangle_count, "Assay", our_names[i], &ours);
        print_figures(name, mesh.triangle_count, "Embree", their_names[i], &theirs);
    }
    free(rays);
    fixture_mesh_free(&mesh);
}

int main(int count, char **arguments)
{
    const bool is_quick = count > 1;
    struct fixture_mesh bunny;
    if (is_quick) {
        runs = 1;
        ray_count = 2000;
    }
    if (!model_load("/usr/share/glmark2/models/bunny.obj", &bunny))
        return EXIT_FAILURE;
    printf("mesh,triangles,builder,quality,mprims_a_second,sah,ns_a_ray\n");
    measure_mesh("bunny", bunny);
    measure_mesh("terrain", fixture_terrain(is_quick ? 50 : 708));
    measure_mesh("soup", fixture_soup(is_quick ? 5000 : 200000, 1));
    return EXIT_SUCCESS;
}
