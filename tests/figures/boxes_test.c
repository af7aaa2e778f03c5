/* SPDX-License-Identifier: Apache-2.0 */
/* Boxes that overlap: how often a point of the box around all is in one, and a line meets one. */
#include "src/advice/figures/boxes.h"
#include "tests/unit/unit_test.h"

struct placed {
    VkTransformMatrixKHR transform;
    double determinant;
    uint32_t mask;
};

static const struct figure_box box = {{-1, -2, 0}, {3, 1, 2}}; /* 4 by 3 by 2 */

static struct box_figures figures_of(const struct placed *placed, uint32_t count)
{
    struct box_figures figures = {0};
    for (uint32_t i = 0; i < count; i++)
        box_figures_add(&figures, &box, &placed[i].transform, placed[i].determinant,
                        placed[i].mask);
    return figures;
}

/* The box around a box that is turned and sheared is larger than what the box fills of it. */
TEST(test_turned_boxes)
{
    static const struct placed turned[] = {
        {{{{0, -2, 0, 10}, {2, 1, 0, 20}, {0, 0, 3, 30}}}, 12, 0xff}, /* 6 by 11 by 6 */
        {{{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}}, 1, 0xff}};
    struct box_figures figures = figures_of(turned, 1);
    assert_true(figures.lower[1] == 16 && figures.upper[1] == 27);
    assert_true(box_figures_depth(&figures) == 12 * 24 / (6.0 * 11 * 6));
    assert_true(box_figures_met(&figures) == 1);
    figures = figures_of(turned, 2); /* within 15 by 29 by 36 */
    assert_true(box_figures_depth(&figures) == (12 * 24 + 24) / (15.0 * 29 * 36));
    assert_true(box_figures_met(&figures) == (6 * 11 + 11 * 6 + 6 * 6 + 4 * 3 + 3 * 2 + 2 * 4) /
                                                 (15.0 * 29 + 29 * 36 + 36 * 15));
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
