/* SPDX-License-Identifier: Apache-2.0 */
/* Where rays lie to triangles and boxes, in numbers that are exact. */
#include <math.h>

#include "src/compare/rays.h"
#include "tests/unit/unit_test.h"

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
