/* SPDX-License-Identifier: Apache-2.0 */
#include "src/figures/triangles.h"

#include <float.h>
#include <math.h>
#include <string.h>

enum {
    COARSE_PARTS = 1000, /* a step of more than one of these parts of a triangle is coarse */
    STRAY_PARTS = 1000,  /* without its stray vertex, a geometry has at most one of these parts */
    JUMPING_PARTS = 4,   /* of a geometry: larger triangles jump across it */
    SMALL_PARTS = 32,    /* of a geometry: smaller triangles do not */
    SAMPLES_MIN = 256,   /* fewer triangles prove nothing */
    SAMPLES_MAX = 4096,
    STRIDE_MAX = 128,
};

/* ---- the median. Extents are counted by their binary exponent, so it is known up to 2. */

/* From the difference of two subnormal floats to that of the largest and the smallest float. */
enum { EXPONENT_MIN = -149, EXPONENT_MAX = 128, EXPONENTS = EXPONENT_MAX - EXPONENT_MIN + 1 };

struct extents {
    uint64_t of[EXPONENTS];
};

/* `extent` is a normal double above 0. */
static void count_extent(struct extents *extents, double extent)
{
    uint64_t bits;
    memcpy(&bits, &extent, sizeof(bits));
    extents->of[(int)(bits >> 52) - (DBL_MAX_EXP - 1) - EXPONENT_MIN]++;
}

/* Returns the end of the interval that has the median. */
static double find_median(const struct extents *extents, uint64_t count)
{
    uint64_t before = 0;
    int i = 0;
    while (i < EXPONENTS - 1 && (before += extents->of[i]) * 2 < count)
        i++;
    return ldexp(1, i + EXPONENT_MIN + 1);
}

/* ---- one triangle */

static bool are_equal(const float *a, const float *b)
{
    return a[0] == b[0] && a[1] == b[1] && a[2] == b[2];
}

static bool is_degenerate(const struct triangle_record *triangle)
{
    return are_equal(triangle->a, triangle->b) || are_equal(triangle->b, triangle->c) ||
           are_equal(triangle->c, triangle->a);
}

struct box {
    float lower[3], upper[3];
};

/* Faster than fminf() and fmaxf(), because no position that is measured has NaN. */
static float less_of(float a, float b)
{
    return a < b ? a : b;
}

static float more_of(float a, float b)
{
    return a > b ? a : b;
}

static struct box box_of(const struct triangle_record *triangle)
{
    struct box box;
    for (int i = 0; i < 3; i++) {
        box.lower[i] = less_of(less_of(triangle->a[i], triangle->b[i]), triangle->c[i]);
        box.upper[i] = more_of(more_of(triangle->a[i], triangle->b[i]), triangle->c[i]);
    }
    return box;
}

static double extent_of(const float lower[3], const float upper[3])
{
    double extent = 0;
    for (int i = 0; i < 3; i++) {
        const double side = (double)upper[i] - lower[i];
        extent = side > extent ? side : extent;
    }
    return extent;
}

static float farthest_in(const struct box *box)
{
    float farthest = 0;
    for (int i = 0; i < 3; i++)
        farthest = more_of(farthest, more_of(fabsf(box->lower[i]), fabsf(box->upper[i])));
    return farthest;
}

/* The distance of the floats around a magnitude. */
static double step_at(float magnitude)
{
    uint32_t bits;
    float power;
    memcpy(&bits, &magnitude, sizeof(bits));
    bits &= 0x7f800000;
    memcpy(&power, &bits, sizeof(power));
    return bits ? (double)power * 0x1p-23 : 0x1p-149;
}

/* ---- all triangles */

struct triangle_reading {
    struct triangle_figures *figures;
    struct extents extents;
    bool is_float; /* the format has 32 bits for each coordinate */
};

static void grow(struct triangle_figures *figures, const struct box *box)
{
    if (!figures->measured++) {
        memcpy(figures->lower, box->lower, sizeof(box->lower));
        memcpy(figures->upper, box->upper, sizeof(box->upper));
        return;
    }
    for (int i = 0; i < 3; i++) {
        figures->lower[i] = less_of(figures->lower[i], box->lower[i]);
        figures->upper[i] = more_of(figures->upper[i], box->upper[i]);
    }
}

static void measure(struct triangle_reading *reading, uint32_t primitive,
                    const struct triangle_record *triangle)
{
    struct triangle_figures *figures = reading->figures;
    const struct box box = box_of(triangle);
    const double extent = extent_of(box.lower, box.upper);
    const float farthest = farthest_in(&box);
    if (!isfinite(farthest))
        return;
    grow(figures, &box);
    count_extent(&reading->extents, extent);
    if (!reading->is_float || step_at(farthest) * COARSE_PARTS <= extent)
        return;
    if (!figures->coarse++) {
        figures->first_coarse = primitive;
        figures->smallest_coarse = extent;
    }
}

static void read_triangle(struct triangle_reading *reading, uint32_t primitive,
                          enum source_state state, const struct triangle_record *triangle)
{
    struct triangle_figures *figures = reading->figures;
    if (state == SOURCE_INACTIVE) {
        if (!figures->inactive++)
            figures->first_inactive = primitive;
    } else if (is_degenerate(triangle)) {
        if (!figures->degenerate++)
            figures->first_degenerate = primitive;
    } else {
        measure(reading, primitive, triangle);
    }
}

bool triangle_figures_read(const struct source *source, struct triangle_figures *figures)
{
    *figures = (struct triangle_figures){.count = source->count};
    struct triangle_reading reading = {.figures = figures};
    /* Formats with NaN have floats or halves. Only floats take 8 bytes or more. */
    reading.is_float = source->format->has_nan && source->format->size >= 2 * sizeof(float);
    for (uint32_t i = 0; i < source->count; i++) {
        struct triangle_record triangle;
        const enum source_state state = source_triangle(source, i, &triangle);
        if (state != SOURCE_ACTIVE && state != SOURCE_INACTIVE)
            return false;
        read_triangle(&reading, i, state, &triangle);
    }
    if (!figures->measured)
        return true;
    const struct box all = {{figures->lower[0], figures->lower[1], figures->lower[2]},
                            {figures->upper[0], figures->upper[1], figures->upper[2]}};
    const float farthest = farthest_in(&all);
    figures->extent = extent_of(figures->lower, figures->upper);
    figures->median = find_median(&reading.extents, figures->measured);
    figures->farthest = farthest;
    figures->step = step_at(farthest);
    return true;
}

/* ---- a stray vertex: one of the two ends of the longest side */

struct side {
    int axis;
    float ends[2];
};

static struct side longest_side(const struct triangle_figures *figures)
{
    int axis = 0;
    for (int i = 1; i < 3; i++)
        if ((double)figures->upper[i] - figures->lower[i] >
            (double)figures->upper[axis] - figures->lower[axis])
            axis = i;
    return (struct side){axis, {figures->lower[axis], figures->upper[axis]}};
}

/* What is known of one end: its first position, and the box of all other positions. */
struct suspect {
    bool is_found;
    struct stray_vertex vertex;
    uint64_t others;
    struct box box;
};

static void look_at(struct suspect *suspect, float end, int axis, uint32_t triangle,
                    const float position[3])
{
    if (position[axis] == end && !suspect->is_found) {
        suspect->is_found = true;
        suspect->vertex.triangle = triangle;
        memcpy(suspect->vertex.position, position, sizeof(suspect->vertex.position));
    }
    if (position[axis] == end && are_equal(position, suspect->vertex.position))
        return;
    for (int i = 0; i < 3; i++) {
        struct box *box = &suspect->box;
        box->lower[i] = suspect->others ? less_of(box->lower[i], position[i]) : position[i];
        box->upper[i] = suspect->others ? more_of(box->upper[i], position[i]) : position[i];
    }
    suspect->others++;
}

static bool is_stray(struct suspect *suspect, const struct triangle_figures *figures)
{
    suspect->vertex.extent = extent_of(suspect->box.lower, suspect->box.upper);
    return suspect->is_found && suspect->others &&
           suspect->vertex.extent * STRAY_PARTS <= figures->extent;
}

bool stray_vertex_find(const struct source *source, const struct triangle_figures *figures,
                       struct stray_vertex *stray)
{
    const struct side side = longest_side(figures);
    struct suspect suspects[2] = {0};
    for (uint32_t i = 0; i < source->count; i++) {
        struct triangle_record triangle;
        if (source_triangle(source, i, &triangle) != SOURCE_ACTIVE || is_degenerate(&triangle))
            continue;
        const struct box box = box_of(&triangle);
        if (!isfinite(farthest_in(&box)))
            continue;
        const float *corners[] = {triangle.a, triangle.b, triangle.c};
        for (int j = 0; j < 6; j++)
            look_at(&suspects[j % 2], side.ends[j % 2], side.axis, i, corners[j / 2]);
    }
    for (int i = 0; i < 2; i++) {
        if (is_stray(&suspects[i], figures)) {
            *stray = suspects[i].vertex;
            return true;
        }
    }
    return false;
}

/* ---- another stride */

/* Reads the first triangles. Returns how many of them are in the data. */
static uint64_t sample(const struct source *source, struct triangle_reading *reading)
{
    uint64_t count = 0;
    for (uint32_t i = 0; i < source->count && count < SAMPLES_MAX; i++) {
        struct triangle_record triangle;
        const enum source_state state = source_triangle(source, i, &triangle);
        if (state != SOURCE_OUT_OF_RANGE)
            count++;
        if (state == SOURCE_ACTIVE)
            read_triangle(reading, i, state, &triangle);
    }
    return count;
}

/* How many extents are within a power of two, at most. */
static uint64_t count_within(const struct extents *extents, double most)
{
    uint64_t within = 0;
    for (int i = 0; i < EXPONENTS && ldexp(1, i + EXPONENT_MIN + 1) <= most; i++)
        within += extents->of[i];
    return within;
}

/* Nine of ten triangles are small, and no more than one of ten is degenerate or no triangle. */
static bool is_smooth(const struct source *source, struct other_stride *other)
{
    struct triangle_figures figures = {0};
    struct triangle_reading reading = {.figures = &figures};
    const uint64_t count = sample(source, &reading);
    other->extent = extent_of(figures.lower, figures.upper);
    other->small = other->extent / SMALL_PARTS;
    return count >= SAMPLES_MIN && count_within(&reading.extents, other->small) * 10 >= count * 9;
}

/* If one stride is a multiple of the other, the application may use every second vertex on
 * purpose. */
static bool is_alternative(uint64_t stride, uint64_t other)
{
    return stride % other && other % stride;
}

bool other_stride_find(const struct source *source, const struct triangle_figures *figures,
                       uint64_t size, struct other_stride *other)
{
    const uint32_t step = source->format->size % sizeof(float) ? 2 : sizeof(float);
    struct source read = *source;
    if (!source->stride || figures->measured < SAMPLES_MIN ||
        figures->median < figures->extent / JUMPING_PARTS * 2)
        return false;
    for (read.stride = source->format->size; read.stride <= STRIDE_MAX; read.stride += step) {
        read.index_limit = source_elements_in(size, source->format->size, read.stride);
        other->stride = read.stride;
        if (is_alternative(source->stride, read.stride) && is_smooth(&read, other))
            return true;
    }
    return false;
}
