/* SPDX-License-Identifier: Apache-2.0 */
/* Signs of determinants. An estimate is certain for nearly all matrices (a filter after Shewchuk
 * 1997); builder_determinant_sign() is exact.
 *
 * The estimate needs the environment of src/base/float_environment.h. */
#ifndef ASSAY_BVH_EXPANSION_H
#define ASSAY_BVH_EXPANSION_H

#include <stdint.h>
#include <string.h>
#include <vulkan/vulkan_core.h>

/* The first is the largest rounding error of determinant_estimate(), as a share of the sum of its
 * terms' magnitudes. Each term, and their sum, is rounded less than eight times, by 2^-24 each; the
 * bound leaves room for the rounding of the sum of magnitudes. The second is for what is lost if a
 * product is less than FLT_MIN, relative to 1 and to the element that it is multiplied by. */
#define ESTIMATE_ERROR 1e-6F
#define ESTIMATE_UNDERFLOW 1e-37F

typedef float determinant_row __attribute__((vector_size(16)));

static inline determinant_row determinant_load(const float row[4])
{
    determinant_row loaded;
    memcpy(&loaded, row, sizeof(loaded));
    return loaded;
}

/* Clears the sign bits. */
static inline determinant_row determinant_size(determinant_row row)
{
    typedef int32_t bits __attribute__((vector_size(16)));
    return (determinant_row)((bits)row & INT32_MAX);
}

/* Returns the sign of the determinant of the first three columns, or 0 if rounding errors could
 * have changed it, or if an element is not finite.
 *
 * The three terms are computed at once: the elements of the first row, times their cofactors. The
 * translation, in the fourth column, takes no part. */
static inline int determinant_estimate(const VkTransformMatrixKHR *transform)
{
    const determinant_row x = determinant_load(transform->matrix[0]);
    const determinant_row y = determinant_load(transform->matrix[1]);
    const determinant_row z = determinant_load(transform->matrix[2]);
    const determinant_row first =
        __builtin_shufflevector(y, y, 1, 2, 0, 0) * __builtin_shufflevector(z, z, 2, 0, 1, 1);
    const determinant_row second =
        __builtin_shufflevector(y, y, 2, 0, 1, 1) * __builtin_shufflevector(z, z, 1, 2, 0, 0);
    const determinant_row terms = x * (first - second), sizes = determinant_size(x);
    const determinant_row errors =
        sizes * (determinant_size(first) + determinant_size(second)) * ESTIMATE_ERROR +
        sizes * ESTIMATE_UNDERFLOW;
    const float sum = terms[0] + terms[1] + terms[2];
    const float error = errors[0] + errors[1] + errors[2] + ESTIMATE_UNDERFLOW;
    return (sum > error) - (sum < -error);
}

/* ---- Exact arithmetic with floating-point expansions. An expansion represents a number as a sum
 * of nonoverlapping, nonzero doubles in order of increasing magnitude. Shewchuk, "Adaptive
 * Precision Floating-Point Arithmetic and Fast Robust Geometric Predicates", 1997.
 *
 * Results are exact as long as no product is below 2^-1022 * 2^53 or above 2^1023 / 2^27. Products
 * here have at most four factors from floats (multiples of 2^-149 below 2^128) or from a ray in
 * double whose range ray.c limits: between 2^-969 and 2^900. Requires rounding to nearest and no
 * contraction. */

/* `to` needs room for the exact result: m + n terms for a sum of m and n terms, 2n for a multiple
 * by a double, 2mn for a product. Each function returns the number of terms written; 0 terms
 * represent 0. */
int expansion_difference(double a, double b, double *to); /* a - b: 2 terms */
int expansion_sum(int m, const double *e, int n, const double *f, double *to);
int expansion_subtract(int m, const double *e, int n, const double *f, double *to);
int expansion_scale(int n, const double *e, double by, double *to);
int expansion_product(int m, const double *e, int n, const double *f, double *to);

int expansion_sign(int n, const double *e);
double expansion_estimate(int n, const double *e); /* within 2^-51 of the exact value */

/* The determinant of the 3x3 part. The result is 0 only if the determinant is exactly 0 or its
 * magnitude is below 2^-447; no nonzero determinant of floats is that small. */
double transform_determinant(const VkTransformMatrixKHR *transform);

#endif
