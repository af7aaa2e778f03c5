/* SPDX-License-Identifier: Apache-2.0 */
/* Exact arithmetic by floating-point expansions: a number is the sum of doubles that don't overlap,
 * the smallest first, without zeros. Shewchuk, "Adaptive Precision Floating-Point Arithmetic and
 * Fast Robust Geometric Predicates", 1997.
 *
 * Exact as long as no product is below 2^-1022 * 2^53 or above 2^1023 / 2^27. Products here have
 * at most four factors from floats (multiples of 2^-149 below 2^128) or from a ray in double whose
 * range ray.c limits: between 2^-969 and 2^900. Needs rounding to nearest, and no contraction. */
#ifndef ASSAY_BVH_EXPANSION_H
#define ASSAY_BVH_EXPANSION_H

#include <vulkan/vulkan_core.h>

/* Room for the exact result of each function: m + n terms for a sum of m and n, 2n for a multiple
 * by a double, 2mn for a product. All return the count of terms written; 0 terms are 0. */
int expansion_difference(double a, double b, double *to); /* a - b: 2 terms */
int expansion_sum(int m, const double *e, int n, const double *f, double *to);
int expansion_subtract(int m, const double *e, int n, const double *f, double *to);
int expansion_scale(int n, const double *e, double by, double *to);
int expansion_product(int m, const double *e, int n, const double *f, double *to);

#define EXPANSION_PRODUCT_MAX 256 /* the most terms that a product may have */

int expansion_sign(int n, const double *e);
double expansion_estimate(int n, const double *e); /* within 2^-51 of it */

/* Of the 3x3 part; 0 only where it is exactly 0, or where a determinant of floats is below
 * 2^-447, which none but 0 is. */
double transform_determinant(const VkTransformMatrixKHR *transform);

#endif
