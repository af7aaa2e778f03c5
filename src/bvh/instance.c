/* SPDX-License-Identifier: Apache-2.0 */
/* Inverses and world bounds of instance transforms. */
#include "src/bvh/instance.h"

#include "src/bvh/expansion.h"

/* Products of two floats are exact in double, so each cofactor is rounded once. The determinant is
 * computed exactly and then rounded. Every element is therefore within 2^-51 of its exact value,
 * even if the matrix is nearly singular. Nothing overflows: the third power of a float fits the
 * range of double. */
void instance_invert(const VkTransformMatrixKHR *transform, double inverse[9])
{
    double determinant = transform_determinant(transform);
    for (int row = 0; row < 3; row++)
        for (int column = 0; column < 3; column++) {
            int i = (column + 1) % 3, j = (column + 2) % 3, k = (row + 1) % 3, l = (row + 2) % 3;
            double a = (double)transform->matrix[i][k] * transform->matrix[j][l];
            double b = (double)transform->matrix[i][l] * transform->matrix[j][k];
            inverse[3 * row + column] = determinant == 0 ? 0 : (a - b) / determinant;
        }
}

/* ---- bounds */

/* Returns m * x, with 0 times infinity as 0: an AABB may be infinite along an axis that the matrix
 * ignores. */
static double scaled(double m, double x)
{
    return m == 0 ? 0 : m * x;
}

/* Arvo, "Transforming Axis-Aligned Bounding Boxes", Graphics Gems 1990, in double. A product of two
 * floats is exact; the error of the three sums is below 3 * 2^-53 of the sum of magnitudes. The
 * pad, 2^-20 of that sum, is far larger. It also covers the rounding of rays into object space (to
 * 2^-24 at accuracy robust, to less than 2^-50 at exact) for matrices whose condition is below 2^4
 * at robust and 2^30 at exact. make_slab() pads for the error that grows with the origin. */
struct box instance_bounds_between(double low[3][4], double high[3][4], const void *blas)
{
    const struct structure_header *header = blas;
    bool is_empty = !header || header->record_count == 0;
    struct box box = box_empty();
    for (int row = 0; row < 3; row++) {
        double least = low[row][3], greatest = high[row][3];
        double magnitude = fmax(fabs(least), fabs(greatest));
        for (int column = 0; column < 3 && !is_empty; column++) {
            double a = scaled(low[row][column], header->lower[column]);
            double b = scaled(low[row][column], header->upper[column]);
            double c = scaled(high[row][column], header->lower[column]);
            double d = scaled(high[row][column], header->upper[column]);
            least += fmin(fmin(a, b), fmin(c, d));
            greatest += fmax(fmax(a, b), fmax(c, d));
            magnitude += fmax(fmax(fabs(a), fabs(b)), fmax(fabs(c), fabs(d)));
        }
        double pad = is_empty || isinf(magnitude) ? 0 : magnitude * 0x1p-20;
        box.lower[row] = isnan(least) ? -INFINITY : rounded_down(least - pad);
        box.upper[row] = isnan(greatest) ? INFINITY : rounded_up(greatest + pad);
    }
    return box;
}

struct box instance_bounds(const VkTransformMatrixKHR *transform, const void *blas)
{
    double elements[3][4];
    for (int i = 0; i < 12; i++)
        elements[i / 4][i % 4] = transform->matrix[i / 4][i % 4];
    return instance_bounds_between(elements, elements, blas);
}
