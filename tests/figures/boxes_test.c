/* SPDX-License-Identifier: Apache-2.0 */
/* Boxes that overlap: the figures, against random points and lines that look at each box. */
#include <math.h>

#include "src/advice/figures/boxes.h"
#include "tests/figures/lines.h"
#include "tests/unit/unit_test.h"

enum { COUNT = 40, SAMPLES = 20000 };

struct placed {
    VkTransformMatrixKHR transform, inverse;
    double determinant;
    uint32_t mask;
};

static const struct figure_box box = {{-1, -2, 0}, {3, 1, 2}};

/* A turn around z with a scale, at a random place of a cube. The inverse turns back. */
static struct placed place(struct random *random, double cube)
{
    const double angle = random_between(random, 0, 6), scale = random_between(random, 0.5, 3),
                 c = cos(angle), s = sin(angle);
    double at[3], back[3];
    for (int i = 0; i < 3; i++)
        at[i] = random_between(random, 0, cube);
    back[0] = -(c * at[0] + s * at[1]) / scale;
    back[1] = -(c * at[1] - s * at[0]) / scale;
    back[2] = -at[2] / scale;
    return (struct placed){
        .transform = {{{(float)(scale * c), (float)(-scale * s), 0, (float)at[0]},
                       {(float)(scale * s), (float)(scale * c), 0, (float)at[1]},
                       {0, 0, (float)scale, (float)at[2]}}},
        .inverse = {{{(float)(c / scale), (float)(s / scale), 0, (float)back[0]},
                     {(float)(-s / scale), (float)(c / scale), 0, (float)back[1]},
                     {0, 0, (float)(1 / scale), (float)back[2]}}},
        .determinant = scale * scale * scale,
        .mask = 0xff,
    };
}

static struct box_figures figures_of(const struct placed *placed, uint32_t count)
{
    struct box_figures figures = {0};
    for (uint32_t i = 0; i < count; i++)
        box_figures_add(&figures, &box, &placed[i].transform, placed[i].determinant,
                        placed[i].mask);
    return figures;
}

static bool is_in(const struct placed *placed, const double point[3])
{
    bool is_inside = true;
    for (int i = 0; i < 3; i++) {
        const float *row = placed->inverse.matrix[i];
        const double at = row[0] * point[0] + row[1] * point[1] + row[2] * point[2] + row[3];
        is_inside &= at >= box.lower[i] && at <= box.upper[i];
    }
    return is_inside;
}

/* How many boxes have a random point of the box around all. */
static double count_points(struct random *random, const struct placed *placed, uint32_t count,
                           const struct box_figures *figures)
{
    uint64_t found = 0;
    for (int i = 0; i < SAMPLES; i++) {
        double point[3];
        for (int j = 0; j < 3; j++)
            point[j] = random_between(random, figures->lower[j], figures->upper[j]);
        for (uint32_t j = 0; j < count; j++)
            found += is_in(&placed[j], point);
    }
    return (double)found / SAMPLES;
}

/* How many boxes around placed boxes a random line meets that meets the box around all. */
static double count_lines(struct random *random, const struct placed *placed, uint32_t count,
                          const struct box_figures *figures)
{
    uint64_t lines = 0, met = 0;
    while (lines < SAMPLES) {
        const struct line line = line_through(random, figures->lower, figures->upper);
        if (!line_meets(&line, figures->lower, figures->upper))
            continue;
        lines++;
        for (uint32_t i = 0; i < count; i++) {
            const struct box_figures one = figures_of(&placed[i], 1);
            met += line_meets(&line, one.lower, one.upper);
        }
    }
    return (double)met / (double)lines;
}

static void expect_near(double found, double expected)
{
    assert_true(fabs(found - expected) <= 0.05 * expected);
}

/* In cubes from crowded to roomy. */
TEST(test_random_points_and_lines)
{
    struct random random = random_of("boxes");
    for (double cube = 2; cube < 20; cube *= 2) {
        struct placed placed[COUNT];
        for (int i = 0; i < COUNT; i++)
            placed[i] = place(&random, cube);
        const struct box_figures figures = figures_of(placed, COUNT);
        expect_near(count_points(&random, placed, COUNT, &figures), box_figures_depth(&figures));
        expect_near(count_lines(&random, placed, COUNT, &figures), box_figures_met(&figures));
    }
}

static struct placed along_x(float x, uint32_t mask)
{
    return (struct placed){
        .transform = {{{1, 0, 0, x}, {0, 1, 0, 0}, {0, 0, 1, 0}}}, .determinant = 1, .mask = mask};
}

/* Boxes that touch fill the box around all once. */
TEST(test_boxes_in_a_row)
{
    const struct placed row[] = {along_x(0, 1), along_x(4, 1), along_x(8, 1)};
    const struct box_figures figures = figures_of(row, 3);
    assert_true(figures.count == 3 && box_figures_depth(&figures) == 1);
    assert_true(figures.lower[0] == -1 && figures.upper[0] == 11 && figures.upper[2] == 2);
}

/* Mirrored boxes have volumes, too. */
TEST(test_masks_and_mirrors)
{
    struct placed same[] = {along_x(0, 3), along_x(0, 1), along_x(0, 0x82)};
    struct box_figures figures = figures_of(same, 3);
    assert_true(box_figures_depth(&figures) == 2 && box_figures_met(&figures) == 3);
    for (int i = 0; i < 3; i++) {
        same[i].determinant = -1;
        same[i].transform.matrix[0][0] = -1;
    }
    figures = figures_of(same, 3);
    assert_true(box_figures_depth(&figures) == 2);
    assert_true(figures.lower[0] == -3 && figures.upper[0] == 1);
}

TEST(test_boxes_without_volume)
{
    const struct figure_box flat = {{0, 0, 0}, {1, 1, 0}}, point = {{0, 0, 0}, {0, 0, 0}};
    const struct placed placed = along_x(0, 0xff);
    struct box_figures figures = {0};
    assert_true(box_figures_depth(&figures) == 0 && box_figures_met(&figures) == 0);
    box_figures_add(&figures, &point, &placed.transform, 1, 0xff);
    assert_true(box_figures_depth(&figures) == 0 && box_figures_met(&figures) == 0);
    box_figures_add(&figures, &flat, &placed.transform, 1, 0xff);
    assert_true(box_figures_depth(&figures) == 0 && box_figures_met(&figures) == 1);
}

TEST(test_boxes_grow)
{
    struct figure_box grown = {{9, 9, 9}, {-9, -9, -9}};
    const float lower[] = {1, 2, 3}, upper[] = {4, 5, 6}, less[] = {0, 3, 3}, more[] = {3, 6, 6};
    figure_box_add(&grown, true, lower, upper);
    figure_box_add(&grown, false, less, more);
    assert_true(grown.lower[0] == 0 && grown.lower[1] == 2 && grown.lower[2] == 3);
    assert_true(grown.upper[0] == 4 && grown.upper[1] == 6 && grown.upper[2] == 6);
}
