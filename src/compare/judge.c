/* SPDX-License-Identifier: Apache-2.0 */
/* Judges a driver's answer for a ray. */
#include "src/compare/judge.h"

#include <math.h>

enum { EXACT_MAX = 64 };

struct ray_case {
    const struct reference *reference;
    const struct rays *rays;
    uint32_t ray;
    const struct compare_ray *line;
    const struct compare_answer *answer;
    struct trace_hit exact[EXACT_MAX]; /* all hits of the ray by exact arithmetic */
    uint32_t exact_count;
    bool has_more; /* there are more hits than `exact` holds */
    uint32_t candidate_count;
    bool is_whole; /* the answer holds all candidates of the driver */
    struct judgement *judgement;
};

/* ---- the hits of the reference and of the driver */

static enum trace_answer keep_exact(void *context, struct trace_hit *candidate)
{
    struct ray_case *c = context;
    if (c->exact_count == EXACT_MAX) {
        c->has_more = true;
        return TRACE_STOP;
    }
    c->exact[c->exact_count++] = *candidate;
    return TRACE_IGNORE;
}

static void trace(struct ray_case *c)
{
    const struct trace_scene scene = {.structure = c->reference->structure,
                                      .accuracy = TRACE_EXACT};
    struct trace_ray ray = {.t_min = c->line->t_min, .t_max = c->line->t_max, .cull_mask = 0xff};
    const struct trace_visitor visitor = {keep_exact, c};
    for (int i = 0; i < 3; i++) {
        ray.origin[i] = c->line->origin[i];
        ray.direction[i] = c->line->direction[i];
    }
    trace_candidates(&scene, &ray, &visitor);
}

static const struct trace_hit *find_exact(const struct ray_case *c, uint32_t geometry,
                                          uint32_t primitive)
{
    for (uint32_t i = 0; i < c->exact_count; i++)
        if (c->exact[i].geometry == geometry && c->exact[i].primitive == primitive)
            return &c->exact[i];
    return NULL;
}

static const struct compare_hit *find_driver(const struct ray_case *c, uint32_t geometry,
                                             uint32_t primitive)
{
    for (uint32_t i = 0; i < c->candidate_count; i++) {
        const struct compare_hit *hit = &c->answer->candidates[i];
        if (hit->geometry == geometry && hit->primitive == primitive && hit->instance == 0)
            return hit;
    }
    return NULL;
}

bool judgement_outweighs(const struct judgement *judgement, const struct judgement *other)
{
    /* PRIMITIVE has the greatest weight: its two halves alone would be MISSED and EXTRA. */
    static const unsigned char weights[DIFFERENCE_COUNT + 1] = {
        [DIFFERENCE_PRIMITIVE] = 7, [DIFFERENCE_MISSED] = 6,   [DIFFERENCE_DOUBLE] = 5,
        [DIFFERENCE_EXTRA] = 4,     [DIFFERENCE_DISTANCE] = 3, [DIFFERENCE_BARYCENTRICS] = 2,
        [DIFFERENCE_FACING] = 1,
    };
    return weights[judgement->difference] > weights[other->difference];
}

static void conclude(const struct ray_case *c, const struct judgement *judgement)
{
    if (judgement_outweighs(judgement, c->judgement))
        *c->judgement = *judgement;
}

/* ---- hits that the driver has */

static void conclude_hit(const struct ray_case *c, enum difference difference,
                         enum judge_reason reason, const struct compare_hit *hit,
                         const struct placing *placing)
{
    const struct trace_hit *exact = find_exact(c, hit->geometry, hit->primitive);
    struct judgement judgement = {
        .difference = difference,
        .reason = reason,
        .geometry = hit->geometry,
        .primitive = hit->primitive,
        .has_driver = true,
        .driver = *hit,
        .has_reference = exact,
    };
    if (exact)
        judgement.reference = *exact;
    if (placing) {
        judgement.t = placing->t;
        judgement.u = placing->u;
        judgement.v = placing->v;
    }
    conclude(c, &judgement);
}

static bool differs(double a, double b, double tolerance)
{
    return !(fabs(a - b) <= tolerance);
}

static void judge_position(const struct ray_case *c, const struct compare_hit *hit,
                           const struct placing *placing)
{
    const struct trace_hit *exact = find_exact(c, hit->geometry, hit->primitive);
    if (!placing->is_well_formed)
        return;
    if (placing->side == PLACING_OUT)
        conclude_hit(c, DIFFERENCE_EXTRA, REASON_PASSES, hit, placing);
    else if (placing->t < c->line->t_min - placing->t_tolerance ||
             placing->t > c->line->t_max + placing->t_tolerance)
        conclude_hit(c, DIFFERENCE_EXTRA, REASON_BEYOND, hit, placing);
    else if (differs(hit->t, placing->t, placing->t_tolerance))
        conclude_hit(c, DIFFERENCE_DISTANCE, REASON_MEETS, hit, placing);
    else if (placing->side == PLACING_IN && (differs(hit->u, placing->u, placing->tolerance) ||
                                             differs(hit->v, placing->v, placing->tolerance)))
        conclude_hit(c, DIFFERENCE_BARYCENTRICS, REASON_MEETS, hit, placing);
    else if (placing->side == PLACING_IN && exact &&
             exact->front_face != ((hit->kind & COMPARE_FRONT) != 0))
        conclude_hit(c, DIFFERENCE_FACING, REASON_MEETS, hit, placing);
}

static bool primitive_exists(const struct reference *reference, const struct compare_hit *hit)
{
    return hit->instance == 0 && hit->geometry < reference->geometry_count &&
           hit->primitive < reference->sources[hit->geometry].count;
}

static void judge_hit(const struct ray_case *c, const struct compare_hit *hit)
{
    const struct reference *reference = c->reference;
    struct triangle_record triangle;
    struct aabb_record box;
    struct placing placing;
    if (!primitive_exists(reference, hit)) {
        conclude_hit(c, DIFFERENCE_PRIMITIVE, REASON_NO_SUCH, hit, NULL);
        return;
    }
    enum source_state state =
        reference->is_aabbs
            ? reference_aabb(reference, hit->geometry, hit->primitive, &box)
            : reference_triangle(reference, hit->geometry, hit->primitive, &triangle);
    if (state == SOURCE_INACTIVE)
        conclude_hit(c, DIFFERENCE_EXTRA, REASON_INACTIVE, hit, NULL);
    if (state != SOURCE_ACTIVE || reference->is_aabbs)
        return;
    placing_of_triangle(c->line, &triangle, c->rays->scale, &placing);
    judge_position(c, hit, &placing);
}

static void judge_hits(const struct ray_case *c)
{
    const struct compare_hit *closest = &c->answer->closest;
    for (uint32_t i = 0; i < c->candidate_count; i++)
        judge_hit(c, &c->answer->candidates[i]);
    if (closest->kind)
        judge_hit(c, closest);
    for (uint32_t i = 0; i < c->candidate_count && closest->kind; i++) {
        const struct compare_hit *hit = &c->answer->candidates[i];
        if (!(hit->kind & COMPARE_AABB) &&
            hit->t < closest->t - 2 * PLACING_TOLERANCE * fabsf(closest->t) &&
            find_exact(c, hit->geometry, hit->primitive)) {
            conclude_hit(c, DIFFERENCE_DISTANCE, REASON_NOT_FIRST, closest, NULL);
            return;
        }
    }
}

/* ---- hits that the driver must have */

/* Finds a hit of the driver at this distance whose primitive the ray does not hit. */
static const struct compare_hit *find_misnamed(const struct ray_case *c, double t, double tolerance)
{
    for (uint32_t i = 0; i < c->candidate_count; i++) {
        const struct compare_hit *hit = &c->answer->candidates[i];
        if (!differs(hit->t, t, tolerance) && !find_exact(c, hit->geometry, hit->primitive))
            return hit;
    }
    return NULL;
}

static void conclude_missed(const struct ray_case *c, const struct trace_hit *exact,
                            enum judge_reason reason)
{
    struct judgement judgement = {
        .difference = DIFFERENCE_MISSED,
        .reason = reason,
        .geometry = exact->geometry,
        .primitive = exact->primitive,
        .has_reference = true,
        .reference = *exact,
        .has_driver = c->answer->closest.kind,
        .driver = c->answer->closest,
    };
    conclude(c, &judgement);
}

static void judge_exact_triangle(const struct ray_case *c, const struct trace_hit *exact)
{
    struct triangle_record triangle;
    struct placing placing;
    if (reference_triangle(c->reference, exact->geometry, exact->primitive, &triangle) !=
        SOURCE_ACTIVE)
        return;
    placing_of_triangle(c->line, &triangle, c->rays->scale, &placing);
    if (placing.side != PLACING_IN)
        return;
    if (!find_driver(c, exact->geometry, exact->primitive)) {
        const struct compare_hit *other = find_misnamed(c, placing.t, placing.t_tolerance);
        if (other)
            conclude_hit(c, DIFFERENCE_PRIMITIVE, REASON_PASSES, other, &placing);
        else
            conclude_missed(c, exact, REASON_MEETS);
    } else if (!c->answer->closest.kind && !(c->answer->flags & COMPARE_ELSEWHERE)) {
        conclude_missed(c, exact, REASON_MEETS);
    }
}

static void judge_exact_box(const struct ray_case *c, const struct trace_hit *exact)
{
    struct aabb_record box;
    bool is_limit = c->rays->aims[c->ray].at == AIM_LIMIT;
    if (!find_driver(c, exact->geometry, exact->primitive) &&
        reference_aabb(c->reference, exact->geometry, exact->primitive, &box) == SOURCE_ACTIVE &&
        placing_meets_box(c->line, &box, c->rays->scale, c->rays->is_moved))
        conclude_missed(c, exact, is_limit ? REASON_LIMIT : REASON_MEETS);
}

/* The driver must have exactly one of the triangles around a shared edge or vertex. */
static void judge_ring(const struct ray_case *c)
{
    const struct ring *ring = &c->rays->rings[c->ray];
    const struct trace_hit *exact = NULL;
    const struct compare_hit *first = NULL, *second = NULL;
    for (uint32_t i = 0; i < ring->count; i++) {
        const struct trace_hit *hit = find_exact(c, ring->geometry, ring->primitives[i]);
        const struct compare_hit *candidate = find_driver(c, ring->geometry, ring->primitives[i]);
        if (hit && exact)
            return;
        exact = hit ? hit : exact;
        second = first && candidate ? candidate : second;
        first = first ? first : candidate;
    }
    if (!exact || !ring_is_hit_once(c->reference, c->rays, c->ray))
        return;
    if (second) {
        struct judgement judgement = {
            .difference = DIFFERENCE_DOUBLE,
            .reason = REASON_SHARED,
            .geometry = second->geometry,
            .primitive = second->primitive,
            .has_reference = true,
            .reference = *exact,
            .has_driver = true,
            .driver = *first,
        };
        conclude(c, &judgement);
    } else if (!first && c->is_whole) {
        conclude_missed(c, exact, REASON_SHARED);
    }
}

bool judge_ray(const struct reference *reference, const struct rays *rays, uint32_t ray,
               const struct compare_answer *answer, struct judgement *judgement)
{
    struct ray_case c = {
        .reference = reference,
        .rays = rays,
        .ray = ray,
        .line = &rays->rays[ray],
        .answer = answer,
        .is_whole = answer->candidate_count <= COMPARE_CANDIDATES && !(answer->flags & COMPARE_CUT),
        .judgement = judgement,
    };
    c.candidate_count =
        answer->candidate_count < COMPARE_CANDIDATES ? answer->candidate_count : COMPARE_CANDIDATES;
    *judgement = (struct judgement){.difference = DIFFERENCE_COUNT};
    trace(&c);
    if (c.has_more)
        return false;
    judge_hits(&c);
    for (uint32_t i = 0; i < c.exact_count && c.is_whole; i++)
        (reference->is_aabbs ? judge_exact_box : judge_exact_triangle)(&c, &c.exact[i]);
    judge_ring(&c);
    return judgement->difference != DIFFERENCE_COUNT;
}
