/* SPDX-License-Identifier: Apache-2.0 */
/* A fast estimate of a determinant's sign, which is certain for nearly all matrices (a filter after
 * Shewchuk 1997). builder_determinant_sign() is exact. */
#ifndef ASSAY_BVH_DETERMINANT_H
#define ASSAY_BVH_DETERMINANT_H

#include <math.h>
#include <vulkan/vulkan_core.h>

/* The largest rounding error of determinant_estimate(), as a share of the sum of its terms'
 * magnitudes. The products of two floats are exact. Each term is then rounded at most four times,
 * by 2^-53 each; the bound leaves room for the rounding of the sum of magnitudes. */
#define ESTIMATE_ERROR 1e-15

/* Returns the sign of the determinant of the first three columns, or 0 if rounding errors could
 * have changed it, or if an element is not finite. */
static inline int determinant_estimate(const VkTransformMatrixKHR *transform)
{
    const float *x = transform->matrix[0], *y = transform->matrix[1], *z = transform->matrix[2];
    double sum = 0, magnitude = 0;
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        double first = (double)y[j] * z[k], second = (double)y[k] * z[j];
        sum += x[i] * (first - second);
        magnitude += fabs((double)x[i]) * (fabs(first) + fabs(second));
    }
    double error = magnitude * ESTIMATE_ERROR;
    return (sum > error) - (sum < -error);
}

#endif
