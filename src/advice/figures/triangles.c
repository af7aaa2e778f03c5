/* SPDX-License-Identifier: Apache-2.0 */
#include "src/advice/figures/triangles.h"

#include <float.h>
#include <math.h>
#include <string.h>

enum {
    COARSE_PARTS = 1000, /* a step of more than one of these parts of a triangle is coarse */
    FAR_TIMES = 8,       /* as far as so many times its extent, a geometry is far from the origin */
    STRAY_PARTS = 1000,  /* without its stray vertex, a geometry has at most one of these parts */
    JUMPING_PARTS = 4,   /* of a geometry: larger triangles jump across it */
    SMALL_PARTS = 32,    /* of a geometry: smaller triangles do not */
    EXTENTS = 128,       /* that the median is of, in a larger geometry */
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

/* ---- all triangles. A first pass finds what each one is, and the box around all. What it costs
 * is most of what advice costs, so the rest looks at a sample, or seldom. */

static void grow_box(struct box *box, const float corner[3])
{
    for (int i = 0; i < 3; i++) {
        box->lower[i] = less_of(box->lower[i], corner[i]);
        box->upper[i] = more_of(box->upper[i], corner[i]);
    }
}

static void count_one(uint64_t *number, uint32_t *first, uint32_t primitive)
{
    if (!(*number)++)
        *first = primitive;
}

static const struct box empty_box = {{INFINITY, INFINITY, INFINITY},
                                     {-INFINITY, -INFINITY, -INFINITY}};

/* Most triangles are plain, and read without a call. */
static enum source_state read_triangle(const struct source *source, uint32_t primitive,
                                       struct triangle_record *triangle)
{
    return source->is_plain && source_read_plain(source, primitive, triangle)
               ? SOURCE_ACTIVE
               : source_triangle(source, primitive, triangle);
}

/* The box may be infinite. Returns as triangle_figures_read(). */
static bool read_all(const struct source *source, struct triangle_figures *figures, struct box *all)
{
    struct box box = empty_box;
    for (uint32_t i = 0; i < source->count; i++) {
        struct triangle_record triangle;
        const enum source_state state = read_triangle(source, i, &triangle);
        if (state == SOURCE_INACTIVE) {
            count_one(&figures->inactive, &figures->first_inactive, i);
        } else if (state == SOURCE_UNDEFINED) {
            count_one(&figures->undefined, &figures->first_undefined, i);
        } else if (state != SOURCE_ACTIVE) {
            return false;
        } else if (is_degenerate(&triangle)) {
            count_one(&figures->degenerate, &figures->first_degenerate, i);
        } else {
            grow_box(&box, triangle.a);
            grow_box(&box, triangle.b);
            grow_box(&box, triangle.c);
            figures->measured++;
        }
    }
    *all = box;
    return true;
}

/* Reads a triangle that is to be measured. Returns false for others. */
static bool find_box(const struct source *source, uint32_t primitive, struct box *box)
{
    struct triangle_record triangle;
    if (read_triangle(source, primitive, &triangle) != SOURCE_ACTIVE || is_degenerate(&triangle))
        return false;
    *box = box_of(&triangle);
    return isfinite(farthest_in(box));
}

/* The triangles whose coordinates are all finite. */
static void measure_finite(const struct source *source, struct triangle_figures *figures,
                           struct box *all)
{
    *all = empty_box;
    figures->measured = 0;
    for (uint32_t i = 0; i < source->count; i++) {
        struct box box;
        if (!find_box(source, i, &box))
            continue;
        grow_box(all, box.lower);
        grow_box(all, box.upper);
        figures->measured++;
    }
}

/* Measures one in so many triangles. Returns how many these are. */
static uint64_t measure_extents(const struct source *source, uint32_t step, struct extents *extents)
{
    uint64_t measured = 0;
    *extents = (struct extents){0};
    for (uint64_t i = 0; i < source->count; i += step) {
        struct box box;
        if (!find_box(source, (uint32_t)i, &box))
            continue;
        count_extent(extents, extent_of(box.lower, box.upper));
        measured++;
    }
    return measured;
}

/* Looks at all triangles if the sample has few that count. The step is odd, because many meshes
 * consist of pairs. */
static double estimate_median(const struct source *source)
{
    const uint32_t step = ((source->count - 1) / EXTENTS + 1) | 1;
    struct extents extents;
    uint64_t measured = measure_extents(source, step, &extents);
    if (step > 1 && measured * 4 < EXTENTS)
        measured = measure_extents(source, 1, &extents);
    return find_median(&extents, measured);
}

static void find_coarse(const struct source *source, struct triangle_figures *figures)
{
    for (uint32_t i = 0; i < source->count; i++) {
        struct box box;
        if (!find_box(source, i, &box))
            continue;
        const double extent = extent_of(box.lower, box.upper);
        if (step_at(farthest_in(&box)) * COARSE_PARTS <= extent)
            continue;
        if (!figures->coarse)
            figures->smallest_coarse = extent;
        count_one(&figures->coarse, &figures->first_coarse, i);
    }
}

static void find_figures(const struct source *source, struct triangle_figures *figures,
                         const struct box *all)
{
    /* Formats with NaN have floats or halves. Only floats take 8 bytes or more. */
    const bool is_float = source->format->has_nan && source->format->size >= 2 * sizeof(float);
    const float farthest = farthest_in(all);
    memcpy(figures->lower, all->lower, sizeof(figures->lower));
    memcpy(figures->upper, all->upper, sizeof(figures->upper));
    figures->extent = extent_of(all->lower, all->upper);
    figures->median = estimate_median(source);
    figures->farthest = farthest;
    figures->step = step_at(farthest);
    if (is_float && figures->farthest >= FAR_TIMES * figures->extent)
        find_coarse(source, figures);
}

bool triangle_figures_read(const struct source *source, struct triangle_figures *figures)
{
    struct box all;
    *figures = (struct triangle_figures){.count = source->count};
    if (!read_all(source, figures, &all))
        return false;
    if (figures->measured && !isfinite(farthest_in(&all)))
        measure_finite(source, figures, &all);
    if (figures->measured)
        find_figures(source, figures, &all);
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

/* Measures the first triangles. Returns how many triangles are in the data. */
static uint64_t sample(const struct source *source, struct extents *extents, struct box *all)
{
    uint64_t count = 0;
    for (uint32_t i = 0; i < source->count && count < SAMPLES_MAX; i++) {
        struct triangle_record triangle;
        struct box box;
        count += source_triangle(source, i, &triangle) != SOURCE_OUT_OF_RANGE;
        if (!find_box(source, i, &box))
            continue;
        count_extent(extents, extent_of(box.lower, box.upper));
        grow_box(all, box.lower);
        grow_box(all, box.upper);
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
    struct extents extents = {0};
    struct box all = empty_box;
    const uint64_t count = sample(source, &extents, &all);
    other->extent = extent_of(all.lower, all.upper);
    other->small = other->extent / SMALL_PARTS;
    return count >= SAMPLES_MIN && count_within(&extents, other->small) * 10 >= count * 9;
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
