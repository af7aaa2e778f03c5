/* SPDX-License-Identifier: Apache-2.0 */
/* Comparing a driver's rays with the reference: inputs, where rays are placed, and how hits are
 * judged. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "src/compare/judge.h"
#include "src/compare/rays.h"
#include "subject.h"
#include "tests/fixture/scarce_memory.h"
#include "tests/unit/unit_test.h"

/* ---- the judge by itself: answers that are right are never blamed, and each mistake is called
 * what it is. The answers are made from the reference's own candidates */

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

/* ---- where rays lie to triangles and boxes, in numbers that are exact */

/* A right triangle of side 4 in the plane z = 8. */
static const struct triangle_record triangle = {.a = {0, 0, 8}, .b = {4, 0, 8}, .c = {0, 4, 8}};

static struct placing place(struct compare_ray ray, double scale)
{
    struct placing placing;
    placing_of_triangle(&ray, &triangle, scale, &placing);
    return placing;
}

TEST(test_numbers)
{
    const struct placing up = place((struct compare_ray){{1, 2, 0}, 0, {0, 0, 2}, 100}, 0);
    assert_true(up.is_well_formed && up.is_within && !up.is_front);
    assert_true(up.side == PLACING_IN);
    assert_true(up.t == 4 && up.u == 0.25 && up.v == 0.5);
    assert_true(up.margin == 8 * PLACING_TOLERANCE); /* z is the largest coordinate */
    assert_true(up.t_tolerance == 2 * up.margin / 2 + 4 * PLACING_TOLERANCE);
    assert_true(up.tolerance == 2 * up.margin * 0.5 + PLACING_TOLERANCE);
    assert_true(up.inside[1] == 1 && up.inside[2] == 2 && up.height[1] == 4 && up.height[2] == 4);
    assert_true(fabs(up.inside[0] - sqrt(0.5)) < 1e-12 && fabs(up.height[0] - sqrt(8)) < 1e-12);

    const struct placing down = place((struct compare_ray){{1, 2, 9}, 0, {0, 0, -1}, 100}, 64);
    assert_true(down.is_front && down.t == 1 && down.margin == 64 * PLACING_TOLERANCE);
    const struct placing distant =
        place((struct compare_ray){{1, -40, 8.5f}, 0, {0, 41, -1}, 100}, 0);
    assert_true(distant.margin == 40 * PLACING_TOLERANCE);
    const struct placing adjacent =
        place((struct compare_ray){{1, 1, 7.5f}, 0, {0, 0, 1}, 100}, 8.5);
    assert_true(adjacent.margin == 8.5 * PLACING_TOLERANCE);
}

TEST(test_sides)
{
    const float most = 100;
    const struct {
        struct compare_ray ray;
        enum placing_side side;
        bool is_well_formed, is_within;
    } cases[] = {
        {{{1, 1, 0}, 0, {0, 0, 1}, most}, PLACING_IN, true, true},
        {{{5, 1, 0}, 0, {0, 0, 1}, most}, PLACING_OUT, true, true},
        {{{-1, 1, 0}, 0, {0, 0, 1}, most}, PLACING_OUT, true, true},
        {{{1, -1, 0}, 0, {0, 0, 1}, most}, PLACING_OUT, true, true},
        {{{3, 3, 0}, 0, {0, 0, 1}, most}, PLACING_OUT, true, true},
        {{{2, 2, 0}, 0, {0, 0, 1}, most}, PLACING_UNDECIDED, true, true}, /* on an edge */
        {{{0, 0, 0}, 0, {0, 0, 1}, most}, PLACING_UNDECIDED, true, true}, /* at a vertex */
        {{{0x1p-14f, 1, 0}, 0, {0, 0, 1}, most}, PLACING_UNDECIDED, true, true},
        {{{0x1p-12f, 1, 0}, 0, {0, 0, 1}, most}, PLACING_IN, true, true},
        {{{-0x1p-14f, 1, 0}, 0, {0, 0, 1}, most}, PLACING_UNDECIDED, true, true},
        {{{-0x1p-12f, 1, 0}, 0, {0, 0, 1}, most}, PLACING_OUT, true, true},
        {{{1, 1, 0}, 0, {0, 0, 1}, 8}, PLACING_UNDECIDED, true, false}, /* ends there */
        {{{1, 1, 0}, 8, {0, 0, 1}, most}, PLACING_UNDECIDED, true, false},
        {{{1, 1, 0}, 0, {0, 0, 1}, 8.01f}, PLACING_IN, true, true},
        {{{1, 1, 0}, 7.99f, {0, 0, 1}, most}, PLACING_IN, true, true},
        {{{5, 1, 0}, 0, {0, 0, 1}, 7}, PLACING_OUT, true, false},
        {{{1, 1, 9}, 0, {0, 0, 1}, most}, PLACING_UNDECIDED, true, false},  /* behind */
        {{{1, 1, 0}, 0, {1, 0, 0}, most}, PLACING_UNDECIDED, false, false}, /* along the plane */
        {{{1, 1, 8}, 0, {128, 0, 1}, most}, PLACING_UNDECIDED, false, false},
        {{{-32, 1, 7}, 0, {33, 0, 1}, most}, PLACING_IN, true, true},
    };
    for (size_t i = 0; i < sizeof(cases) / sizeof(cases[0]); i++) {
        const struct placing placing = place(cases[i].ray, 0);
        if (placing.side != cases[i].side || placing.is_well_formed != cases[i].is_well_formed ||
            placing.is_within != cases[i].is_within)
            fail_msg("case %zu: %d %d %d", i, placing.side, placing.is_well_formed,
                     placing.is_within);
    }
    /* No area, and too thin for the numbers around. */
    const struct triangle_record flat = {.a = {0, 0, 8}, .b = {4, 0, 8}, .c = {2, 0, 8}},
                                 thin = {.a = {0, 0, 8}, .b = {4, 0, 8}, .c = {0, 0x1p-12f, 8}};
    const struct compare_ray ray = {{1, 0, 0}, 0, {0, 0, 1}, most};
    struct placing placing;
    placing_of_triangle(&ray, &flat, 0, &placing);
    assert_false(placing.is_well_formed);
    placing_of_triangle(&ray, &thin, 0, &placing);
    assert_false(placing.is_well_formed);
}

/* A box from 1 to 3. */
TEST(test_boxes)
{
    const float most = INFINITY;
    static const struct aabb_record box = {.lower = {1, 1, 1}, .upper = {3, 3, 3}},
                                    flat = {.lower = {1, 1, 1}, .upper = {3, 1, 3}};
    const struct {
        struct compare_ray ray;
        bool meets, meets_if_moved;
    } cases[] = {
        {{{0, 2, 2}, 0, {1, 0, 0}, most}, true, true},
        {{{4, 2, 2}, 0, {-1, 0, 0}, most}, true, true},
        {{{4, 2, 2}, 0, {1, 0, 0}, most}, false, false},
        {{{2, 2, 2}, 0, {1, 0, 0}, most}, true, true}, /* begins within */
        {{{0, 2, 2}, 0, {1, 0, 0}, 1}, true, false},   /* ends at the face, exactly */
        {{{0, 2, 2}, 3, {1, 0, 0}, most}, true, false},
        {{{0, 2, 2}, 0, {1, 0, 0}, 0.5f}, false, false},
        {{{0, 2, 2}, 3.5f, {1, 0, 0}, most}, false, false},
        {{{0, 2, 2}, 0, {2, 0, 0}, 0.5f}, true, false},
        {{{0, 2, 2}, 0, {-0.5f, 0, 0}, 2}, false, false},
        {{{4, 2, 2}, 0, {-0.5f, 0, 0}, 2}, true, false},
        {{{0, 2, 2}, 0, {3, 0, 0}, 1 / 3.f}, false, false},  /* no power of two */
        {{{0x1p-30f, 2, 2}, 0, {1, 0, 0}, 1}, false, false}, /* the distance is no float */
        {{{0, 1, 2}, 0, {1, 0, 0}, most}, false, false},     /* along a face */
        {{{0, 2, 3}, 0, {1, 0, 0}, 1}, false, false},
        {{{0, 2, 5}, 0, {1, 0, 0}, 1}, false, false},
        {{{0, 5, 2}, 0, {1, 0, 0}, most}, false, false},
        {{{2, 0, 2}, 0, {0, 1, 0}, 1}, true, false},
        {{{2, 2, 0}, 0, {0, 0, 1}, 1}, true, false},
        {{{0, 0, 0}, 0, {1, 1, 1}, most}, true, true},
        {{{0, 0, 2}, 0, {1, 1, 0}, 1}, false, false}, /* exact along one axis only */
        {{{0, 2, 0}, 0, {1, 0, 2}, most}, true, true},
        {{{0, 3.5f, 0}, 0, {1, -3, 1}, most}, false, false},
        {{{1, 0, 2}, 0, {0, 1, 0}, most}, false, false},
        {{{4, 4, 4}, 0, {-1, -1, -1}, 0.9f}, false, false},
        {{{4, 4, 4}, 0, {-1, -1, -1}, 1.1f}, true, true},
    };
    for (size_t i = 0; i < sizeof(cases) / sizeof(cases[0]); i++) {
        const bool meets = placing_meets_box(&cases[i].ray, &box, 0, false);
        const bool meets_if_moved = placing_meets_box(&cases[i].ray, &box, 0, true);
        if (meets != cases[i].meets || meets_if_moved != cases[i].meets_if_moved)
            fail_msg("case %zu: %d %d", i, meets, meets_if_moved);
        assert_false(placing_meets_box(&cases[i].ray, &flat, 0, false));
        assert_false(
            placing_meets_box(&cases[i].ray, &box, 0x1p16, false)); /* nothing is certain */
    }
}

/* ---- how much of an input is moved, where to, and what is refused */

enum { VERTICES = 40, PADDING = 4096 };

static struct subject subject;

static uint64_t room_of(uint64_t in_alignment, uint64_t offset, uint64_t size)
{
    const uint64_t bytes = in_alignment + 2 * (offset + size) + PADDING;
    return (bytes + COMPARE_ALIGNMENT - 1) / COMPARE_ALIGNMENT * COMPARE_ALIGNMENT;
}

/* ---- sizes; nothing is read at the addresses */

static uint64_t readable_size;

static uint64_t find_readable(void *context, uint64_t address, uint64_t size, const void **bytes)
{
    *bytes = NULL;
    return size < readable_size ? size : readable_size;
}

static void begin(uint64_t readable_bytes)
{
    subject_begin(&subject);
    subject.memory.find = find_readable;
    readable_size = readable_bytes;
}

TEST(test_sizes_of_triangles)
{
    static const struct {
        uint32_t max_vertex, count, offset, first_vertex;
        VkIndexType index_type;
        bool has_transform;
        uint64_t vertices_offset, vertices, indices;
    } cases[] = {
        {8, 3, 0, 0, VK_INDEX_TYPE_NONE_KHR, false, 0, 108, 0},
        {80, 3, 0, 0, VK_INDEX_TYPE_NONE_KHR, false, 0, 108, 0}, /* no more than are read */
        {5, 3, 0, 0, VK_INDEX_TYPE_NONE_KHR, false, 0, 72, 0},   /* no more than there are */
        {8, 1, 24, 2, VK_INDEX_TYPE_NONE_KHR, false, 48, 36, 0},
        {8, 3, 24, 2, VK_INDEX_TYPE_UINT32, false, 24, 84, 36},
        {8, 3, 24, 20, VK_INDEX_TYPE_UINT16, false, 240, 12, 18}, /* the first is beyond the last */
        {8, 3, 0, 0, VK_INDEX_TYPE_UINT8_KHR, true, 0, 108, 9},
        {8, 0, 0, 0, VK_INDEX_TYPE_UINT32, true, 0, 0, 0},
    };
    for (size_t i = 0; i < sizeof(cases) / sizeof(cases[0]); i++) {
        begin(UINT64_MAX);
        subject_triangles(&subject, NULL, cases[i].max_vertex + 1, NULL, cases[i].count);
        VkAccelerationStructureGeometryTrianglesDataKHR *triangles =
            &subject.geometries[0].geometry.triangles;
        triangles->indexType = cases[i].index_type;
        triangles->transformData.deviceAddress = cases[i].has_transform ? 0x10030 : 0;
        triangles->vertexData.deviceAddress = 0x20010;
        subject.ranges[0].primitiveOffset = cases[i].offset;
        subject.ranges[0].firstVertex = cases[i].first_vertex;
        uint64_t expected = COMPARE_ALIGNMENT;
        if (cases[i].vertices)
            expected += room_of(0x10, cases[i].vertices_offset, cases[i].vertices);
        if (cases[i].indices)
            expected += room_of(0, cases[i].offset, cases[i].indices);
        if (cases[i].has_transform && cases[i].count)
            expected += room_of(0x30, 0, sizeof(VkTransformMatrixKHR));
        assert_int_equal(compare_input_size(&subject.input), expected);
    }
}

static uint64_t size_of_boxes(uint32_t count, uint64_t stride, uint32_t offset)
{
    subject_boxes(&subject, NULL, count);
    subject.geometries[0].geometry.aabbs.stride = stride;
    subject.ranges[0].primitiveOffset = offset;
    const uint64_t size = compare_input_size(&subject.input);
    subject.parameters.info.geometryCount = 0;
    return size;
}

TEST(test_limits)
{
    const uint32_t most = (uint32_t)((COMPARE_INPUT_MAX - COMPARE_ALIGNMENT - PADDING) / 2);
    begin(UINT64_MAX);
    assert_int_equal(size_of_boxes(1, 24, 0), COMPARE_ALIGNMENT + room_of(0, 0, 24));
    assert_int_equal(size_of_boxes(3, 32, 16), COMPARE_ALIGNMENT + room_of(0, 16, 88));
    assert_int_equal(size_of_boxes(1, 24, most - 24), COMPARE_INPUT_MAX);
    assert_true(size_of_boxes(1, 24, most - 23) == UINT64_MAX);
    assert_true(size_of_boxes(2, UINT64_MAX, 0) == UINT64_MAX);
    assert_true(size_of_boxes(3, UINT64_MAX / 2 + 13, 0) == UINT64_MAX); /* wraps to 26 */
    assert_true(size_of_boxes(2, COMPARE_INPUT_MAX, 0) == UINT64_MAX);
    assert_true(size_of_boxes(1, 24, UINT32_MAX) == UINT64_MAX);
    readable_size = 24;
    assert_int_equal(size_of_boxes(1, 24, 0), COMPARE_ALIGNMENT + room_of(0, 0, 24));
    readable_size = 23;
    assert_true(size_of_boxes(1, 24, 0) == UINT64_MAX);
}

/* ---- copies */

TEST(test_copies)
{
    static float vertices[3 * VERTICES];
    static uint32_t indices[VERTICES];
    static const VkTransformMatrixKHR transforms[2] = {{{{1}}}, {{{2, 3}}}};
    static const VkAabbPositionsKHR boxes[2] = {{1, 2, 3, 4, 5, 6}, {7, 8, 9, 10, 11, 12}};
    for (uint32_t i = 0; i < 3 * VERTICES; i++)
        vertices[i] = (float)i;
    for (uint32_t i = 0; i < VERTICES; i++)
        indices[i] = i / 2;
    subject_begin(&subject);
    subject_triangles(&subject, vertices, VERTICES, indices, 5);
    subject.geometries[0].geometry.triangles.transformData.hostAddress = transforms;
    subject.ranges[0] = (VkAccelerationStructureBuildRangeInfoKHR){5, 8, 4, sizeof(transforms[0])};
    subject_triangles(&subject, vertices, VERTICES, NULL, 0);
    struct input_copy *copied = input_copy_create(&subject.input);
    assert_non_null(copied);
    assert_int_equal(copied->size, compare_input_size(&subject.input));
    assert_int_equal((uintptr_t)copied->bytes % COMPARE_ALIGNMENT, 0);
    const VkAccelerationStructureGeometryTrianglesDataKHR *moved =
        &copied->parameters.geometries[0].geometry.triangles;
    assert_int_equal(moved->vertexData.deviceAddress % COMPARE_ALIGNMENT,
                     (uintptr_t)vertices % COMPARE_ALIGNMENT);
    const unsigned char *to = moved->vertexData.hostAddress;
    assert_memory_equal(to + 4 * 12, vertices + 12, (VERTICES - 4) * 12);
    for (int i = 0; i < 4 * 12; i++)
        assert_int_equal(to[i], 0); /* nothing reads there */
    to = moved->indexData.hostAddress;
    assert_memory_equal(to + 8, indices + 2, 15 * sizeof(indices[0]));
    to = moved->transformData.hostAddress;
    assert_memory_equal(to + sizeof(transforms[0]), &transforms[1], sizeof(transforms[1]));
    assert_ptr_equal(copied->parameters.geometries[1].geometry.triangles.vertexData.hostAddress,
                     copied->bytes);

    const void *bytes;
    const uint64_t begin = (uintptr_t)copied->bytes;
    const struct input_memory *memory = &copied->memory;
    assert_int_equal(memory->find(memory->context, begin, 16, &bytes), 16);
    assert_ptr_equal(bytes, copied->bytes);
    assert_int_equal(memory->find(memory->context, begin + copied->size - 4, 16, &bytes), 4);
    assert_int_equal(memory->find(memory->context, begin + copied->size, 16, &bytes), 0);
    assert_null(bytes);
    assert_int_equal(memory->find(memory->context, begin - 1, 16, &bytes), 0);
    input_copy_free(copied);

    subject_begin(&subject);
    subject_boxes(&subject, boxes, 2);
    assert_non_null(copied = input_copy_create(&subject.input));
    assert_memory_equal(copied->parameters.geometries[0].geometry.aabbs.data.hostAddress, boxes,
                        sizeof(boxes));
    input_copy_free(copied);
    subject.memory.find = find_readable;
    readable_size = 0;
    const int before = allocations_now();
    assert_null(input_copy_create(&subject.input));
    input_copy_free(NULL);
    assert_int_equal(allocations_now(), before);
}
