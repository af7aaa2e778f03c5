/* SPDX-License-Identifier: Apache-2.0 */
/* Counts differences and describes them. */
#include "src/compare/summary.h"

#include "src/report/words.h"

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
    const struct value geometry = number(aim->geometry), primitive = number(aim->primitive);
    switch (aim->at) {
    case AIM_ANYWHERE:
        text_append(text, "at random");
        return;
    case AIM_PRIMITIVE:
        text_say(text, "aimed at geometry {}, primitive {}", geometry, primitive);
        return;
    case AIM_EDGE:
        text_say(text,
                 "aimed at the edge of geometry {}, primitive {} from its {} vertex to its {}",
                 geometry, primitive, phrase(corners[aim->corner]),
                 phrase(corners[(aim->corner + 1) % 3]));
        return;
    case AIM_VERTEX:
        text_say(text, "aimed at the {} vertex of geometry {}, primitive {}",
                 phrase(corners[aim->corner]), geometry, primitive);
        return;
    case AIM_LIMIT:
        text_say(text, "whose range meets geometry {}, primitive {} in one point", geometry,
                 primitive);
        return;
    }
}

static void append_ray(struct text_buffer *text, const struct compare_ray *ray)
{
    text_say(text, "the ray from ({}, {}, {}) in direction ({}, {}, {}), tmin {}, tmax {}",
             real(ray->origin[0]), real(ray->origin[1]), real(ray->origin[2]),
             real(ray->direction[0]), real(ray->direction[1]), real(ray->direction[2]),
             real(ray->t_min), real(ray->t_max));
}

static struct value side(bool is_front)
{
    return phrase(is_front ? "front" : "back");
}

static void append_reference(struct text_buffer *text, const struct judgement *judgement)
{
    const struct trace_hit *hit = &judgement->reference;
    if (!judgement->has_reference) {
        text_append(text, "Reference: no hit of this primitive");
        return;
    }
    text_say(text, "Reference: geometry {}, primitive {}, t {}", number(hit->geometry),
             number(hit->primitive), real(hit->t));
    if (!hit->is_aabb)
        text_say(text, ", barycentrics {} and {}, {}", real(hit->u), real(hit->v),
                 side(hit->front_face));
}

static void append_driver(struct text_buffer *text, const struct judgement *judgement)
{
    const struct compare_hit *hit = &judgement->driver;
    if (!judgement->has_driver) {
        text_append(text, ". Driver: no hit");
        return;
    }
    text_say(text, ". Driver: geometry {}, primitive {}", number(hit->geometry),
             number(hit->primitive));
    if (hit->instance)
        text_say(text, ", instance {}", number(hit->instance));
    if (!(hit->kind & COMPARE_AABB))
        text_say(text, ", t {}, barycentrics {} and {}, {}", real(hit->t), real(hit->u),
                 real(hit->v), side(hit->kind & COMPARE_FRONT));
}

static void append_ring(struct text_buffer *text, const struct ring *ring, const struct aim *aim)
{
    text_say(text, "the ray meets exactly one of the triangles that share this {} (",
             phrase(aim->at == AIM_EDGE ? "edge" : "vertex"));
    for (uint32_t i = 0; i < ring->count; i++)
        text_say(text, i ? ", {}" : "{}", number(ring->primitives[i]));
    text_append(text, ")");
}

/* Appends the reason of the judgement. */
static void append_reason(struct text_buffer *text, const struct judgement *judgement,
                          const struct ring *ring, const struct aim *aim)
{
    static const char *const reasons[] = {
        [REASON_MEETS] = "the ray meets the primitive, away from its boundary",
        [REASON_SHARED] = "",
        [REASON_PASSES] = "the ray misses the primitive that the driver reports",
        [REASON_BEYOND] = "the primitive that the driver reports lies beyond tmin or tmax, at t {}",
        [REASON_INACTIVE] =
            "there is nothing to decide: the primitive is inactive, because its X is NaN",
        [REASON_NO_SUCH] = "there is nothing to decide: the input has no such primitive",
        [REASON_LIMIT] = "the ray meets the box at tmin or tmax, which counts as a hit",
        [REASON_NOT_FIRST] =
            "the ray meets a nearer triangle, which the driver also has as a candidate",
    };
    text_append(text, ". By exact arithmetic ");
    text_say(text, reasons[judgement->reason], real(judgement->t));
    if (judgement->reason == REASON_SHARED)
        append_ring(text, ring, aim);
    if (judgement->reason == REASON_MEETS && judgement->difference != DIFFERENCE_MISSED)
        text_say(text, ", at t {}, barycentrics {} and {}", real(judgement->t), real(judgement->u),
                 real(judgement->v));
}

void summary_describe(const struct summary *summary, enum difference difference,
                      char out[SUMMARY_TEXT])
{
    const struct judgement *judgement = &summary->found[difference].judgement;
    const struct aim *aim = &summary->found[difference].aim;
    struct text_buffer text;
    text_begin(&text, out, SUMMARY_TEXT);
    if (summary->is_top)
        text_say(&text, "makes a TLAS whose instance {}, geometry {}, ",
                 number(judgement->instance), number(judgement->geometry));
    text_say(&text, "primitive {} {}: ", number(judgement->primitive), phrase(name_of(difference)));
    append_ray(&text, &summary->found[difference].ray);
    text_append(&text, ", ");
    append_aim(&text, aim);
    if (summary->is_top)
        text_say(&text, " of instance {}", number(summary->found[difference].aimed_instance));
    text_append(&text, ". ");
    append_reference(&text, judgement);
    append_driver(&text, judgement);
    append_reason(&text, judgement, &summary->found[difference].ring, aim);
    text_say(&text, ". {} of {} {}", number(summary->found[difference].count),
             count_of(summary->rays, "ray"),
             phrase(summary->found[difference].count == 1 ? "differs" : "differ"));
}
