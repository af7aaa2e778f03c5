/* SPDX-License-Identifier: Apache-2.0 */
/* Brute force in rational arithmetic. Functions keep the numbers that they compute with: one thread
 * calls them, again and again. */
#include "exact.h"

#include <gmp.h>
#include <math.h>
#include <string.h>

#include "tests/builder/digest.h"

static void set_up(mpq_t *numbers, int count)
{
    for (int i = 0; i < count; i++)
        mpq_init(numbers[i]);
}

/* Declares `count` numbers, which are set up once. */
#define NUMBERS(name, count)                                                                       \
    static mpq_t name[count];                                                                      \
    static bool is_set_up_##name;                                                                  \
    if (!is_set_up_##name)                                                                         \
        set_up(name, count);                                                                       \
    is_set_up_##name = true

/* to = a . b */
static void dot_product(mpq_t to, const mpq_t a[3], const mpq_t b[3])
{
    NUMBERS(term, 1);
    mpq_set_ui(to, 0, 1);
    for (int i = 0; i < 3; i++) {
        mpq_mul(term[0], a[i], b[i]);
        mpq_add(to, to, term[0]);
    }
}

/* to = a . (b x c) */
static void triple_product(mpq_t to, const mpq_t a[3], const mpq_t b[3], const mpq_t c[3])
{
    NUMBERS(cross, 3);
    NUMBERS(term, 1);
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        mpq_mul(cross[i], b[j], c[k]);
        mpq_mul(term[0], b[k], c[j]);
        mpq_sub(cross[i], cross[i], term[0]);
    }
    dot_product(to, a, cross);
}

static void set_vector(mpq_t to[3], const float from[3])
{
    for (int i = 0; i < 3; i++)
        mpq_set_d(to[i], from[i]);
}

/* to = from - the ray's origin */
static void set_relative(mpq_t to[3], const float from[3], const struct trace_ray *ray)
{
    NUMBERS(origin, 3);
    set_vector(origin, ray->origin);
    set_vector(to, from);
    for (int i = 0; i < 3; i++)
        mpq_sub(to[i], to[i], origin[i]);
}

static bool is_between(const struct trace_ray *ray, const mpq_t t)
{
    NUMBERS(limit, 1);
    mpq_set_d(limit[0], ray->t_min);
    if (mpq_cmp(t, limit[0]) <= 0 || isinf(ray->t_max))
        return mpq_cmp(t, limit[0]) > 0;
    mpq_set_d(limit[0], ray->t_max);
    return mpq_cmp(t, limit[0]) < 0;
}

static struct exact_hit compute_triangle(const struct trace_ray *ray, const float corners[9])
{
    struct exact_hit hit = {EXACT_OUTSIDE, 0, false};
    NUMBERS(corner, 9);
    NUMBERS(d, 3);
    NUMBERS(number, 3);
    mpq_t *p[3] = {corner, corner + 3, corner + 6}, *edge = &number[0], *sum = &number[1],
          *t = &number[2];
    int negative = 0, positive = 0;
    set_vector(d, ray->direction);
    for (int i = 0; i < 3; i++)
        set_relative(p[i], corners + 3 * (size_t)i, ray);
    mpq_set_ui(*sum, 0, 1);
    for (int i = 0; i < 3; i++) {
        triple_product(*edge, d, p[(i + 1) % 3], p[(i + 2) % 3]);
        mpq_add(*sum, *sum, *edge);
        negative += mpq_sgn(*edge) < 0;
        positive += mpq_sgn(*edge) > 0;
    }
    if ((negative > 0 && positive > 0) || mpq_sgn(*sum) == 0)
        return hit;
    triple_product(*t, p[0], p[1], p[2]);
    mpq_div(*t, *t, *sum);
    if (is_between(ray, *t)) {
        hit.class = negative + positive == 3 ? EXACT_INSIDE : EXACT_BOUNDARY;
        hit.t = mpq_get_d(*t);
        hit.front_face = mpq_sgn(*sum) < 0;
    }
    return hit;
}

/* Keeps what was computed: the cases ask the same at each quality and accuracy. */
struct exact_hit exact_triangle(const struct trace_ray *ray, const float corners[9])
{
    enum { KNOWN = 1 << 14 };
    static struct {
        float key[17];
        struct exact_hit hit;
        bool is_known;
    } known[KNOWN];
    float key[17] = {[6] = ray->t_min, [7] = ray->t_max};
    uint64_t digest = DIGEST_BEGIN;
    memcpy(key, ray->origin, sizeof(ray->origin));
    memcpy(key + 3, ray->direction, sizeof(ray->direction));
    memcpy(key + 8, corners, 9 * sizeof(float));
    digest_add(&digest, key, sizeof(key));
    const size_t at = digest % KNOWN;
    if (!known[at].is_known || memcmp(known[at].key, key, sizeof(key)) != 0) {
        memcpy(known[at].key, key, sizeof(key));
        known[at].hit = compute_triangle(ray, corners);
        known[at].is_known = true;
    }
    return known[at].hit;
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
    NUMBERS(f, 3);
    NUMBERS(d, 3);
    NUMBERS(number, 4);
    mpq_t *length = &number[0], *along = &number[1], *outside = &number[2],
          *discriminant = &number[3];
    set_relative(f, center, ray);
    set_vector(d, ray->direction);
    dot_product(*length, d, d);
    dot_product(*along, f, d);
    dot_product(*outside, f, f);
    mpq_set_d(*discriminant, radius);
    mpq_mul(*discriminant, *discriminant, *discriminant);
    mpq_sub(*outside, *outside, *discriminant);
    mpq_mul(*length, *length, *outside);
    mpq_mul(*discriminant, *along, *along);
    mpq_sub(*discriminant, *discriminant, *length);
    if (mpq_sgn(*discriminant) < 0 || mpq_sgn(*along) <= 0 || mpq_sgn(*outside) < 0)
        return hit;
    hit.t = entry(*outside, *along, *discriminant);
    if (hit.t >= ray->t_min && hit.t <= ray->t_max)
        hit.class = mpq_sgn(*discriminant) > 0 ? EXACT_INSIDE : EXACT_BOUNDARY;
    return hit;
}

int exact_determinant_sign(const VkTransformMatrixKHR *transform)
{
    NUMBERS(rows, 9);
    NUMBERS(value, 1);
    for (int row = 0; row < 3; row++)
        set_vector(rows + 3 * (size_t)row, transform->matrix[row]);
    triple_product(value[0], rows, rows + 3, rows + 6);
    return mpq_sgn(value[0]);
}
