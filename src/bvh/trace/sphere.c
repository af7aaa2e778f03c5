/* SPDX-License-Identifier: Apache-2.0 */
/* Spheres and linear swept spheres: finds where a ray enters them. A ray that starts inside a shape
 * does not hit it.
 *
 * At accuracy exact, whether the line hits a sphere, and whether the origin lies inside it, are
 * decided exactly; everything else is computed in double. The spheres of a swept sphere have
 * centers P + s A and radii r - s e for s from 0 to 1. The sphere nearest to a point M (relative to
 * P) has s = w / D with w = M . A - e r and D = A . A - e e. The surface of the midsection is
 * therefore D (M . M - r r) - w w = 0 with s from 0 to 1; the rest belongs to the caps. */
#include "src/bvh/expansion.h"
#include "src/bvh/trace/ray.h"

/* Error bound for terms whose magnitudes sum to 1: about ten roundings of 2^-53 each. */
#define SPHERE_BOUND (32 * 0x1p-53)

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

struct exact_vector {
    double terms[3][2];
    int count[3];
};

/* Computes the sum of the squares of three expansions. */
static int sum_of_squares(double *const terms[3], const int count[3], double *to, double *spare)
{
    double square[3][128];
    int n[3];
    for (int i = 0; i < 3; i++)
        n[i] = expansion_product(count[i], terms[i], count[i], terms[i], square[i]);
    int m = expansion_sum(n[0], square[0], n[1], square[1], spare);
    return expansion_sum(m, spare, n[2], square[2], to);
}

static void exact_offset(const struct local_ray *ray, const float center[3],
                         struct exact_vector *offset)
{
    for (int i = 0; i < 3; i++)
        offset->count[i] = expansion_difference(center[i], ray->origin[i], offset->terms[i]);
}

/* Returns an estimate of |center - origin|^2 - radius^2 with the exact sign. */
static double exact_outside(const struct local_ray *ray, const float center[3], float radius)
{
    struct exact_vector offset;
    double sum[24], spare[16], square = (double)radius * radius, difference[25];
    exact_offset(ray, center, &offset);
    double *const terms[3] = {offset.terms[0], offset.terms[1], offset.terms[2]};
    int n = sum_of_squares(terms, offset.count, sum, spare);
    int m = expansion_subtract(n, sum, square != 0, &square, difference);
    return expansion_estimate(m, difference);
}

/* Returns the sign of |direction|^2 radius^2 - |offset x direction|^2. */
static int exact_meets(const struct local_ray *ray, const float center[3], float radius)
{
    struct exact_vector offset;
    double cross[3][8], squares[384], spare[256], length[6], scaled[12], difference[396];
    int count[3];
    exact_offset(ray, center, &offset);
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        double a[4], b[4];
        int m = expansion_scale(offset.count[j], offset.terms[j], ray->direction[k], a);
        int n = expansion_scale(offset.count[k], offset.terms[k], ray->direction[j], b);
        count[i] = expansion_subtract(m, a, n, b, cross[i]);
    }
    double *const terms[3] = {cross[0], cross[1], cross[2]};
    int n = sum_of_squares(terms, count, squares, spare);
    double direction[3][1], *const parts[3] = {direction[0], direction[1], direction[2]};
    int ones[3];
    for (int i = 0; i < 3; i++) {
        direction[i][0] = ray->direction[i];
        ones[i] = ray->direction[i] != 0;
    }
    int m = sum_of_squares(parts, ones, length, spare);
    m = expansion_scale(m, length, (double)radius * radius, scaled);
    m = expansion_subtract(m, scaled, n, squares, difference);
    return expansion_sign(m, difference);
}

/* Finds where the ray enters the sphere from outside. Returns false if it does not, or if the entry
 * is behind the origin. */
static bool enter_sphere(const struct local_ray *ray, const float center[3], float radius,
                         bool is_exact, double *t, uint64_t *exact_calls)
{
    double offset[3], across[3], r2 = (double)radius * radius;
    for (int i = 0; i < 3; i++)
        offset[i] = center[i] - ray->origin[i];
    double length = dot(ray->direction, ray->direction), along = dot(offset, ray->direction);
    for (int i = 0; i < 3; i++)
        across[i] = offset[i] - along / length * ray->direction[i];
    double distance = dot(offset, offset), outside = distance - r2;
    double meets = r2 - dot(across, across), bound = SPHERE_BOUND * (distance + r2);
    if (!(along > 0) || !(distance < INFINITY))
        return false;
    if (is_exact && fabs(outside) <= bound) {
        ++*exact_calls;
        outside = exact_outside(ray, center, radius);
    }
    if (outside < 0)
        return false;
    if (is_exact && fabs(meets) <= bound) {
        ++*exact_calls;
        meets = exact_meets(ray, center, radius) < 0 ? -1 : fmax(meets, 0);
    }
    if (!(meets >= 0))
        return false;
    *t = outside / (along + sqrt(length * meets));
    return true;
}

static bool is_within(const struct local_ray *ray, double t, double t_max)
{
    return t >= ray->t_min && t <= t_max && t < INFINITY;
}

bool sphere_hit(const struct local_ray *ray, const struct sphere_record *sphere, bool is_exact,
                double t_max, struct local_hit *hit, uint64_t *exact_calls)
{
    *hit = (struct local_hit){.t = 0};
    return enter_sphere(ray, sphere->center, sphere->radius, is_exact, &hit->t, exact_calls) &&
           is_within(ray, hit->t, t_max);
}

/* The midsection, relative to the point of the ray that is nearest to the first center. */
struct section {
    double start;          /* distance of that point */
    double axis[3];        /* A */
    double shrink, stable; /* e and D; without a midsection D is not positive */
    double w, w_rate;      /* w at that point, and its change per unit of distance */
    double length, along, outside;
    /* Tolerance of s, which prevents rays from passing between the midsection and its caps. */
    double slack;
};

static void make_section(const struct local_ray *ray, const struct swept_record *swept,
                         struct section *section)
{
    double to[3];
    for (int i = 0; i < 3; i++) {
        section->axis[i] = (double)swept->b[i] - swept->a[i];
        to[i] = ray->origin[i] - swept->a[i];
    }
    section->length = dot(ray->direction, ray->direction);
    section->start = -dot(to, ray->direction) / section->length;
    double distance = sqrt(dot(to, to));
    for (int i = 0; i < 3; i++)
        to[i] += section->start * ray->direction[i];
    double radius = swept->radius[0];
    section->shrink = radius - swept->radius[1];
    section->stable = dot(section->axis, section->axis) - section->shrink * section->shrink;
    section->w = dot(to, section->axis) - section->shrink * radius;
    section->w_rate = dot(ray->direction, section->axis);
    section->slack =
        0x1p-40 + 0x1p-46 * distance * sqrt(dot(section->axis, section->axis)) / section->stable;
    section->along = dot(to, ray->direction); /* 0 except for rounding */
    section->outside = dot(to, to) - radius * radius;
}

/* Solves A t^2 + 2 B t + C = 0 for the root at which the value changes from positive (outside) to
 * negative (inside). */
static bool enter_section(const struct section *section, double *t)
{
    double d = section->stable;
    double a = d * section->length - section->w_rate * section->w_rate;
    double b = d * section->along - section->w * section->w_rate;
    double c = d * section->outside - section->w * section->w;
    double discriminant = b * b - a * c;
    if (!(discriminant >= 0))
        return false;
    double root = sqrt(discriminant);
    *t = b < 0 ? c / (root - b) : (-b - root) / a;
    return isfinite(*t);
}

/* The part of a cap's sphere beyond the seam lies inside the midsection. */
static bool enter_cap(const struct local_ray *ray, const struct swept_record *swept, int end,
                      const struct section *section, bool is_exact, double *t,
                      uint64_t *exact_calls)
{
    const float *center = end == 0 ? swept->a : swept->b;
    if (!(swept->caps & (end == 0 ? SWEPT_CAP_FIRST : SWEPT_CAP_LAST)) ||
        !enter_sphere(ray, center, swept->radius[end], is_exact, t, exact_calls))
        return false;
    double s = (section->w + (*t - section->start) * section->w_rate) / section->stable;
    return end == 0 ? s <= section->slack : s >= 1 - section->slack;
}

/* If one end contains the other, the shape is the larger sphere. */
static bool enter_only_cap(const struct local_ray *ray, const struct swept_record *swept,
                           bool is_exact, struct local_hit *hit, uint64_t *exact_calls)
{
    int end = swept->radius[1] > swept->radius[0];
    const float *center = end == 0 ? swept->a : swept->b;
    hit->u = (float)end;
    return swept->caps & (end == 0 ? SWEPT_CAP_FIRST : SWEPT_CAP_LAST) &&
           enter_sphere(ray, center, swept->radius[end], is_exact, &hit->t, exact_calls);
}

bool swept_hit(const struct local_ray *ray, const struct swept_record *swept, bool is_exact,
               double t_max, struct local_hit *hit, uint64_t *exact_calls)
{
    struct section section;
    double t;
    *hit = (struct local_hit){.t = INFINITY};
    make_section(ray, swept, &section);
    if (!(section.stable > 0))
        return enter_only_cap(ray, swept, is_exact, hit, exact_calls) &&
               is_within(ray, hit->t, t_max);
    if (enter_section(&section, &t)) {
        double s = (section.w + t * section.w_rate) / section.stable;
        if (s >= 0 && s <= 1)
            *hit = (struct local_hit){.t = t + section.start, .u = (float)s};
    }
    for (int end = 0; end < 2; end++)
        if (enter_cap(ray, swept, end, &section, is_exact, &t, exact_calls) && t < hit->t)
            *hit = (struct local_hit){.t = t, .u = (float)end};
    return is_within(ray, hit->t, t_max);
}
