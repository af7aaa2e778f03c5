/* SPDX-License-Identifier: Apache-2.0 */
#include "src/advice/figures/boxes.h"

#include <math.h>

void figure_box_add(struct figure_box *box, bool is_first, const float lower[3],
                    const float upper[3])
{
    for (int i = 0; i < 3; i++) {
        box->lower[i] = is_first || lower[i] < box->lower[i] ? lower[i] : box->lower[i];
        box->upper[i] = is_first || upper[i] > box->upper[i] ? upper[i] : box->upper[i];
    }
}

static double surface_of(const double size[3])
{
    return 2 * (size[0] * size[1] + size[1] * size[2] + size[2] * size[0]);
}

/* The box around a placed box: its center is placed, and the halves of its sides add up. */
static void grow_figures(struct box_figures *figures, const struct figure_box *box,
                         const VkTransformMatrixKHR *transform, double size[3])
{
    for (int i = 0; i < 3; i++) {
        const float *row = transform->matrix[i];
        double center = row[3], half = 0;
        for (int j = 0; j < 3; j++) {
            center += row[j] * ((double)box->upper[j] + box->lower[j]) / 2;
            half += fabs(row[j] * ((double)box->upper[j] - box->lower[j])) / 2;
        }
        const double lower = center - half, upper = center + half;
        figures->lower[i] =
            !figures->count || lower < figures->lower[i] ? lower : figures->lower[i];
        figures->upper[i] =
            !figures->count || upper > figures->upper[i] ? upper : figures->upper[i];
        size[i] = 2 * half;
    }
}

void box_figures_add(struct box_figures *figures, const struct figure_box *box,
                     const VkTransformMatrixKHR *transform, double determinant, uint32_t mask)
{
    double size[3], volume = fabs(determinant);
    for (int i = 0; i < 3; i++)
        volume *= (double)box->upper[i] - box->lower[i];
    grow_figures(figures, box, transform, size);
    figures->surfaces += surface_of(size);
    for (int i = 0; i < MASK_BITS; i++)
        figures->volumes[i] += mask >> i & 1 ? volume : 0;
    figures->count++;
}

static void size_of_all(const struct box_figures *figures, double size[3])
{
    for (int i = 0; i < 3; i++)
        size[i] = figures->upper[i] - figures->lower[i];
}

double box_figures_depth(const struct box_figures *figures)
{
    double size[3], most = 0;
    size_of_all(figures, size);
    for (int i = 0; i < MASK_BITS; i++)
        most = fmax(most, figures->volumes[i]);
    const double volume = size[0] * size[1] * size[2];
    return volume > 0 && isfinite(most) ? most / volume : 0;
}

double box_figures_met(const struct box_figures *figures)
{
    double size[3];
    size_of_all(figures, size);
    const double surface = surface_of(size);
    return surface > 0 && isfinite(figures->surfaces) ? figures->surfaces / surface : 0;
}
