/* SPDX-License-Identifier: Apache-2.0 */
/* How much the boxes of instances overlap, on average over the box around all: figures that hold
 * for every tree that a driver may build over these boxes.
 *
 * The functions need the environment of src/base/float_environment.h. */
#ifndef ASSAY_ADVICE_FIGURES_BOXES_H
#define ASSAY_ADVICE_FIGURES_BOXES_H

#include <stdbool.h>
#include <stdint.h>
#include <vulkan/vulkan_core.h>

/* An axis-aligned box of finite coordinates. */
struct figure_box {
    float lower[3], upper[3];
};

/* Makes a box as large as it needs to be for another one. `is_first`: replaces it. */
void figure_box_add(struct figure_box *box, bool is_first, const float lower[3],
                    const float upper[3]);

enum { MASK_BITS = 8 };

/* Zero-initialized: there is no instance. */
struct box_figures {
    uint64_t count;
    double lower[3], upper[3]; /* around the axis-aligned boxes of all instances */
    double surfaces;           /* the sum of those of the axis-aligned boxes */
    /* For each bit of the mask: the sum of the volumes of the structures' boxes, as the transforms
     * place them. They are no larger than the axis-aligned boxes around these. */
    double volumes[MASK_BITS];
};

/* Adds an instance of a structure that has the box. `determinant` is that of the transform. */
void box_figures_add(struct box_figures *figures, const struct figure_box *box,
                     const VkTransformMatrixKHR *transform, double determinant, uint32_t mask);

/* In how many of the structures' boxes a random point of the box around all lies, on average, for
 * the bit of the mask with most of them. 0 if the box around all has no volume. */
double box_figures_depth(const struct box_figures *figures);

/* How many of the axis-aligned boxes a random line through the box around all meets, on average:
 * a convex body is met as often as its surface is large (Cauchy's formula). 0 if the box around all
 * has no surface. */
double box_figures_met(const struct box_figures *figures);

#endif
