/* SPDX-License-Identifier: Apache-2.0 */
/* Closest hits at accuracy exact beside Embree's robust ones: the same triangle, and t within 4
 * ulp. Each difference is printed and explained by exact arithmetic; one that shows us wrong is a
 * failure. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "embree.h"
#include "exact.h"

#define ULPS 4

enum verdict {
    TIE,              /* both are hit at the same t: a shared edge or vertex, or duplicates */
    EMBREE_MISSED,    /* a nearer triangle, or any */
    EMBREE_BEYOND,    /* hits a triangle that the ray doesn't meet */
    EMBREE_IMPRECISE, /* ours is the nearest float of the exact t, or next to it */
    OURS_WRONG,
    VERDICTS,
};
static const char *const verdict_names[VERDICTS] = {"equal t", "Embree missed the nearer one",
                                                    "Embree hit where the ray doesn't",
                                                    "Embree's t is off", "OURS IS WRONG"};

struct answer {
    bool is_hit;
    struct trace_hit hit;
    struct exact_hit truth; /* about the triangle that was hit */
};

static int64_t ulps_between(float a, float b)
{
    int32_t i, j;
    memcpy(&i, &a, sizeof(i));
    memcpy(&j, &b, sizeof(j));
    return llabs((int64_t)i - j);
}

static void judge(const struct fixture_mesh *mesh, const struct trace_ray *ray,
                  struct answer *answer)
{
    float corners[9];
    if (!answer->is_hit)
        return;
    for (uint32_t i = 0; i < 3; i++)
        memcpy(corners + 3 * (size_t)i,
               mesh->positions + 3 * (size_t)mesh->indices[3 * answer->hit.primitive + i], 12);
    answer->truth = exact_triangle(ray, corners);
}

/* Ours is the nearest, and is there: what else is found can only be a tie or a mistake. */
static enum verdict explain(const struct answer *ours, const struct answer *theirs)
{
    bool ours_is_there = ours->is_hit && ours->truth.class != EXACT_OUTSIDE;
    bool theirs_is_there = theirs->is_hit && theirs->truth.class != EXACT_OUTSIDE;
    if (ours->is_hit && !ours_is_there)
        return OURS_WRONG;
    if (theirs->is_hit && !theirs_is_there)
        return EMBREE_BEYOND;
    if (!ours->is_hit) /* on an open boundary either is right */
        return theirs->truth.class == EXACT_BOUNDARY ? TIE : OURS_WRONG;
    if (!theirs->is_hit)
        return EMBREE_MISSED;
    if (ours->hit.primitive == theirs->hit.primitive)
        return ulps_between(ours->hit.t, (float)ours->truth.t) <= 1 ? EMBREE_IMPRECISE : OURS_WRONG;
    if (ulps_between((float)ours->truth.t, (float)theirs->truth.t) <= 1)
        return TIE;
    return ours->truth.t < theirs->truth.t ? EMBREE_MISSED : OURS_WRONG;
}

static void print_answer(const char *who, const struct answer *answer)
{
    if (answer->is_hit)
        printf("  %s: triangle %u at %.9g (exactly %.17g)", who, answer->hit.primitive,
               answer->hit.t, answer->truth.t);
    else
        printf("  %s: none", who);
}

static void print_difference(enum verdict verdict, const struct trace_ray *ray,
                             const struct answer *ours, const struct answer *theirs)
{
    printf("    %s: ray (%.9g %.9g %.9g) + t (%.9g %.9g %.9g)", verdict_names[verdict],
           ray->origin[0], ray->origin[1], ray->origin[2], ray->direction[0], ray->direction[1],
           ray->direction[2]);
    print_answer("ours", ours);
    print_answer("Embree", theirs);
    printf("\n");
}

static bool agrees(const struct answer *ours, const struct answer *theirs)
{
    if (!ours->is_hit || !theirs->is_hit)
        return ours->is_hit == theirs->is_hit;
    return ours->hit.primitive == theirs->hit.primitive &&
           ulps_between(ours->hit.t, theirs->hit.t) <= ULPS;
}

static uint32_t compare(const char *path, const struct fixture_mesh *mesh, uint32_t rays)
{
    struct fixture_input input;
    fixture_input_mesh(&input, mesh);
    void *structure = fixture_build(&input.input, NULL);
    struct embree_scene *scene = embree_scene_create(mesh, EMBREE_MEDIUM);
    uint32_t counts[VERDICTS] = {0}, hits = 0, same = 0;
    uint64_t random = 88172645463325252u;
    float lower[3], upper[3];
    builder_bounds(structure, lower, upper);
    for (uint32_t i = 0; i < rays; i++) {
        struct trace_ray ray = model_random_ray(lower, upper, 0.2f, 0, &random);
        struct answer ours = {0}, theirs = {0};
        ours.is_hit = fixture_trace(structure, TRACE_EXACT, &ray, &ours.hit);
        theirs.is_hit = embree_trace(scene, &ray, &theirs.hit);
        hits += ours.is_hit;
        if (agrees(&ours, &theirs)) {
            same++;
            continue;
        }
        judge(mesh, &ray, &ours);
        judge(mesh, &ray, &theirs);
        enum verdict verdict = explain(&ours, &theirs);
        counts[verdict]++;
        print_difference(verdict, &ray, &ours, &theirs);
    }
    printf("%s: %u triangles, %u rays, %u hit, %u the same", path, mesh->triangle_count, rays, hits,
           same);
    for (int i = 0; i < VERDICTS; i++)
        if (counts[i] > 0)
            printf(", %u %s", counts[i], verdict_names[i]);
    printf("\n");
    embree_scene_destroy(scene);
    free(structure);
    return counts[OURS_WRONG];
}

int main(int count, char **arguments)
{
    static const char *const paths[] = {
        "/usr/share/glmark2/models/bunny.obj", "/usr/share/glmark2/models/horse.3ds",
        "/usr/share/glmark2/models/cat.3ds", "/usr/share/glmark2/models/asteroid-high.3ds"};
    uint32_t rays = count > 1 ? (uint32_t)strtoul(arguments[1], NULL, 10) : 1000000, wrong = 0;
    for (size_t i = 0; i < sizeof(paths) / sizeof(paths[0]); i++) {
        struct fixture_mesh mesh;
        if (!model_load(paths[i], &mesh))
            return 2;
        wrong += compare(paths[i], &mesh, rays);
        fixture_mesh_free(&mesh);
    }
    return wrong > 0;
}
