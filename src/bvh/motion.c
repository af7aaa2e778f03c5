/* SPDX-License-Identifier: Apache-2.0 */
/* Inverses, world bounds and motion of instance transforms. */
#include "src/bvh/motion.h"

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

/* As instance_bounds(), for all matrices whose elements lie between `low` and `high`.
 *
 * Arvo, "Transforming Axis-Aligned Bounding Boxes", Graphics Gems 1990, in double. A product of two
 * floats is exact; the error of the three sums is below 3 * 2^-53 of the sum of magnitudes. The
 * pad, 2^-20 of that sum, is far larger. It also covers the rounding of rays into object space (to
 * 2^-24 at accuracy robust, to less than 2^-50 at exact) for matrices whose condition is below 2^4
 * at robust and 2^30 at exact. make_slab() pads for the error that grows with the origin. */
static struct box instance_bounds_between(double low[3][4], double high[3][4], const void *blas)
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

/* ---- interpolation of motion, and bounds over all times */

/* Interpolates two floats. The result is exact at times 0 and 1, and lies between the two floats
 * once rounded to float. */
static double mixed(float from, float to, double time)
{
    return from * (1 - time) + to * time;
}

static double clamped_time(float time)
{
    return fmin(fmax(time, 0), 1); /* NaN becomes 0 */
}

void motion_triangle_at(const struct motion_triangle_record *record, float time,
                        struct triangle_record *now)
{
    const struct triangle_record *from = &record->at[0], *to = &record->at[1];
    double timestamp = clamped_time(time);
    *now = *from;
    for (int i = 0; i < 3; i++) {
        now->a[i] = (float)mixed(from->a[i], to->a[i], timestamp);
        now->b[i] = (float)mixed(from->b[i], to->b[i], timestamp);
        now->c[i] = (float)mixed(from->c[i], to->c[i], timestamp);
    }
}

/* An interval. Its ends are not rounded outwards: callers pad the result. */
struct range {
    double low, high;
};

static struct range range_sum(struct range a, struct range b)
{
    return (struct range){a.low + b.low, a.high + b.high};
}

static struct range range_product(struct range a, struct range b)
{
    double w = a.low * b.low, x = a.low * b.high, y = a.high * b.low, z = a.high * b.high;
    return (struct range){fmin(fmin(w, x), fmin(y, z)), fmax(fmax(w, x), fmax(y, z))};
}

static struct range range_times(struct range a, double factor)
{
    return factor < 0 ? (struct range){a.high * factor, a.low * factor}
                      : (struct range){a.low * factor, a.high * factor};
}

/* Returns the interval that an interpolated float covers between two times. */
static struct range range_mixed(float from, float to, const double times[2])
{
    double a = mixed(from, to, times[0]), b = mixed(from, to, times[1]);
    return (struct range){fmin(a, b), fmax(a, b)};
}

/* An element of the rotation: (2 (p q + sign r s) or 1 - 2 (p p + r r)) / |q|^2. */
static struct range rotation_element(struct range value, struct range length)
{
    struct range all = {-1, 1};
    if (!(length.low > 0))
        return all;
    struct range inverse = {1 / length.high, 1 / length.low};
    value = range_product(value, inverse);
    return (struct range){fmax(value.low, all.low), fmin(value.high, all.high)};
}

/* Computes the intervals of the rotation matrix between two times. If both times are equal, the
 * result is exact but for rounding. */
static void rotate(const VkSRTDataNV srt[2], const double times[2], struct range rotation[3][3])
{
    const float from[4] = {srt[0].qx, srt[0].qy, srt[0].qz, srt[0].qw};
    const float to[4] = {srt[1].qx, srt[1].qy, srt[1].qz, srt[1].qw};
    struct range q[4], square[4], length = {0, 0};
    for (int i = 0; i < 4; i++) {
        q[i] = range_mixed(from[i], to[i], times);
        square[i] = range_product(q[i], q[i]);
        if (q[i].low < 0 && q[i].high > 0)
            square[i].low = 0;
        length = range_sum(length, square[i]);
    }
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        struct range others = range_sum(square[j], square[k]);
        struct range diagonal = range_sum(range_sum(square[i], square[3]), range_times(others, -1));
        struct range mutual = range_product(q[i], q[j]), turn = range_product(q[k], q[3]);
        rotation[i][i] = rotation_element(diagonal, length);
        rotation[i][j] =
            rotation_element(range_times(range_sum(mutual, range_times(turn, -1)), 2), length);
        rotation[j][i] = rotation_element(range_times(range_sum(mutual, turn), 2), length);
    }
}

/* Computes the intervals of T R S between two times. */
static void srt_matrix(const VkSRTDataNV srt[2], const double times[2], struct range matrix[3][4])
{
    const VkSRTDataNV *a = &srt[0], *b = &srt[1];
    const struct range none = {0, 0};
    const struct range s[3][4] = {
        {range_mixed(a->sx, b->sx, times), range_mixed(a->a, b->a, times),
         range_mixed(a->b, b->b, times), range_mixed(a->pvx, b->pvx, times)},
        {none, range_mixed(a->sy, b->sy, times), range_mixed(a->c, b->c, times),
         range_mixed(a->pvy, b->pvy, times)},
        {none, none, range_mixed(a->sz, b->sz, times), range_mixed(a->pvz, b->pvz, times)},
    };
    const struct range t[3] = {range_mixed(a->tx, b->tx, times), range_mixed(a->ty, b->ty, times),
                               range_mixed(a->tz, b->tz, times)};
    struct range rotation[3][3];
    rotate(srt, times, rotation);
    for (int row = 0; row < 3; row++)
        for (int column = 0; column < 4; column++) {
            struct range sum = column == 3 ? t[row] : none;
            for (int i = 0; i < 3 && i <= column; i++)
                sum = range_sum(sum, range_product(rotation[row][i], s[i][column]));
            matrix[row][column] = sum;
        }
}

static void transform_at(const struct motion_instance_record *record, double time,
                         VkTransformMatrixKHR *now)
{
    const double times[2] = {time, time};
    struct range matrix[3][4];
    switch (record->type) {
    case VK_ACCELERATION_STRUCTURE_MOTION_INSTANCE_TYPE_MATRIX_MOTION_NV:
        for (int i = 0; i < 12; i++)
            now->matrix[i / 4][i % 4] =
                (float)mixed(record->at.matrix[0].matrix[i / 4][i % 4],
                             record->at.matrix[1].matrix[i / 4][i % 4], time);
        break;
    case VK_ACCELERATION_STRUCTURE_MOTION_INSTANCE_TYPE_SRT_MOTION_NV:
        srt_matrix(record->at.srt, times, matrix);
        for (int i = 0; i < 12; i++)
            now->matrix[i / 4][i % 4] = (float)matrix[i / 4][i % 4].low;
        break;
    default:
        break;
    }
}

void motion_instance_at(const struct motion_instance_record *record, float time,
                        struct instance_record *now)
{
    *now = record->base;
    if (record->type == VK_ACCELERATION_STRUCTURE_MOTION_INSTANCE_TYPE_STATIC_NV)
        return;
    transform_at(record, clamped_time(time), &now->instance.transform);
    instance_invert(&now->instance.transform, now->inverse);
}

/* The bounds of an SRT transform unite the bounds of this number of time steps, each by interval
 * arithmetic. Shorter steps give tighter bounds. */
#define STEPS 32

struct box motion_bounds(const struct motion_instance_record *record, const void *blas)
{
    struct box box = box_empty(), one;
    switch (record->type) {
    case VK_ACCELERATION_STRUCTURE_MOTION_INSTANCE_TYPE_MATRIX_MOTION_NV:
        for (int i = 0; i < 2; i++) {
            one = instance_bounds(&record->at.matrix[i], blas);
            box_add(&box, one.lower, one.upper);
        }
        return box;
    case VK_ACCELERATION_STRUCTURE_MOTION_INSTANCE_TYPE_SRT_MOTION_NV:
        for (int i = 0; i < STEPS; i++) {
            const double times[2] = {(double)i / STEPS, (double)(i + 1) / STEPS};
            struct range matrix[3][4];
            double low[3][4], high[3][4];
            srt_matrix(record->at.srt, times, matrix);
            for (int j = 0; j < 12; j++) {
                low[j / 4][j % 4] = matrix[j / 4][j % 4].low;
                high[j / 4][j % 4] = matrix[j / 4][j % 4].high;
            }
            one = instance_bounds_between(low, high, blas);
            box_add(&box, one.lower, one.upper);
        }
        return box;
    default:
        return instance_bounds(&record->base.instance.transform, blas);
    }
}
