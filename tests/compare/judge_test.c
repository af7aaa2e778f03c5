/* SPDX-License-Identifier: Apache-2.0 */
/* The judge by itself: answers that are right are never blamed, and each mistake is called what it
 * is. The answers are made from the reference's own candidates. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "src/compare/judge.h"
#include "subject.h"

enum { RAYS = 4096 };

static struct subject subject;
static struct input_copy *copy;
static struct reference reference;
static struct rays rays;
static struct compare_answer answers[RAYS];

static void open_case(void)
{
    copy = input_copy_create(&subject.input);
    assert_non_null(copy);
    GET(reference_open(copy, &reference));
    GET(rays_create(&reference, RAYS, &rays));
    assert_int_equal(rays.count, RAYS);
    answer_exactly(reference.structure, NULL, rays.rays, RAYS, answers);
}

static void close_case(void)
{
    rays_free(&rays);
    reference_close(&reference);
    input_copy_free(copy);
}

static void open_soup(void)
{
    subject_soup(&subject);
    open_case();
}

static void open_ring(void)
{
    subject_ring(&subject);
    open_case();
}

/* No answer is blamed. Returns how many fans are met once. */
static uint32_t expect_all_right(void)
{
    struct tally tally;
    tally_judge(&tally, &reference, &rays, answers);
    assert_int_equal(tally.all, 0);
    return tally.once;
}

/* Each answer is changed for the worse; all that is said is this difference, and often. */
static void expect(void (*change)(struct compare_answer *answer, uint32_t ray),
                   enum difference difference, enum judge_reason reason)
{
    struct tally tally;
    for (uint32_t i = 0; i < RAYS; i++)
        if (answers[i].closest.kind)
            change(&answers[i], i);
    tally_judge(&tally, &reference, &rays, answers);
    tally_print(&tally, "changed");
    assert_int_equal(tally.all, tally.counts[difference][reason]);
    assert_true(tally.all > RAYS / 20);
    close_case();
}

TEST(test_right_answers)
{
    VkAabbPositionsKHR boxes[BOXES];
    struct tally tally;
    open_soup();
    assert_int_equal(expect_all_right(), 0);
    close_case();
    open_ring();
    assert_true(expect_all_right() > RAYS / 4);
    close_case();
    subject_grid(&subject, boxes);
    boxes[4].minX = NAN;
    open_case();
    expect_all_right();
    for (uint32_t i = 0; i < RAYS; i++) /* more boxes than are met are allowed */
        if (answers[i].candidate_count == 0)
            answers[i].candidates[answers[i].candidate_count++] =
                (struct compare_hit){.kind = COMPARE_HIT | COMPARE_AABB, .primitive = 7};
    expect_all_right();
    for (uint32_t i = 0; i < RAYS; i++) /* but no inactive ones */
        answers[i].candidates[answers[i].candidate_count++] =
            (struct compare_hit){.kind = COMPARE_HIT | COMPARE_AABB, .primitive = 4};
    tally_judge(&tally, &reference, &rays, answers);
    assert_int_equal(tally.counts[DIFFERENCE_EXTRA][REASON_INACTIVE], RAYS);
    close_case();
}

/* A driver that errs by some roundings, and tells the same candidate from both sides of an edge. */
TEST(test_rounded_answers)
{
    open_soup();
    for (uint32_t i = 0; i < RAYS; i++) {
        struct compare_answer *answer = &answers[i];
        for (uint32_t j = 0; j < answer->candidate_count; j++)
            answer->candidates[j].t *= 1 + 0x1p-20f;
        answer->closest.t *= 1 + 0x1p-20f;
        answer->closest.u += 0x1p-20f;
    }
    expect_all_right();
    close_case();
}

/* A change of an answer, whichever the ray. */
#define CHANGE(name, statement)                                                                    \
    static void name(struct compare_answer *answer, uint32_t ray)                                  \
    {                                                                                              \
        statement;                                                                                 \
    }

CHANGE(drop_closest, answer->closest = (struct compare_hit){0})
CHANGE(drop, answer->candidate_count = 0; drop_closest(answer, ray))
CHANGE(shift, answer->closest.t *= 1.01f)
CHANGE(turn, answer->closest.kind ^= COMPARE_FRONT)

/* All of the fan that the ray is aimed at. */
static void add_ring(struct compare_answer *answer, uint32_t ray)
{
    const struct ring *ring = &rays.rings[ray];
    if (!ring_is_hit_once(&reference, &rays, ray))
        return;
    for (uint32_t i = 0; i < ring->count; i++) {
        struct compare_hit hit = answer->closest;
        hit.primitive = ring->primitives[i];
        if (hit.primitive != answer->closest.primitive &&
            rays.aims[ray].at == AIM_VERTEX) /* their barycentrics aren't judged at the boundary */
            answer->candidates[answer->candidate_count++] = hit;
    }
}

static void add_far(struct compare_answer *answer, uint32_t ray)
{
    struct compare_hit hit = answer->closest;
    hit.primitive = (hit.primitive + 50) % SOUP_TRIANGLES;
    for (uint32_t i = 0; i < answer->candidate_count; i++)
        if (answer->candidates[i].primitive == hit.primitive)
            return;
    answer->candidates[answer->candidate_count++] = hit;
}

static void rename_all(struct compare_answer *answer, uint32_t ray)
{
    for (uint32_t i = 0; i < answer->candidate_count; i++)
        answer->candidates[i].primitive += SOUP_TRIANGLES;
    answer->closest.primitive += SOUP_TRIANGLES;
}

/* To the first geometry that the input does not have. */
static void move_all(struct compare_answer *answer, uint32_t ray)
{
    for (uint32_t i = 0; i < answer->candidate_count; i++)
        answer->candidates[i].geometry = reference.geometry_count;
    answer->closest.geometry = reference.geometry_count;
}

static void swap(struct compare_answer *answer, uint32_t ray)
{
    float u = answer->closest.u;
    answer->closest.u = answer->closest.v;
    answer->closest.v = u;
}

TEST(test_mistakes)
{
    static const struct {
        void (*open)(void);
        void (*change)(struct compare_answer *answer, uint32_t ray);
        enum difference difference;
        enum judge_reason reason;
    } mistakes[] = {
        {open_soup, drop, DIFFERENCE_MISSED, REASON_MEETS},
        {open_soup, drop_closest, DIFFERENCE_MISSED, REASON_MEETS},
        {open_ring, add_ring, DIFFERENCE_DOUBLE, REASON_SHARED},
        {open_soup, add_far, DIFFERENCE_EXTRA, REASON_PASSES},
        {open_soup, rename_all, DIFFERENCE_PRIMITIVE, REASON_NO_SUCH},
        {open_soup, move_all, DIFFERENCE_PRIMITIVE, REASON_NO_SUCH},
        {open_soup, shift, DIFFERENCE_DISTANCE, REASON_MEETS},
        {open_soup, turn, DIFFERENCE_FACING, REASON_MEETS},
        {open_soup, swap, DIFFERENCE_BARYCENTRICS, REASON_MEETS},
    };
    for (size_t i = 0; i < sizeof(mistakes) / sizeof(mistakes[0]); i++) {
        mistakes[i].open();
        expect(mistakes[i].change, mistakes[i].difference, mistakes[i].reason);
    }
}

/* ---- instances */

static uint32_t judge_top(const struct top_reference *top, const struct top_rays *top_rays,
                          enum difference expected)
{
    uint32_t count = 0;
    for (uint32_t i = 0; i < top_rays->count; i++) {
        struct judgement judgement;
        if (!top_judge_ray(top, top_rays, i, &answers[i], &judgement))
            continue;
        assert_int_equal(judgement.difference, expected);
        count++;
    }
    return count;
}

TEST(test_instances)
{
    struct top_instance instances[4] = {
        {.given = {.transform.matrix = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}, .mask = 1}},
        {.given = {.transform.matrix = {{0, -2, 0, 50}, {2, 0, 0, 0}, {0, 0, 3, 7}},
                   .mask = 2,
                   .flags = VK_GEOMETRY_INSTANCE_TRIANGLE_FLIP_FACING_BIT_KHR}},
        {.given = {.transform.matrix = {{-1, 0, 0, -20}, {0, 1, 0, 0}, {0, 0, 1, 0}}, .mask = 4}},
        {.given = {.transform.matrix = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}}}, /* no mask */
    };
    struct top_reference top;
    struct top_rays top_rays;
    subject_soup(&subject);
    copy = input_copy_create(&subject.input);
    assert_non_null(copy);
    const struct input_copy *bottoms[1] = {copy};
    const struct top_input input = {
        .count = 4, .bottom_count = 1, .instances = instances, .bottoms = bottoms};
    GET(top_reference_open(&input, &top));
    GET(top_rays_create(&top, RAYS, &top_rays));
    assert_int_equal(top_rays.count, RAYS);
    answer_exactly(top.structure, &top, top_rays.rays, top_rays.count, answers);
    assert_int_equal(judge_top(&top, &top_rays, DIFFERENCE_COUNT), 0);
    for (uint32_t i = 0; i < RAYS; i++)
        answers[i].closest.kind ^= COMPARE_FRONT * (answers[i].closest.kind != 0);
    assert_true(judge_top(&top, &top_rays, DIFFERENCE_FACING) > RAYS / 20);
    answer_exactly(top.structure, &top, top_rays.rays, top_rays.count, answers);
    for (uint32_t i = 0; i < RAYS; i++)
        for (uint32_t j = 0; j < answers[i].candidate_count && j < COMPARE_CANDIDATES; j++)
            answers[i].candidates[j].instance += 4;
    assert_true(judge_top(&top, &top_rays, DIFFERENCE_PRIMITIVE) > RAYS / 4);
    memset(answers, 0, sizeof(answers));
    assert_true(judge_top(&top, &top_rays, DIFFERENCE_MISSED) > RAYS / 20);
    for (uint32_t i = 0; i < RAYS; i++) { /* more candidates than are kept: any may be among them */
        answers[i].candidate_count = COMPARE_CANDIDATES + 1;
        for (uint32_t j = 0; j < COMPARE_CANDIDATES; j++)
            answers[i].candidates[j].instance = 3;
    }
    assert_int_equal(judge_top(&top, &top_rays, DIFFERENCE_COUNT), 0);
    top_rays_free(&top_rays);
    top_reference_close(&top);
    input_copy_free(copy);
}

const char *unit_test_open(const char *argument)
{
    soup_fill();
    return NULL;
}
