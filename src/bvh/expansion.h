/* SPDX-License-Identifier: Apache-2.0 */
/* Exact arithmetic with floating-point expansions. An expansion represents a number as a sum of
 * nonoverlapping, nonzero doubles in order of increasing magnitude. Shewchuk, "Adaptive Precision
 * Floating-Point Arithmetic and Fast Robust Geometric Predicates", 1997.
 *
 * Results are exact as long as no product is below 2^-1022 * 2^53 or above 2^1023 / 2^27. Products
 * here have at most four factors from floats (multiples of 2^-149 below 2^128) or from a ray in
 * double whose range ray.c limits: between 2^-969 and 2^900. Requires rounding to nearest and no
 * contraction. */
#ifndef ASSAY_BVH_EXPANSION_H
#define ASSAY_BVH_EXPANSION_H

#include <vulkan/vulkan_core.h>

/* `to` needs room for the exact result: m + n terms for a sum of m and n terms, 2n for a multiple
 * by a double, 2mn for a product. Each function returns the number of terms written; 0 terms
 * represent 0. */
int expansion_difference(double a, double b, double *to); /* a - b: 2 terms */
int expansion_sum(int m, const double *e, int n, const double *f, double *to);
int expansion_subtract(int m, const double *e, int n, const double *f, double *to);
int expansion_scale(int n, const double *e, double by, double *to);
int expansion_product(int m, const double *e, int n, const double *f, double *to);

#define EXPANSION_PRODUCT_MAX 256 /* the maximum number of terms of a product */

int expansion_sign(int n, const double *e);
double expansion_estimate(int n, const double *e); /* within 2^-51 of the exact value */

/* The determinant of the 3x3 part. The result is 0 only if the determinant is exactly 0 or its
 * magnitude is below 2^-447; no nonzero determinant of floats is that small. */
double transform_determinant(const VkTransformMatrixKHR *transform);

#endif
