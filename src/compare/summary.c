/* SPDX-License-Identifier: Apache-2.0 */
/* Counts differences and describes them. */
#include "src/compare/summary.h"

#include <inttypes.h>

#include "src/base/text_buffer.h"

void summary_make(const struct reference *reference, const struct rays *rays,
                  const struct compare_answer *answers, struct summary *summary)
{
    *summary = (struct summary){.rays = rays->count};
    for (uint32_t i = 0; i < rays->count; i++) {
        struct judgement judgement;
        if (!judge_ray(reference, rays, i, &answers[i], &judgement))
            continue;
        if (summary->found[judgement.difference].count++ > 0)
            continue;
        summary->found[judgement.difference].judgement = judgement;
        summary->found[judgement.difference].ray = rays->rays[i];
        summary->found[judgement.difference].aim = rays->aims[i];
        summary->found[judgement.difference].ring = rays->rings[i];
    }
}

void summary_make_top(const struct top_reference *reference, const struct top_rays *rays,
                      const struct compare_answer *answers, struct summary *summary)
{
    *summary = (struct summary){.rays = rays->count, .is_top = true};
    for (uint32_t i = 0; i < rays->count; i++) {
        struct judgement judgement;
        const struct top_aim *aim = &rays->aims[i];
        if (!top_judge_ray(reference, rays, i, &answers[i], &judgement) ||
            summary->found[judgement.difference].count++ > 0)
            continue;
        const struct rays *own = &rays->bottoms[reference->input->instances[aim->instance].bottom];
        summary->found[judgement.difference].judgement = judgement;
        summary->found[judgement.difference].ray = rays->rays[i];
        summary->found[judgement.difference].aim = own->aims[aim->ray];
        summary->found[judgement.difference].ring = own->rings[aim->ray];
        summary->found[judgement.difference].aimed_instance = aim->instance;
    }
}

static const char *name_of(enum difference difference)
{
    switch (difference) {
    case DIFFERENCE_MISSED:
        return "is missed by the driver";
    case DIFFERENCE_DOUBLE:
        return "is reported by the driver together with a neighbour, at the boundary that both "
               "share";
    case DIFFERENCE_EXTRA:
        return "is reported by the driver, but the ray does not meet it";
    case DIFFERENCE_PRIMITIVE:
        return "is reported by the driver in place of another primitive";
    case DIFFERENCE_DISTANCE:
        return "is reported by the driver at another distance";
    case DIFFERENCE_BARYCENTRICS:
        return "is reported by the driver with other barycentrics";
    case DIFFERENCE_FACING:
        return "is reported by the driver from the other side";
    case DIFFERENCE_COUNT:
        break;
    }
    return "";
}

static void append_aim(struct text_buffer *text, const struct aim *aim)
{
    static const char *const corners[] = {"first", "second", "third"};
    switch (aim->at) {
    case AIM_ANYWHERE:
        text_append(text, "at random");
        return;
    case AIM_PRIMITIVE:
        text_append(text, "aimed at geometry %" PRIu32 ", primitive %" PRIu32, aim->geometry,
                    aim->primitive);
        return;
    case AIM_EDGE:
        text_append(text,
                    "aimed at the edge of geometry %" PRIu32 ", primitive %" PRIu32
                    " from its %s vertex to its %s",
                    aim->geometry, aim->primitive, corners[aim->corner],
                    corners[(aim->corner + 1) % 3]);
        return;
    case AIM_VERTEX:
        text_append(text, "aimed at the %s vertex of geometry %" PRIu32 ", primitive %" PRIu32,
                    corners[aim->corner], aim->geometry, aim->primitive);
        return;
    case AIM_LIMIT:
        text_append(text,
                    "whose range meets geometry %" PRIu32 ", primitive %" PRIu32 " in one point",
                    aim->geometry, aim->primitive);
        return;
    }
}

static void append_ray(struct text_buffer *text, const struct compare_ray *ray)
{
    text_append(text,
                "the ray from (%.9g, %.9g, %.9g) in direction (%.9g, %.9g, %.9g), tmin %.9g, ",
                ray->origin[0], ray->origin[1], ray->origin[2], ray->direction[0],
                ray->direction[1], ray->direction[2], ray->t_min);
    text_append(text, "tmax %.9g", ray->t_max);
}

static void append_reference(struct text_buffer *text, const struct judgement *judgement)
{
    const struct trace_hit *hit = &judgement->reference;
    if (!judgement->has_reference) {
        text_append(text, "Reference: no hit of this primitive");
        return;
    }
    text_append(text, "Reference: geometry %" PRIu32 ", primitive %" PRIu32 ", t %.9g",
                hit->geometry, hit->primitive, hit->t);
    if (!hit->is_aabb)
        text_append(text, ", barycentrics %.9g and %.9g, %s", hit->u, hit->v,
                    hit->front_face ? "front" : "back");
}

static void append_driver(struct text_buffer *text, const struct judgement *judgement)
{
    const struct compare_hit *hit = &judgement->driver;
    if (!judgement->has_driver) {
        text_append(text, ". Driver: no hit");
        return;
    }
    text_append(text, ". Driver: geometry %" PRIu32 ", primitive %" PRIu32, hit->geometry,
                hit->primitive);
    if (hit->instance)
        text_append(text, ", instance %" PRIu32, hit->instance);
    if (!(hit->kind & COMPARE_AABB))
        text_append(text, ", t %.9g, barycentrics %.9g and %.9g, %s", hit->t, hit->u, hit->v,
                    hit->kind & COMPARE_FRONT ? "front" : "back");
}

static void append_ring(struct text_buffer *text, const struct ring *ring, const struct aim *aim)
{
    text_append(text, "the ray meets exactly one of the triangles that share this %s (",
                aim->at == AIM_EDGE ? "edge" : "vertex");
    for (uint32_t i = 0; i < ring->count; i++)
        text_append(text, "%s%" PRIu32, i ? ", " : "", ring->primitives[i]);
    text_append(text, ")");
}

/* Appends the reason of the judgement. */
static void append_reason(struct text_buffer *text, const struct judgement *judgement,
                          const struct ring *ring, const struct aim *aim)
{
    text_append(text, ". By exact arithmetic ");
    switch (judgement->reason) {
    case REASON_MEETS:
        text_append(text, "the ray meets the primitive, away from its boundary");
        if (judgement->difference != DIFFERENCE_MISSED)
            text_append(text, ", at t %.9g, barycentrics %.9g and %.9g", judgement->t, judgement->u,
                        judgement->v);
        return;
    case REASON_SHARED:
        append_ring(text, ring, aim);
        return;
    case REASON_PASSES:
        text_append(text, "the ray misses the primitive that the driver reports");
        return;
    case REASON_BEYOND:
        text_append(text,
                    "the primitive that the driver reports lies beyond tmin or tmax, at t %.9g",
                    judgement->t);
        return;
    case REASON_INACTIVE:
        text_append(text,
                    "there is nothing to decide: the primitive is inactive, because its X is NaN");
        return;
    case REASON_NO_SUCH:
        text_append(text, "there is nothing to decide: the input has no such primitive");
        return;
    case REASON_LIMIT:
        text_append(text, "the ray meets the box at tmin or tmax, which counts as a hit");
        return;
    case REASON_NOT_FIRST:
        text_append(text,
                    "the ray meets a nearer triangle, which the driver also has as a candidate");
        return;
    }
}

void summary_describe(const struct summary *summary, enum difference difference,
                      char out[SUMMARY_TEXT])
{
    const struct judgement *judgement = &summary->found[difference].judgement;
    const struct aim *aim = &summary->found[difference].aim;
    struct text_buffer text;
    text_begin(&text, out, SUMMARY_TEXT);
    if (summary->is_top)
        text_append(&text, "makes a TLAS whose instance %" PRIu32 ", geometry %" PRIu32 ", ",
                    judgement->instance, judgement->geometry);
    text_append(&text, "primitive %" PRIu32 " %s: ", judgement->primitive, name_of(difference));
    append_ray(&text, &summary->found[difference].ray);
    text_append(&text, ", ");
    append_aim(&text, aim);
    if (summary->is_top)
        text_append(&text, " of instance %" PRIu32, summary->found[difference].aimed_instance);
    text_append(&text, ". ");
    append_reference(&text, judgement);
    append_driver(&text, judgement);
    append_reason(&text, judgement, &summary->found[difference].ring, aim);
    text_append(&text, ". %" PRIu32 " of ", summary->found[difference].count);
    text_append_count(&text, summary->rays, "ray");
    text_append(&text, summary->found[difference].count == 1 ? " differs" : " differ");
}
