/* SPDX-License-Identifier: Apache-2.0 */
/* The figures of assay-scene report against others that are found without it: the SAH cost against
 * Embree's of the same triangles, node visits against a walk over the tree, and wrong answers
 * against rational arithmetic (GMP). */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "exact.h"
#include "src/bvh/structure.h"
#include "src/platform/aligned.h"
#include "src/scene/report/report.h"
#include "tests/builder/fixture.h"
#ifdef HAS_EMBREE
#include "scripts/tools/accuracy/embree.h"
#endif

static int failures;

static void expect(bool is_so, const char *what, double a, double b)
{
    failures += !is_so;
    printf("%-6s %s: %g, %g\n", is_so ? "right" : "WRONG", what, a, b);
}

/* A report of one mesh and one instance, without a capture. */
struct subject {
    struct fixture_mesh mesh;
    struct fixture_input input;
    struct report_options options;
    struct report_mesh meshes[1];
    struct source sources[1];
    VkAccelerationStructureInstanceKHR instances[1];
    struct report report;
};

static void open_subject(struct subject *subject, struct fixture_mesh mesh, uint32_t rays)
{
    subject->mesh = mesh;
    fixture_input_mesh(&subject->input, &subject->mesh);
    subject->input.input.geometries = &subject->input.geometry;
    if (!source_open(subject->sources, false, &subject->input.geometry, &subject->input.range))
        abort();
    subject->options = (struct report_options){.rays = rays};
    subject->meshes[0] = (struct report_mesh){.instances = 1,
                                              .primitives = mesh.triangle_count,
                                              .input = subject->input.input,
                                              .sources = subject->sources};
    subject->instances[0] = fixture_instance(NULL);
    subject->instances[0].accelerationStructureReference = 1;
    subject->report = (struct report){.options = &subject->options,
                                      .meshes = subject->meshes,
                                      .mesh_count = 1,
                                      .instance_count = 1,
                                      .instances = subject->instances,
                                      .top = CAPTURE_NONE};
    rays_fit_camera(&subject->report);
}

static void close_subject(struct subject *subject)
{
    aligned_free(subject->meshes[0].tree);
    aligned_free(subject->report.tree);
    fixture_mesh_free(&subject->mesh);
}

/* ---- SAH */

/* A tree may cost less than Embree's, because its nodes are collapsed in the best way. */
static void test_sah(const char *name, struct fixture_mesh mesh)
{
    struct subject subject;
    struct report_built built;
    open_subject(&subject, mesh, 0);
    report_build(&subject.report, BUILDER_BALANCED, 0, &built);
#ifdef HAS_EMBREE
    const double embree = embree_build(&subject.mesh, EMBREE_MEDIUM).sah;
    expect(built.sah <= 1.05 * embree && built.sah >= 0.8 * embree, name, built.sah, embree);
#else
    printf("left out: %s (no Embree)\n", name);
#endif
    close_subject(&subject);
}

/* ---- visits */

/* Whether the ray's line meets a box from its origin on, in double; `is_near` if by little. */
static bool meets(const struct trace_ray *ray, const double low[3], const double high[3],
                  bool *is_near)
{
    double enter = 0, leave = INFINITY;
    for (int i = 0; i < 3; i++) {
        const double a = (low[i] - ray->origin[i]) / ray->direction[i],
                     b = (high[i] - ray->origin[i]) / ray->direction[i];
        enter = fmax(enter, fmin(a, b));
        leave = fmin(leave, fmax(a, b));
    }
    *is_near |= fabs(enter - leave) <= 1e-4 * (1 + fabs(enter));
    return enter <= leave;
}

/* Counts the nodes that are visited if nothing is committed: those whose boxes are met, and those
 * of all nodes above them. */
static void visit(const struct structure_header *tree, uint32_t node, const struct trace_ray *ray,
                  uint64_t counts[2], bool *is_near)
{
    const struct wide_node *at = &structure_nodes(tree)[node];
    counts[0]++;
    for (int lane = 0; lane < (int)NODE_WIDTH; lane++) {
        if (at->child[lane] == CHILD_EMPTY)
            continue;
        double low[3], high[3];
        for (int axis = 0; axis < 3; axis++) {
            low[axis] = at->lower[axis][lane];
            high[axis] = at->upper[axis][lane];
        }
        if (!meets(ray, low, high, is_near))
            continue;
        if (at->child[lane] & LEAF_BIT)
            counts[1] += leaf_count(at->child[lane]);
        else
            visit(tree, at->child[lane], ray, counts, is_near);
    }
}

static void test_visits(void)
{
    enum { RAYS = 2000 };
    struct subject subject;
    struct report_built built;
    struct ray_set sets[RAY_SETS];
    uint64_t compared = 0, different = 0;
    open_subject(&subject, fixture_soup(200, 5), RAYS);
    report_build(&subject.report, BUILDER_BALANCED, 0, &built);
    rays_make(&subject.report, sets);
    for (uint32_t i = 0; i < RAYS; i++) {
        const struct trace_ray *ray = &sets[RAYS_RANDOM].rays[i];
        struct trace_counters work = {0};
        struct trace_scene scene = report_scene(&subject.report, TRACE_ROBUST);
        struct answer answer;
        uint64_t counts[2] = {0};
        bool is_near = false;
        scene.structure = subject.meshes[0].tree;
        scene.counters = &work;
        answer_find(&scene, ray, &answer);
        visit(scene.structure, 0, ray, counts, &is_near);
        compared += !is_near;
        different += !is_near && (work.nodes != counts[0] || work.primitives != counts[1]);
    }
    expect(compared > RAYS / 2 && different == 0, "visits: rays compared, different",
           (double)compared, (double)different);
    rays_free(sets);
    close_subject(&subject);
}

/* ---- wrong answers */

/* The least and the most hits that a ray may have. */
static void find_truth(const struct fixture_mesh *mesh, const struct trace_ray *ray,
                       uint32_t bounds[2])
{
    bounds[0] = bounds[1] = 0;
    for (uint32_t i = 0; i < mesh->triangle_count; i++) {
        float corners[9];
        for (int corner = 0; corner < 3; corner++)
            memcpy(corners + 3 * (size_t)corner,
                   mesh->positions + 3 * (size_t)mesh->indices[3 * (size_t)i + (size_t)corner],
                   3 * sizeof(float));
        const enum exact_class class = exact_triangle(ray, corners).class;
        bounds[0] += class == EXACT_INSIDE;
        bounds[1] += class != EXACT_OUTSIDE;
    }
}

static void test_wrong(const char *name, struct fixture_mesh mesh, uint32_t rays)
{
    struct subject subject;
    struct report_built built;
    struct ray_set sets[RAY_SETS];
    uint64_t exact_wrong = 0, unseen = 0, invented = 0, wrong_at[2] = {0};
    open_subject(&subject, mesh, rays);
    report_build(&subject.report, BUILDER_BALANCED, 0, &built);
    rays_make(&subject.report, sets);
    for (int set = 0; set < RAY_SETS; set++)
        for (uint32_t i = 0; i < sets[set].count; i++) {
            const struct trace_ray *ray = &sets[set].rays[i];
            struct answer answers[3];
            uint32_t bounds[2];
            find_truth(&subject.mesh, ray, bounds);
            for (int accuracy = 0; accuracy < 3; accuracy++) {
                const struct trace_scene scene =
                    report_scene(&subject.report, (enum trace_accuracy)accuracy);
                answer_find(&scene, ray, &answers[accuracy]);
            }
            exact_wrong += answers[2].count < bounds[0] || answers[2].count > bounds[1];
            for (int accuracy = 0; accuracy < 2; accuracy++) {
                struct wrong wrong = {.rays = 0};
                const bool is_wrong = wrong_add(&wrong, &answers[2], &answers[accuracy]),
                           must_be = answers[accuracy].count < bounds[0] ||
                                     answers[accuracy].count > bounds[1];
                wrong_at[accuracy] += is_wrong;
                unseen += must_be && !is_wrong;
                /* Away from edges the number of hits decides; equal numbers may be others. */
                invented += bounds[0] == bounds[1] && !must_be && is_wrong && wrong.nearest == 0 &&
                            wrong.missed == 0;
            }
        }
    expect(exact_wrong == 0, name, (double)exact_wrong, 0);
    expect(unseen == 0 && invented == 0, "  wrong by GMP alone, by the report alone",
           (double)unseen, (double)invented);
    expect(wrong_at[0] > wrong_at[1], "  wrong at fast, at robust", (double)wrong_at[0],
           (double)wrong_at[1]);
    rays_free(sets);
    close_subject(&subject);
}

int main(void)
{
    const float center[3] = {10, -3, 0.5f};
    test_sah("SAH of a sphere, Embree's", fixture_sphere(30, 7, center));
    test_sah("SAH of a terrain, Embree's", fixture_terrain(100));
    test_sah("SAH of a soup, Embree's", fixture_soup(200000, 3));
    test_visits();
    test_wrong("exact wrong by GMP: sphere", fixture_sphere(4, 7, center), 150);
    test_wrong("exact wrong by GMP: terrain", fixture_terrain(10), 150);
    return failures != 0;
}
