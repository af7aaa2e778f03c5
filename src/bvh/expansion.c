/* SPDX-License-Identifier: Apache-2.0 */
/* Exact arithmetic by floating-point expansions, after Shewchuk 1997. */
#include "src/bvh/expansion.h"

#include <math.h>

#include "src/bvh/bvh.h"

#define EXPANSION_PRODUCT_MAX 256 /* the maximum number of terms of a product */

/* Knuth's two-sum (Shewchuk, theorem 7): sum + error = a + b exactly. */
static inline double two_sum(double a, double b, double *error)
{
    double sum = a + b, b_part = sum - a, a_part = sum - b_part;
    *error = (a - a_part) + (b - b_part);
    return sum;
}

/* Dekker's fast two-sum; requires |a| >= |b| (theorem 6). */
static inline double fast_two_sum(double a, double b, double *error)
{
    double sum = a + b;
    *error = b - (sum - a);
    return sum;
}

/* Dekker's split into two halves of 26 bits (theorem 17). */
static inline void split(double a, double *high, double *low)
{
    double c = 134217729.0 * a; /* 2^27 + 1 */
    *high = c - (c - a);
    *low = a - *high;
}

/* Dekker and Veltkamp (theorem 18), with `b` split by the caller. */
static inline double two_product(double a, double b, double b_high, double b_low, double *error)
{
    double product = a * b, a_high, a_low;
    split(a, &a_high, &a_low);
    *error = a_low * b_low - (((product - a_high * b_high) - a_low * b_high) - a_high * b_low);
    return product;
}

int expansion_difference(double a, double b, double *to)
{
    double error, difference = two_sum(a, -b, &error);
    int count = 0;
    if (error != 0)
        to[count++] = error;
    if (difference != 0)
        to[count++] = difference;
    return count;
}

/* Shewchuk's FAST-EXPANSION-SUM (figure 8) without zero terms; `sign` multiplies the second
 * operand. The result has at most m + n terms, even if values that are not finite make it
 * meaningless. */
static int merge(int m, const double *e, int n, const double *f, double sign, double *to)
{
    int i = 0, j = 0, count = 0;
    double q = 0;
    while (i < m || j < n) {
        bool is_first = i + j == 0;
        double next, error;
        if (j >= n || (i < m && (f[j] > e[i]) == (f[j] > -e[i])))
            next = e[i++];
        else
            next = sign * f[j++];
        if (is_first) {
            q = next;
            continue;
        }
        q = two_sum(q, next, &error);
        if (error != 0)
            to[count++] = error;
    }
    if (q != 0)
        to[count++] = q;
    return count;
}

int expansion_sum(int m, const double *e, int n, const double *f, double *to)
{
    return merge(m, e, n, f, 1, to);
}

int expansion_subtract(int m, const double *e, int n, const double *f, double *to)
{
    return merge(m, e, n, f, -1, to);
}

/* SCALE-EXPANSION (figure 13) without zero terms. */
int expansion_scale(int n, const double *e, double by, double *to)
{
    if (n == 0 || by == 0)
        return 0;
    double by_high, by_low, error;
    split(by, &by_high, &by_low);
    int count = 0;
    double q = two_product(e[0], by, by_high, by_low, &error);
    if (error != 0)
        to[count++] = error;
    for (int i = 1; i < n; i++) {
        double low, sum, product = two_product(e[i], by, by_high, by_low, &low);
        sum = two_sum(q, low, &error);
        if (error != 0)
            to[count++] = error;
        q = fast_two_sum(product, sum, &error);
        if (error != 0)
            to[count++] = error;
    }
    if (q != 0)
        to[count++] = q;
    return count;
}

int expansion_product(int m, const double *e, int n, const double *f, double *to)
{
    double sums[2][EXPANSION_PRODUCT_MAX], multiple[EXPANSION_PRODUCT_MAX];
    int count = 0, now = 0;
    for (int j = 0; j < n; j++) {
        int terms = expansion_scale(m, e, f[j], multiple);
        count = expansion_sum(count, sums[now], terms, multiple, sums[1 - now]);
        now = 1 - now;
    }
    memcpy(to, sums[now], (size_t)count * sizeof(*to));
    return count;
}

int expansion_sign(int n, const double *e)
{
    if (n == 0)
        return 0;
    return e[n - 1] > 0 ? 1 : -1;
}

double expansion_estimate(int n, const double *e)
{
    double sum = 0;
    for (int i = 0; i < n; i++)
        sum += e[i];
    return sum;
}

static bool is_finite(const VkTransformMatrixKHR *transform)
{
    for (int row = 0; row < 3; row++)
        for (int column = 0; column < 3; column++)
            if (!isfinite(transform->matrix[row][column]))
                return false;
    return true;
}

/* m00 (m11 m22 - m12 m21) and its two companions, in 4 * 3 terms; the inner products are exact. A
 * matrix that is not finite has no inverse; its determinant counts as 0. */
static int determinant(const VkTransformMatrixKHR *transform, double to[12])
{
    double sums[2][12];
    int count = 0, now = 0;
    if (!is_finite(transform))
        return 0;
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        const float *y = transform->matrix[1], *z = transform->matrix[2];
        double minor[2], term[4];
        int terms = expansion_difference((double)y[j] * z[k], (double)y[k] * z[j], minor);
        terms = expansion_scale(terms, minor, transform->matrix[0][i], term);
        count = expansion_sum(count, sums[now], terms, term, sums[1 - now]);
        now = 1 - now;
    }
    memcpy(to, sums[now], (size_t)count * sizeof(*to));
    return count;
}

double transform_determinant(const VkTransformMatrixKHR *transform)
{
    double terms[12];
    return expansion_estimate(determinant(transform, terms), terms);
}

int builder_determinant_sign(const VkTransformMatrixKHR *transform)
{
    double terms[12];
    int sign = determinant_estimate(transform);
    if (sign)
        return sign;
    return expansion_sign(determinant(transform, terms), terms);
}
