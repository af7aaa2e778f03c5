/* SPDX-License-Identifier: Apache-2.0 */
/* Brute force in rational arithmetic. */
#include "exact.h"

#include <gmp.h>
#include <math.h>

static void init_all(mpq_t *numbers, int count)
{
    for (int i = 0; i < count; i++)
        mpq_init(numbers[i]);
}

static void clear_all(mpq_t *numbers, int count)
{
    for (int i = 0; i < count; i++)
        mpq_clear(numbers[i]);
}

/* to = a . (b x c) */
static void triple_product(mpq_t to, const mpq_t a[3], const mpq_t b[3], const mpq_t c[3])
{
    mpq_t left, right;
    mpq_inits(left, right, NULL);
    mpq_set_ui(to, 0, 1);
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        mpq_mul(left, b[j], c[k]);
        mpq_mul(right, b[k], c[j]);
        mpq_sub(left, left, right);
        mpq_mul(left, left, a[i]);
        mpq_add(to, to, left);
    }
    mpq_clears(left, right, NULL);
}

/* Corners relative to the origin, and the direction. */
static void set_up(const struct trace_ray *ray, const float corners[9], mpq_t p[3][3], mpq_t d[3])
{
    mpq_t origin;
    mpq_init(origin);
    init_all(d, 3);
    for (int i = 0; i < 3; i++)
        mpq_set_d(d[i], ray->direction[i]);
    for (int corner = 0; corner < 3; corner++) {
        init_all(p[corner], 3);
        for (int i = 0; i < 3; i++) {
            mpq_set_d(origin, ray->origin[i]);
            mpq_set_d(p[corner][i], corners[3 * corner + i]);
            mpq_sub(p[corner][i], p[corner][i], origin);
        }
    }
    mpq_clear(origin);
}

static bool is_between(const struct trace_ray *ray, const mpq_t t)
{
    mpq_t limit;
    mpq_init(limit);
    mpq_set_d(limit, ray->t_min);
    bool is_inside = mpq_cmp(t, limit) > 0;
    if (is_inside && !isinf(ray->t_max)) {
        mpq_set_d(limit, ray->t_max);
        is_inside = mpq_cmp(t, limit) < 0;
    }
    mpq_clear(limit);
    return is_inside;
}

struct exact_hit exact_triangle(const struct trace_ray *ray, const float corners[9])
{
    struct exact_hit hit = {EXACT_OUTSIDE, 0, false};
    mpq_t p[3][3], d[3], edge[3], sum, t;
    set_up(ray, corners, p, d);
    init_all(edge, 3);
    mpq_inits(sum, t, NULL);
    int negative = 0, positive = 0;
    for (int i = 0; i < 3; i++) {
        triple_product(edge[i], d, p[(i + 1) % 3], p[(i + 2) % 3]);
        mpq_add(sum, sum, edge[i]);
        negative += mpq_sgn(edge[i]) < 0;
        positive += mpq_sgn(edge[i]) > 0;
    }
    if ((negative == 0 || positive == 0) && mpq_sgn(sum) != 0) {
        triple_product(t, p[0], p[1], p[2]);
        mpq_div(t, t, sum);
        if (is_between(ray, t)) {
            hit.class = negative + positive == 3 ? EXACT_INSIDE : EXACT_BOUNDARY;
            hit.t = mpq_get_d(t);
            hit.front_face = mpq_sgn(sum) < 0;
        }
    }
    mpq_clears(sum, t, NULL);
    clear_all(edge, 3);
    for (int i = 0; i < 3; i++)
        clear_all(p[i], 3);
    clear_all(d, 3);
    return hit;
}

/* to = a . b */
static void dot_product(mpq_t to, const mpq_t a[3], const mpq_t b[3])
{
    mpq_t term;
    mpq_init(term);
    mpq_set_ui(to, 0, 1);
    for (int i = 0; i < 3; i++) {
        mpq_mul(term, a[i], b[i]);
        mpq_add(to, to, term);
    }
    mpq_clear(term);
}

/* outside / (along + sqrt(discriminant)), far more precisely than a double is. */
static double entry(const mpq_t outside, const mpq_t along, const mpq_t discriminant)
{
    mpf_t root, other;
    mpf_init2(root, 256);
    mpf_init2(other, 256);
    mpf_set_q(root, discriminant);
    mpf_sqrt(root, root);
    mpf_set_q(other, along);
    mpf_add(root, root, other);
    mpf_set_q(other, outside);
    mpf_div(root, other, root);
    double t = mpf_get_d(root);
    mpf_clear(root);
    mpf_clear(other);
    return t;
}

/* With F from origin to center: t^2 d.d - 2 t F.d + F.F - r^2 = 0. */
struct exact_hit exact_sphere(const struct trace_ray *ray, const float center[3], float radius)
{
    struct exact_hit hit = {EXACT_OUTSIDE, 0, false};
    mpq_t f[3], d[3], length, along, outside, discriminant;
    init_all(f, 3);
    init_all(d, 3);
    mpq_inits(length, along, outside, discriminant, NULL);
    for (int i = 0; i < 3; i++) {
        mpq_set_d(d[i], ray->origin[i]);
        mpq_set_d(f[i], center[i]);
        mpq_sub(f[i], f[i], d[i]);
        mpq_set_d(d[i], ray->direction[i]);
    }
    dot_product(length, d, d);
    dot_product(along, f, d);
    dot_product(outside, f, f);
    mpq_set_d(discriminant, radius);
    mpq_mul(discriminant, discriminant, discriminant);
    mpq_sub(outside, outside, discriminant);
    mpq_mul(length, length, outside);
    mpq_mul(discriminant, along, along);
    mpq_sub(discriminant, discriminant, length);
    if (mpq_sgn(discriminant) >= 0 && mpq_sgn(along) > 0 && mpq_sgn(outside) >= 0) {
        hit.t = entry(outside, along, discriminant);
        bool is_between = hit.t >= ray->t_min && hit.t <= ray->t_max;
        if (is_between)
            hit.class = mpq_sgn(discriminant) > 0 ? EXACT_INSIDE : EXACT_BOUNDARY;
    }
    mpq_clears(length, along, outside, discriminant, NULL);
    clear_all(f, 3);
    clear_all(d, 3);
    return hit;
}

int exact_determinant_sign(const VkTransformMatrixKHR *transform)
{
    mpq_t rows[3][3], value;
    mpq_init(value);
    for (int row = 0; row < 3; row++) {
        init_all(rows[row], 3);
        for (int i = 0; i < 3; i++)
            mpq_set_d(rows[row][i], transform->matrix[row][i]);
    }
    triple_product(value, rows[0], rows[1], rows[2]);
    int sign = mpq_sgn(value);
    mpq_clear(value);
    for (int row = 0; row < 3; row++)
        clear_all(rows[row], 3);
    return sign;
}
