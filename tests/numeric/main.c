/* SPDX-License-Identifier: Apache-2.0 */
/* Runs the hard cases and says how much of each was wrong at each accuracy, and how much may be. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "cases.h"

enum { CASES = 74 }; /* by number, from 1 on */

static const char *const quality_names[] = {"fast", "balanced", "high"};
static const char *const accuracy_names[] = {"fast", "robust", "exact"};

struct setting setting;
struct builder_report report;
static const struct numeric_case *cases[CASES + 1];
static const struct numeric_case *current;
static uint32_t wrong, checked;

void case_register(const struct numeric_case *one)
{
    if (one->number > CASES || cases[one->number])
        abort();
    cases[one->number] = one;
}

static uint32_t allowance(const struct numeric_case *one, enum trace_accuracy accuracy)
{
    return accuracy == TRACE_EXACT ? 0 : one->may_be_wrong[accuracy];
}

void expect(bool is_so, const char *what)
{
    checked++;
    if (is_so)
        return;
    if (wrong++ == 0 && allowance(current, setting.accuracy) == 0)
        printf("case %d (%s) at quality %s, accuracy %s, %u threads: not so: %s\n", current->number,
               current->name, quality_names[setting.quality], accuracy_names[setting.accuracy],
               setting.threads, what);
}

void *case_build(struct fixture_input *input)
{
    input->input.quality = setting.quality;
    input->input.threads = setting.threads;
    void *structure = fixture_build(&input->input, &report);
    if (!structure) {
        printf("case %d (%s): no build\n", current->number, current->name);
        exit(1);
    }
    return structure;
}

bool case_fails(struct fixture_input *input)
{
    return !fixture_build(&input->input, &report);
}

void *case_triangles(const float *corners, uint32_t count)
{
    INPUT(triangles, input, corners, count);
    return case_build(&input);
}

void *case_mesh(const struct fixture_mesh *mesh)
{
    INPUT(mesh, input, mesh);
    return case_build(&input);
}

void *case_instances(const VkAccelerationStructureInstanceKHR *instances, uint32_t count)
{
    INPUT(instances, input, instances, count);
    return case_build(&input);
}

bool case_trace(const void *structure, struct trace_ray ray, struct trace_hit *hit)
{
    return fixture_trace(structure, setting.accuracy, &ray, hit);
}

bool case_meets(const void *structure, struct trace_ray ray)
{
    struct trace_hit hit;
    return case_trace(structure, ray, &hit);
}

struct trace_hit case_closest(const void *structure, struct trace_ray ray)
{
    struct trace_hit hit;
    if (case_trace(structure, ray, &hit))
        return hit;
    return (struct trace_hit){
        .t = -1, .geometry = UINT32_MAX, .primitive = UINT32_MAX, .instance = UINT32_MAX};
}

struct fixture_hits case_hits(const void *structure, struct trace_ray ray)
{
    struct fixture_hits hits;
    fixture_trace_all(structure, setting.accuracy, &ray, &hits);
    return hits;
}

uint32_t case_count(const void *structure, struct trace_ray ray)
{
    return case_hits(structure, ray).count;
}

void case_uniform(uint64_t *random, float low, float high, float to[3])
{
    for (int i = 0; i < 3; i++)
        to[i] = fixture_uniform(random, low, high);
}

struct trace_ray case_ray_down(float x, float y)
{
    return fixture_ray(x, y, 1, 0, 0, -1);
}

struct trace_ray case_ray_to(const float origin[3], const float target[3])
{
    return fixture_ray(origin[0], origin[1], origin[2], target[0] - origin[0],
                       target[1] - origin[1], target[2] - origin[2]);
}

struct trace_ray case_between(struct trace_ray ray, float t_min, float t_max)
{
    ray.t_min = t_min;
    ray.t_max = t_max;
    return ray;
}

struct trace_ray case_ray_into(const float corners[9], const float origin[3], uint64_t *random)
{
    struct trace_ray ray = fixture_ray(origin[0], origin[1], origin[2], 0, 0, 0);
    double a = fixture_uniform(random, 0, 1), b = fixture_uniform(random, 0, 1);
    if (a + b > 1) {
        a = 1 - a;
        b = 1 - b;
    }
    for (int i = 0; i < 3; i++) {
        double at = corners[i] * (1 - a - b) + corners[3 + i] * a + corners[6 + i] * b;
        ray.direction[i] = (float)(at - origin[i]);
    }
    return ray;
}

/* Barycentrics and t are computed in float at accuracies fast and robust. */
static bool is_near(double t, double truth, enum trace_accuracy accuracy)
{
    double bound = accuracy == TRACE_EXACT ? 0x1p-22 : 1e-3;
    return fabs(t - truth) <= bound * fabs(truth) + 0x1p-149;
}

const struct trace_hit *case_find_hit(const struct fixture_hits *hits, uint32_t primitive)
{
    for (uint32_t i = 0; i < hits->count && i < 64; i++)
        if (hits->hits[i].primitive == primitive)
            return &hits->hits[i];
    return NULL;
}

void case_expect_same_bounds(const void *structure, const void *other)
{
    float bounds[2][6];
    EXPECT(builder_bounds(structure, bounds[0], bounds[0] + 3) &&
           builder_bounds(other, bounds[1], bounds[1] + 3));
    for (int i = 0; i < 6; i++)
        EXPECT(bounds[0][i] == bounds[1][i]);
}

uint32_t case_check_ray(const void *structure, const float *corners, uint32_t count,
                        struct trace_ray ray)
{
    const struct fixture_hits hits = case_hits(structure, ray);
    struct trace_hit nearest;
    double least_inside = INFINITY;
    for (uint32_t i = 0; i < count; i++) {
        struct exact_hit truth = exact_triangle(&ray, corners + 9 * (size_t)i);
        const struct trace_hit *hit = case_find_hit(&hits, i);
        if (truth.class == EXACT_INSIDE)
            least_inside = fmin(least_inside, truth.t);
        if (truth.class == EXACT_BOUNDARY)
            continue;
        expect((hit != NULL) == (truth.class == EXACT_INSIDE), "hit where brute force hits");
        if (hit && truth.class == EXACT_INSIDE) {
            expect(is_near(hit->t, truth.t, setting.accuracy), "t as by brute force");
            expect(hit->front_face == truth.front_face, "facing as by brute force");
        }
    }
    bool is_hit = case_trace(structure, ray, &nearest);
    expect(is_hit == (hits.count > 0), "closest hit where there are candidates");
    if (is_hit && !isinf(least_inside))
        expect(nearest.t <= least_inside * (1 + 1e-3), "the closest hit is the closest");
    return hits.count;
}

void case_check_rays(const float *corners, uint32_t count, float far, uint32_t rays)
{
    void *structure = case_triangles(corners, count);
    uint64_t random = 88172645463325252u;
    for (uint32_t i = 0; i < rays; i++) {
        const float *target = corners + 9 * (fixture_random(&random) % count);
        float origin[3];
        case_uniform(&random, -far, far, origin);
        for (int axis = 0; axis < 3; axis++)
            origin[axis] += target[axis];
        struct trace_ray ray = case_ray_into(target, origin, &random);
        case_check_ray(structure, corners, count, ray);
    }
}

/* True where no more was wrong than may be, at any setting. */
static bool run_case(const struct numeric_case *one)
{
    bool is_good = true;
    uint32_t all_wrong[3] = {0}, all_checked[3] = {0};
    current = one;
    for (int quality = BUILDER_FAST; quality <= BUILDER_HIGH; quality++)
        for (int accuracy = TRACE_FAST; accuracy <= TRACE_EXACT; accuracy++)
            for (uint32_t threads = 1; threads <= 2; threads++) {
                setting = (struct setting){(enum builder_quality)quality,
                                           (enum trace_accuracy)accuracy, threads};
                wrong = checked = 0;
                fixture_scope_begin();
                one->run();
                fixture_scope_end();
                is_good &= wrong * 1000.0 <= (double)checked * allowance(one, accuracy);
                all_wrong[accuracy] += wrong;
                all_checked[accuracy] += checked;
            }
    printf("case %2d %-6s", one->number, is_good ? "right" : "WRONG");
    for (int accuracy = TRACE_FAST; accuracy <= TRACE_EXACT; accuracy++)
        printf(" %s %u of %u (may %u in 1,000) ", accuracy_names[accuracy], all_wrong[accuracy],
               all_checked[accuracy], allowance(one, accuracy));
    printf(" %s\n", one->name);
    return is_good;
}

int main(int count, char **arguments)
{
    int only = count > 1 ? atoi(arguments[1]) : 0, right = 0, all = 0;
    bool is_complete = true;
    for (int i = 1; i <= CASES; i++) {
        is_complete &= cases[i] != NULL;
        if (!cases[i] || (only != 0 && only != i))
            continue;
        right += run_case(cases[i]);
        all++;
    }
    printf("numeric: %d of %d cases right%s\n", right, all, is_complete ? "" : ", some missing");
    return right == all && is_complete ? 0 : 1;
}
