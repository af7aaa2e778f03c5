/* SPDX-License-Identifier: Apache-2.0 */
/* Finds inputs that are numerically fragile, and how many rays accuracy robust gets wrong because
 * of them. Each kind is the kind of some cases of tests/numeric (tests/scene/hard_cases_test.c). */
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "src/base/array.h"
#include "src/scene/report/report.h"

/* Name of the kind, what the figure is, and what a reader should know. */
#define FRAGILE_LIST(X)                                                                            \
    X(INACTIVE, "inactive", "", "NaN in X: no ray hits them")                                      \
    X(NAN_YZ, "NaN in Y or Z", "", "undefined by the specification")                               \
    X(OUT_OF_RANGE, "index out of range", "", "never read by the reference builder")               \
    X(REPEATED, "two corners at one position", "", "no ray hits them")                             \
    X(COLLINEAR, "corners on one line", "", "no ray hits them; in float some do")                  \
    X(FLOAT_FLAT, "area that is 0 in float", "longest edge",                                       \
      "drivers that compute in float miss them")                                                   \
    X(SLIVER, "sliver", "length by height", "rounding decides hits")                               \
    X(TINY, "products of coordinates underflow", "longest edge", "areas are 0 in float")           \
    X(HUGE_NUMBERS, "products of coordinates overflow", "largest coordinate",                      \
      "areas are infinite in float")                                                               \
    X(FAR_AWAY, "far from the origin", "coordinate by size",                                       \
      "coordinates have few bits left for the shape")                                              \
    X(SMALL_BESIDE_LARGE, "small beside large", "size of all by size",                             \
      "below the resolution of the structure's coordinates")                                       \
    X(COINCIDENT, "coincident triangles", "triangles at one place", "any of them may be hit")      \
    X(ONE_CENTER, "one center", "primitives at one place", "no plane separates them")              \
    X(NO_EXTENT, "axis without extent", "", "boxes are flat")                                      \
    X(OUTLIER, "outlier", "distance by that of 9 in 10",                                           \
      "codes along a curve have few bits for the rest")                                            \
    X(OPEN_EDGE, "open edges", "", "a ray at one may hit or miss")                                 \
    X(SHARED_EDGE, "shared edges", "", "in float a ray at one may hit both sides or none")         \
    X(T_JUNCTION, "T-junction", "gap by edge", "rays pass between, at every accuracy")             \
    X(CRACK, "crack", "gap by edge", "rays pass between, at every accuracy")                       \
    X(REVERSED_BOX, "minimum above maximum", "", "invalid: VUID-VkAabbPositionsKHR-minX-03546")    \
    X(POINT_BOX, "box without extent", "", "may be hit or not")                                    \
    X(INFINITE_BOX, "infinite box", "", "every ray is a candidate")                                \
    X(BOX, "boxes", "", "limits of rays are included, and faces are hit from both sides")          \
    X(NO_PRIMITIVE, "nothing active", "", "as instance, a point at its origin")                    \
    X(NULL_INSTANCE, "instance without a structure", "", "inactive")                               \
    X(MASK_ZERO, "mask 0", "", "no ray can hit it")                                                \
    X(SINGULAR, "singular transform", "", "no ray hits it")                                        \
    X(MIRRORED, "mirrored transform", "",                                                          \
      "of instances, faces keep their side; of geometries, not")                                   \
    X(ILL_SCALED, "ill-scaled transform", "largest by smallest scale",                             \
      "its inverse loses bits or overflows")                                                       \
    X(NOT_A_NUMBER, "transform that is not finite", "", "undefined")                               \
    X(DEEP, "deep tree", "depth", "drivers with a short stack may fail")                           \
    X(COARSE_FORMAT, "positions of 16 bits or fewer", "", "neighbours may fall together")          \
    X(FOURTH_COMPONENT, "fourth component", "", "does not count, even if it is NaN or 0")          \
    X(OFFSETS, "offsets in the build range", "", "drivers have applied them twice or not at all")  \
    X(MOVING, "motion", "", "vertices and matrices are rounded at each ray's time")                \
    X(OPACITY, "opacity micromaps", "", "barycentrics decide the state")                           \
    X(SPHERES, "spheres", "", "silhouettes")                                                       \
    X(DENSE, "dense geometry", "", "positions on a grid")                                          \
    X(DISPLACED, "displacement", "", "vertices are rounded once")
#define NUMBER_OF(kind, name, figure, says) kind,
#define TEXTS_OF(kind, name, figure, says) {name, figure, says},
enum fragile_kind { FRAGILE_LIST(NUMBER_OF) FRAGILE_KINDS };
static const struct {
    const char *name, *figure, *says;
} kinds[FRAGILE_KINDS] = {FRAGILE_LIST(TEXTS_OF)};

#define SLIVER_LEAST 1e4     /* length by height */
#define FAR_LEAST 0x1p16     /* coordinate by size: a float has 8 bits left */
#define SMALL_LEAST 0x1p23   /* size of all by size */
#define OUTLIER_LEAST 0x1p10 /* a Morton code has 10 to 21 bits an axis */
#define GAP_MOST 1e-3        /* by the length of the edge */
#define SCALE_LEAST 1e3
enum {
    ONE_CENTER_LEAST = 8,
    /* of a structure whose edges and places are compared: that takes 300 bytes each */
    NEIGHBOURS_MOST = 1 << 22,
};

const char *fragile_name(uint32_t kind)
{
    return kinds[kind].name;
}

/* ---- the list */

static void add(struct fragile_list *list, enum fragile_kind kind, uint32_t geometry,
                uint32_t primitive, double figure)
{
    uint32_t at = list->count;
    while (at > 0 && (list->items[at - 1].kind != kind || list->items[at - 1].geometry != geometry))
        at--;
    if (at == 0) {
        if (!ARRAY_HAS_ROOM(list->items, list->count, list->capacity))
            capture_allocate(NULL, SIZE_MAX, 2);
        at = ++list->count;
        list->items[at - 1] = (struct fragile){.kind = kind, .geometry = geometry};
    }
    struct fragile *item = &list->items[at - 1];
    const bool is_worst = item->count > 0 && figure > item->figure;
    item->count++;
    item->figure = item->count == 1 || is_worst ? figure : item->figure;
    if (primitive == CAPTURE_NONE || (item->listed == FRAGILE_LISTED && !is_worst))
        return;
    uint32_t place = 0;
    while (place < item->listed && item->primitives[place] != primitive)
        place++;
    if (place == FRAGILE_LISTED)
        place--;
    else if (place == item->listed)
        item->listed++;
    item->primitives[place] = is_worst ? item->primitives[0] : primitive;
    if (is_worst) /* the worst is the first */
        item->primitives[0] = primitive;
}

/* ---- all of a structure: primitives with their centers, and corners by position */

struct item {
    float corners[9];
    uint32_t geometry, primitive;
};
struct whole {
    struct item *items;
    uint32_t count, capacity;
    double lower[3], upper[3];
};

static double size_of(const struct whole *whole)
{
    return fmax(whole->upper[0] - whole->lower[0],
                fmax(whole->upper[1] - whole->lower[1], whole->upper[2] - whole->lower[2]));
}

static void keep(struct whole *whole, const float corners[9], uint32_t geometry, uint32_t primitive)
{
    if (!ARRAY_HAS_ROOM(whole->items, whole->count, whole->capacity))
        capture_allocate(NULL, SIZE_MAX, 2);
    struct item *item = &whole->items[whole->count++];
    *item = (struct item){.geometry = geometry, .primitive = primitive};
    memcpy(item->corners, corners, sizeof(item->corners));
    for (int i = 0; i < 9; i++) {
        whole->lower[i % 3] = fmin(whole->lower[i % 3], corners[i]);
        whole->upper[i % 3] = fmax(whole->upper[i % 3], corners[i]);
    }
}

/* ---- a triangle by itself */

static double length_of(const double v[3])
{
    return hypot(hypot(v[0], v[1]), v[2]);
}

/* The cross product of two edges; `bound` is what rounding may have added. */
static double area_of(const float corners[9], double *bound, double *longest, float *in_float)
{
    double edges[3][3], normal[3];
    float narrow[2][3];
    *bound = 0;
    *longest = 0;
    *in_float = 0;
    for (int i = 0; i < 9; i++)
        edges[i / 3][i % 3] = (double)corners[(i + 3) % 9] - corners[i];
    for (int i = 0; i < 3; i++) {
        *longest = fmax(*longest, length_of(edges[i]));
        narrow[0][i] = corners[3 + i] - corners[i];
        narrow[1][i] = corners[6 + i] - corners[i];
    }
    for (int i = 0; i < 3; i++) {
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        normal[i] = edges[0][j] * edges[1][k] - edges[0][k] * edges[1][j];
        *bound +=
            4 * DBL_EPSILON * (fabs(edges[0][j] * edges[1][k]) + fabs(edges[0][k] * edges[1][j]));
        *in_float += fabsf(narrow[0][j] * narrow[1][k] - narrow[0][k] * narrow[1][j]);
    }
    return length_of(normal);
}

/* Whether the corners are on a line, by numbers of 113 bits: exact unless exponents differ much. */
static bool are_collinear(const float corners[9])
{
    for (int i = 0; i < 3; i++) {
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        const __float128 a = (__float128)corners[3 + j] - corners[j],
                         b = (__float128)corners[6 + k] - corners[k],
                         c = (__float128)corners[3 + k] - corners[k],
                         d = (__float128)corners[6 + j] - corners[j];
        if (a * b != c * d)
            return false;
    }
    return true;
}

static bool is_same(const float *a, const float *b)
{
    return a[0] == b[0] && a[1] == b[1] && a[2] == b[2];
}

static void check_triangle(const float c[9], uint32_t geometry, uint32_t primitive,
                           struct fragile_list *list)
{
    double bound, longest, largest = 0;
    float in_float;
    for (int i = 0; i < 9; i++)
        largest = fmax(largest, fabs((double)c[i]));
    if (!isfinite(largest) || largest > 0x1p62)
        add(list, HUGE_NUMBERS, geometry, primitive, largest);
    if (!isfinite(largest))
        return;
    if (is_same(c, c + 3) || is_same(c, c + 6) || is_same(c + 3, c + 6)) {
        add(list, REPEATED, geometry, primitive, 0);
        return;
    }
    const double area = area_of(c, &bound, &longest, &in_float);
    if (area <= bound && are_collinear(c)) {
        add(list, COLLINEAR, geometry, primitive, longest);
        return;
    }
    if (in_float == 0)
        add(list, FLOAT_FLAT, geometry, primitive, longest);
    if (longest < 0x1p-62)
        add(list, TINY, geometry, primitive, longest);
    else if (longest * longest > SLIVER_LEAST * area)
        add(list, SLIVER, geometry, primitive,
            area > 0 ? longest * longest / area : (double)INFINITY);
    if (largest > FAR_LEAST * longest)
        add(list, FAR_AWAY, geometry, primitive, largest / longest);
}

/* ---- transforms */

static void check_transform(const VkTransformMatrixKHR *transform, uint32_t geometry,
                            uint32_t primitive, double size, struct fragile_list *list)
{
    double sum = 0, most = 0, least = INFINITY, moved = 0;
    for (int column = 0; column < 3; column++) {
        double square = 0;
        for (int row = 0; row < 3; row++) {
            const double value = transform->matrix[row][column];
            square += value * value;
            sum += value + transform->matrix[row][3];
        }
        moved = fmax(moved, fabs((double)transform->matrix[column][3]));
        most = fmax(most, sqrt(square));
        least = fmin(least, sqrt(square));
    }
    if (!isfinite(sum)) {
        add(list, NOT_A_NUMBER, geometry, primitive, 0);
        return;
    }
    const int sign = builder_determinant_sign(transform);
    if (sign == 0)
        add(list, SINGULAR, geometry, primitive, 0);
    if (sign < 0)
        add(list, MIRRORED, geometry, primitive, 0);
    if (sign != 0 && (most > SCALE_LEAST * least || least < 1e-6 || most > 1e6))
        add(list, ILL_SCALED, geometry, primitive, most / least);
    if (size > 0 && moved > FAR_LEAST * size * most)
        add(list, FAR_AWAY, geometry, primitive, moved / (size * most));
}

/* ---- what primitives are to each other */

static int compare_positions(const void *a, const void *b)
{
    const float *x = a, *y = b;
    for (int i = 0; i < 3; i++)
        if (x[i] != y[i])
            return x[i] < y[i] ? -1 : 1;
    return 0;
}

static void center_of(const float corners[9], double center[3])
{
    for (int i = 0; i < 3; i++)
        center[i] = corners[i] / 3.0 + corners[3 + i] / 3.0 + corners[6 + i] / 3.0;
}

/* A key that is equal for things that are: the center, then the corners in order. */
struct keyed {
    float key[12];
    uint32_t item;
};

static int compare_keys(const void *a, const void *b)
{
    const struct keyed *x = a, *y = b;
    for (int i = 0; i < 12; i++)
        if (x->key[i] != y->key[i])
            return x->key[i] < y->key[i] ? -1 : 1;
    return x->item < y->item ? -1 : x->item > y->item;
}

/* Adds groups of `length` equal floats of the keys, which are sorted. */
static void check_groups(const struct whole *whole, const struct keyed *keys, int length,
                         uint32_t least, enum fragile_kind kind, struct fragile_list *list)
{
    for (uint32_t begin = 0, end; begin < whole->count; begin = end) {
        end = begin + 1;
        while (end < whole->count &&
               memcmp(keys[begin].key, keys[end].key, (size_t)length * sizeof(float)) == 0)
            end++;
        for (uint32_t i = begin + (kind == COINCIDENT); i < end && end - begin >= least; i++)
            add(list, kind, whole->items[keys[i].item].geometry,
                whole->items[keys[i].item].primitive, end - begin);
    }
}

static void check_coincidence(const struct whole *whole, bool is_of_boxes,
                              struct fragile_list *list)
{
    struct keyed *keys = capture_allocate(NULL, whole->count + 1ull, sizeof(*keys));
    for (uint32_t i = 0; i < whole->count; i++) {
        double center[3];
        float corners[9];
        memcpy(corners, whole->items[i].corners, sizeof(corners));
        qsort(corners, 3, 3 * sizeof(float), compare_positions);
        center_of(corners, center);
        for (int axis = 0; axis < 3; axis++)
            keys[i].key[axis] = (float)center[axis] + 0.0f;
        for (int n = 0; n < 9; n++)
            keys[i].key[3 + n] = corners[n] + 0.0f;
        keys[i].item = i;
    }
    qsort(keys, whole->count, sizeof(*keys), compare_keys);
    if (!is_of_boxes)
        check_groups(whole, keys, 12, 2, COINCIDENT, list);
    check_groups(whole, keys, 3, ONE_CENTER_LEAST, ONE_CENTER, list);
    free(keys);
}

static int compare_doubles(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* Distances are measured from the median of the centers. */
static void check_spread(const struct whole *whole, struct fragile_list *list)
{
    const double size = size_of(whole);
    const uint32_t count = whole->count;
    double *values = capture_allocate(NULL, count + 1ull, 2 * sizeof(*values)), middle[3],
           center[3];
    for (int axis = 0; axis < 3; axis++) {
        for (uint32_t i = 0; i < count; i++) {
            center_of(whole->items[i].corners, center);
            values[i] = center[axis];
        }
        qsort(values, count, sizeof(*values), compare_doubles);
        middle[axis] = values[count / 2];
        if (size > 0 && whole->upper[axis] == whole->lower[axis])
            add(list, NO_EXTENT, CAPTURE_NONE, CAPTURE_NONE, axis);
    }
    double *distances = values + count;
    for (uint32_t i = 0; i < count; i++) {
        center_of(whole->items[i].corners, center);
        for (int axis = 0; axis < 3; axis++)
            center[axis] -= middle[axis];
        distances[i] = values[i] = length_of(center);
    }
    qsort(values, count, sizeof(*values), compare_doubles);
    const double usual = values[(uint64_t)count * 9 / 10];
    for (uint32_t i = 0; i < count && count >= 3; i++) {
        const struct item *item = &whole->items[i];
        double bound, longest;
        float in_float;
        area_of(item->corners, &bound, &longest, &in_float);
        if (distances[i] > OUTLIER_LEAST * usual && distances[i] > 0 && usual > 0)
            add(list, OUTLIER, item->geometry, item->primitive, distances[i] / usual);
        if (longest > 0 && size > SMALL_LEAST * longest)
            add(list, SMALL_BESIDE_LARGE, item->geometry, item->primitive, size / longest);
    }
    free(values);
}

/* ---- edges */

struct corner { /* a position, by its place among all that differ */
    float at[3];
    uint32_t item, corner;
};
struct edge {
    uint32_t from, to, item; /* `from` < `to`: numbers of positions */
};

static int compare_corners(const void *a, const void *b)
{
    const struct corner *x = a, *y = b;
    const int order = compare_positions(x->at, y->at);
    if (order)
        return order;
    return x->item != y->item ? (x->item < y->item ? -1 : 1) : (x->corner > y->corner) - 1;
}

static int compare_edges(const void *a, const void *b)
{
    const struct edge *x = a, *y = b;
    if (x->from != y->from)
        return x->from < y->from ? -1 : 1;
    if (x->to != y->to)
        return x->to < y->to ? -1 : 1;
    return x->item < y->item ? -1 : x->item > y->item;
}

/* ---- open edges: ends of other open edges that lie on them */

static uint64_t cell_of(const int64_t at[3])
{
    uint64_t hash = 0;
    for (int i = 0; i < 3; i++)
        hash = (hash ^ (uint64_t)at[i]) * 0x9e3779b97f4a7c15;
    return hash;
}

/* The distance of a point from an edge, by its length; `along` is where, from 0 to 1. */
static double gap_of(const float point[3], const float a[3], const float b[3], double *along)
{
    double edge[3], to[3], square = 0, product = 0;
    for (int i = 0; i < 3; i++) {
        edge[i] = (double)b[i] - a[i];
        to[i] = (double)point[i] - a[i];
        square += edge[i] * edge[i];
        product += edge[i] * to[i];
    }
    *along = product / square;
    const double at = fmin(1, fmax(0, *along));
    for (int i = 0; i < 3; i++)
        to[i] -= at * edge[i];
    return length_of(to) / sqrt(square);
}

struct cell_point {
    uint64_t cell;
    uint32_t point;
};

static int compare_cells(const void *a, const void *b)
{
    const struct cell_point *x = a, *y = b;
    if (x->cell != y->cell)
        return x->cell < y->cell ? -1 : 1;
    return x->point < y->point ? -1 : x->point > y->point;
}

static bool is_corner(const struct item *item, const float position[3])
{
    return is_same(item->corners, position) || is_same(item->corners + 3, position) ||
           is_same(item->corners + 6, position);
}

/* Finds points of other open edges that lie on an edge, or beside its ends. */
static void check_opening(const struct whole *whole, const float (*positions)[3],
                          const struct edge *edge, const struct cell_point *points, uint32_t count,
                          double cell, struct fragile_list *list)
{
    enum { CELLS_MOST = 4096 };
    const float *a = positions[edge->from], *b = positions[edge->to];
    const struct item *item = &whole->items[edge->item];
    int64_t low[3], high[3];
    double cells = 1;
    for (int i = 0; i < 3; i++) {
        const double reach = GAP_MOST * fabs((double)b[i] - a[i]) + GAP_MOST * cell;
        low[i] = (int64_t)floor((fmin(a[i], b[i]) - reach) / cell);
        high[i] = (int64_t)floor((fmax(a[i], b[i]) + reach) / cell);
        cells *= (double)(high[i] - low[i] + 1);
    }
    if (cells > CELLS_MOST)
        return;
    int64_t at[3];
    for (at[0] = low[0]; at[0] <= high[0]; at[0]++)
        for (at[1] = low[1]; at[1] <= high[1]; at[1]++)
            for (at[2] = low[2]; at[2] <= high[2]; at[2]++) {
                const uint64_t hash = cell_of(at);
                uint32_t first = 0, last = count;
                while (first < last) {
                    const uint32_t middle = first + (last - first) / 2;
                    if (points[middle].cell < hash)
                        first = middle + 1;
                    else
                        last = middle;
                }
                for (; first < count && points[first].cell == hash; first++) {
                    const uint32_t point = points[first].point;
                    double along;
                    if (point == edge->from || point == edge->to ||
                        is_corner(item, positions[point]))
                        continue;
                    const double gap = gap_of(positions[point], a, b, &along);
                    if (gap > GAP_MOST)
                        continue;
                    const bool is_at_end = along < GAP_MOST || along > 1 - GAP_MOST;
                    add(list, is_at_end ? CRACK : T_JUNCTION, item->geometry, item->primitive, gap);
                }
            }
}

static void check_openings(const struct whole *whole, const float (*positions)[3],
                           const struct edge *edges, uint32_t count, struct fragile_list *list)
{
    struct cell_point *points = capture_allocate(NULL, 2ull * count + 1, sizeof(*points));
    double cell = 0;
    for (uint32_t i = 0; i < count; i++) {
        double edge[3];
        for (int axis = 0; axis < 3; axis++)
            edge[axis] = (double)positions[edges[i].to][axis] - positions[edges[i].from][axis];
        cell += length_of(edge) / count;
    }
    if (!(cell > 0) || !isfinite(cell) || size_of(whole) / cell > 0x1p40)
        count = 0;
    for (uint32_t i = 0; i < 2 * count; i++) {
        const uint32_t point = i % 2 ? edges[i / 2].to : edges[i / 2].from;
        int64_t at[3];
        for (int axis = 0; axis < 3; axis++)
            at[axis] = (int64_t)floor(positions[point][axis] / cell);
        points[i] = (struct cell_point){cell_of(at), point};
    }
    qsort(points, 2ull * count, sizeof(*points), compare_cells);
    uint32_t kept = 0;
    for (uint32_t i = 0; i < 2 * count; i++)
        if (i == 0 || points[i].point != points[i - 1].point ||
            points[i].cell != points[i - 1].cell)
            points[kept++] = points[i];
    for (uint32_t i = 0; i < count; i++)
        check_opening(whole, positions, &edges[i], points, kept, cell, list);
    free(points);
}

static void check_edges(const struct whole *whole, struct fragile_list *list)
{
    struct corner *corners = capture_allocate(NULL, whole->count + 1ull, 3 * sizeof(*corners));
    uint32_t *number = capture_allocate(NULL, whole->count + 1ull, 3 * sizeof(*number));
    float(*positions)[3] = capture_allocate(NULL, whole->count + 1ull, 3 * sizeof(*positions));
    struct edge *edges = capture_allocate(NULL, whole->count + 1ull, 3 * sizeof(*edges));
    uint32_t position_count = 0, edge_count = 0, open_count = 0;
    const uint32_t count = 3 * whole->count;
    for (uint32_t i = 0; i < count; i++) {
        corners[i] = (struct corner){.item = i / 3, .corner = i % 3};
        memcpy(corners[i].at, whole->items[i / 3].corners + 3 * (i % 3), sizeof(corners[i].at));
    }
    qsort(corners, count, sizeof(*corners), compare_corners);
    for (uint32_t i = 0; i < count; i++) {
        if (i == 0 || compare_positions(corners[i - 1].at, corners[i].at) != 0)
            memcpy(positions[position_count++], corners[i].at, sizeof(*positions));
        number[3 * corners[i].item + corners[i].corner] = position_count - 1;
    }
    for (uint32_t i = 0; i < count; i++) {
        const uint32_t a = number[i], b = number[i - i % 3 + (i + 1) % 3];
        if (a != b)
            edges[edge_count++] = (struct edge){a < b ? a : b, a < b ? b : a, i / 3};
    }
    qsort(edges, edge_count, sizeof(*edges), compare_edges);
    for (uint32_t begin = 0, end; begin < edge_count; begin = end) {
        end = begin + 1;
        while (end < edge_count && edges[end].from == edges[begin].from &&
               edges[end].to == edges[begin].to)
            end++;
        const struct item *item = &whole->items[edges[begin].item];
        add(list, end - begin > 1 ? SHARED_EDGE : OPEN_EDGE, item->geometry, item->primitive, 0);
        if (end - begin == 1)
            edges[open_count++] = edges[begin];
    }
    check_openings(whole, (const float(*)[3])positions, edges, open_count, list);
    free(corners);
    free(number);
    free(positions);
    free(edges);
}

/* ---- geometries */

static void check_layout(uint32_t index, const struct vertex_format *format,
                         const VkAccelerationStructureBuildRangeInfoKHR *range, uint64_t stride,
                         struct fragile_list *list)
{
    if (range->primitiveOffset || range->firstVertex || range->transformOffset ||
        stride > UINT16_MAX)
        add(list, OFFSETS, index, CAPTURE_NONE, 0);
    switch ((int)format->format) {
    case VK_FORMAT_R16G16B16A16_SFLOAT:
    case VK_FORMAT_R16G16B16A16_SNORM:
    case VK_FORMAT_R16G16B16A16_UNORM:
        add(list, COARSE_FORMAT, index, CAPTURE_NONE, 0);
        /* fall through */
    case VK_FORMAT_R32G32B32A32_SFLOAT:
        add(list, FOURTH_COMPONENT, index, CAPTURE_NONE, 0);
        break;
    case VK_FORMAT_R32G32_SFLOAT:
    case VK_FORMAT_R32G32B32_SFLOAT:
        break;
    default:
        add(list, COARSE_FORMAT, index, CAPTURE_NONE, 0);
    }
}

static void check_triangles(const struct builder_geometry *geometry,
                            const VkAccelerationStructureBuildRangeInfoKHR *range, uint32_t index,
                            struct whole *whole, struct fragile_list *list)
{
    const struct builder_triangles *triangles = &geometry->triangles;
    struct source source;
    if (!source_open(&source, false, geometry, range)) {
        add(list, OUT_OF_RANGE, index, CAPTURE_NONE, 0);
        return;
    }
    check_layout(index, source.format, range, triangles->vertex_stride, list);
    if (triangles->motion_vertices)
        add(list, MOVING, index, CAPTURE_NONE, 0);
    if (triangles->opacity)
        add(list, OPACITY, index, CAPTURE_NONE, 0);
    if (triangles->displacement)
        add(list, DISPLACED, index, CAPTURE_NONE, 0);
    if (source.has_transform)
        check_transform(&source.transform, index, CAPTURE_NONE, 0, list);
    for (uint32_t i = 0; i < range->primitiveCount; i++) {
        struct triangle_record record;
        float corners[9];
        const enum source_state state = source_triangle(&source, i, &record);
        if (state == SOURCE_INACTIVE)
            add(list, INACTIVE, index, i, 0);
        else if (state == SOURCE_UNDEFINED)
            add(list, NAN_YZ, index, i, 0);
        else if (state == SOURCE_OUT_OF_RANGE)
            add(list, OUT_OF_RANGE, index, i, 0);
        if (state != SOURCE_ACTIVE)
            continue;
        memcpy(corners, record.a, sizeof(record.a));
        memcpy(corners + 3, record.b, sizeof(record.b));
        memcpy(corners + 6, record.c, sizeof(record.c));
        check_triangle(corners, index, i, list);
        keep(whole, corners, index, i);
    }
}

static void check_boxes(const struct builder_geometry *geometry,
                        const VkAccelerationStructureBuildRangeInfoKHR *range, uint32_t index,
                        struct whole *whole, struct fragile_list *list)
{
    for (uint32_t i = 0; i < range->primitiveCount; i++) {
        const uint64_t at = range->primitiveOffset + i * geometry->aabbs.stride;
        VkAabbPositionsKHR box;
        if (at > geometry->aabbs.size || geometry->aabbs.size - at < sizeof(box)) {
            add(list, OUT_OF_RANGE, index, i, 0);
            continue;
        }
        memcpy(&box, (const uint8_t *)geometry->aabbs.data + at, sizeof(box));
        if (isnan(box.minX)) {
            add(list, INACTIVE, index, i, 0);
            continue;
        }
        const double extent[3] = {(double)box.maxX - box.minX, (double)box.maxY - box.minY,
                                  (double)box.maxZ - box.minZ};
        const bool has_nan = isnan(extent[0] + extent[1] + extent[2]);
        add(list, BOX, index, i, 0);
        if (has_nan && !isinf(box.minX))
            add(list, NAN_YZ, index, i, 0);
        if (extent[0] < 0 || extent[1] < 0 || extent[2] < 0)
            add(list, REVERSED_BOX, index, i, 0);
        if (extent[0] == 0 || extent[1] == 0 || extent[2] == 0)
            add(list, POINT_BOX, index, i, 0);
        if (isinf(extent[0]) || isinf(extent[1]) || isinf(extent[2]))
            add(list, INFINITE_BOX, index, i, 0);
        const float corners[9] = {box.minX, box.minY, box.minZ, box.maxX, box.maxY,
                                  box.maxZ, box.minX, box.minY, box.maxZ};
        if (!has_nan && isfinite(extent[0] + extent[1] + extent[2]))
            keep(whole, corners, index, i);
    }
}

static void check_instances(const struct builder_input *input, uint32_t index,
                            struct fragile_list *list)
{
    const struct builder_geometry *geometry = &input->geometries[index];
    struct source source;
    if (!source_open(&source, false, geometry, &input->ranges[index]))
        return;
    if (input->flags & VK_BUILD_ACCELERATION_STRUCTURE_MOTION_BIT_NV) {
        add(list, MOVING, index, CAPTURE_NONE, 0);
        return;
    }
    for (uint32_t i = 0; i < input->ranges[index].primitiveCount; i++) {
        VkAccelerationStructureInstanceKHR instance;
        const void *at = (const uint8_t *)geometry->instances.data +
                         input->ranges[index].primitiveOffset + i * sizeof(instance);
        if (geometry->instances.array_of_pointers) {
            uint64_t pointer;
            memcpy(&pointer,
                   (const uint8_t *)geometry->instances.data +
                       input->ranges[index].primitiveOffset + i * sizeof(pointer),
                   sizeof(pointer));
            at = input->memory.read
                     ? input->memory.read(input->memory.context, pointer, sizeof(instance))
                     : (const void *)(uintptr_t)pointer;
        }
        if (!at)
            continue;
        memcpy(&instance, at, sizeof(instance));
        const void *mesh = instance.accelerationStructureReference && input->resolver.find
                               ? input->resolver.find(input->resolver.context,
                                                      instance.accelerationStructureReference)
                               : NULL;
        float bounds[2][3];
        double size = 0;
        if (mesh && builder_bounds(mesh, bounds[0], bounds[1]))
            for (int axis = 0; axis < 3; axis++)
                size = fmax(size, (double)bounds[1][axis] - bounds[0][axis]);
        else if (mesh)
            add(list, NO_PRIMITIVE, index, i, 0);
        if (!instance.accelerationStructureReference) {
            add(list, NULL_INSTANCE, index, i, 0);
            continue;
        }
        if (!instance.mask)
            add(list, MASK_ZERO, index, i, 0);
        check_transform(&instance.transform, index, i, size, list);
    }
}

void fragile_find(const struct builder_input *input, const void *tree, struct fragile_list *list)
{
    struct whole whole = {.lower = {INFINITY, INFINITY, INFINITY},
                          .upper = {-INFINITY, -INFINITY, -INFINITY}};
    uint64_t primitives = 0;
    bool is_of_boxes = false;
    for (uint32_t i = 0; i < input->geometry_count; i++) {
        const struct builder_geometry *geometry = &input->geometries[i];
        primitives += input->ranges[i].primitiveCount;
        switch ((int)geometry->type) {
        case VK_GEOMETRY_TYPE_TRIANGLES_KHR:
            check_triangles(geometry, &input->ranges[i], i, &whole, list);
            break;
        case VK_GEOMETRY_TYPE_AABBS_KHR:
            is_of_boxes = true;
            check_boxes(geometry, &input->ranges[i], i, &whole, list);
            break;
        case VK_GEOMETRY_TYPE_INSTANCES_KHR:
            check_instances(input, i, list);
            break;
        case VK_GEOMETRY_TYPE_SPHERES_NV:
        case VK_GEOMETRY_TYPE_LINEAR_SWEPT_SPHERES_NV:
            add(list, SPHERES, i, CAPTURE_NONE, 0);
            break;
        default:
            add(list, DENSE, i, CAPTURE_NONE, 0);
            break;
        }
    }
    if (whole.count)
        check_spread(&whole, list);
    if (whole.count && whole.count <= NEIGHBOURS_MOST) {
        check_coincidence(&whole, is_of_boxes, list);
        if (!is_of_boxes)
            check_edges(&whole, list);
    }
    struct builder_statistics statistics = {.nodes = 0};
    if (tree)
        builder_measure(tree, &statistics);
    /* A tree of eight children whose leaves are full has a third as many levels as log2 says. */
    if (statistics.active > 1 && statistics.depth > log2((double)statistics.active) + 1)
        add(list, DEEP, CAPTURE_NONE, CAPTURE_NONE, statistics.depth);
    if (!primitives || (tree && !statistics.active))
        add(list, NO_PRIMITIVE, CAPTURE_NONE, CAPTURE_NONE, 0);
    free(whole.items);
}

/* ---- the part of the report */

enum { ROWS_OF_KIND = 12, ROWS_OF_USUAL_KIND = 3, AIMED_RAYS = 4096 };
#define WORK_MOST 5000000u /* nodes and primitives of the rays of a row */

struct found {
    uint32_t mesh; /* CAPTURE_NONE: the top level */
    struct fragile item;
    struct wrong robust;
};
struct search {
    struct report *report;
    struct fragile_list *lists; /* of each mesh */
    struct found *found;
};

/* What the captured build had that the input of the mesh has no more: ranges, formats and
 * geometries of other types. Triangles without data are inactive in the input. */
static void find_in_build(const struct report *report, const struct report_mesh *mesh,
                          struct fragile_list *list)
{
    const struct captured_command *build = &report->capture->commands[mesh->command];
    for (uint32_t i = 0; i < build->geometry_count; i++) {
        const struct captured_geometry *geometry = &build->geometries[i];
        const VkAccelerationStructureBuildRangeInfoKHR range = {
            geometry->primitive_count, geometry->primitive_offset, geometry->first_vertex,
            geometry->transform_offset};
        const struct vertex_format *format = vertex_format_named(geometry->vertex_format);
        if (geometry->type == CAPTURE_TRIANGLES && format)
            check_layout(i, format, &range, geometry->vertex_stride, list);
        if (geometry->type == CAPTURE_SPHERES || geometry->type == CAPTURE_SWEPT_SPHERES)
            add(list, SPHERES, i, CAPTURE_NONE, 0);
        if (geometry->type == CAPTURE_DENSE_TRIANGLES)
            add(list, DENSE, i, CAPTURE_NONE, 0);
        if (capture_input_of(geometry, CAPTURE_OPACITY_INDICES))
            add(list, OPACITY, i, CAPTURE_NONE, 0);
        if (capture_input_of(geometry, CAPTURE_DISPLACEMENTS))
            add(list, DISPLACED, i, CAPTURE_NONE, 0);
        for (uint32_t n = 0; n < list->count && mesh->missing[i]; n++)
            if (list->items[n].kind == INACTIVE && list->items[n].geometry == i) {
                list->items[n].count -= mesh->missing[i];
                if (!list->items[n].count) /* what the build read beyond its data */
                    list->items[n].kind = OUT_OF_RANGE;
                list->items[n].count += list->items[n].kind == OUT_OF_RANGE ? mesh->missing[i] : 0;
                break;
            }
    }
}

static void find_in_mesh(void *context, uint32_t index)
{
    const struct search *search = context;
    const struct report_mesh *mesh = &search->report->meshes[index];
    fragile_find(&mesh->input, mesh->tree, &search->lists[index]);
    find_in_build(search->report, mesh, &search->lists[index]);
}

static bool is_of_edges(uint32_t kind)
{
    return kind == OPEN_EDGE || kind == SHARED_EDGE || kind == T_JUNCTION || kind == CRACK;
}

/* Finds a primitive of what a row lists, and its instance. */
static const struct report_mesh *choose(const struct report *report, const struct found *found,
                                        uint64_t *random, uint32_t *geometry, uint32_t *primitive,
                                        const VkAccelerationStructureInstanceKHR **instance)
{
    const uint32_t listed = found->item.primitives[rays_random(random) % found->item.listed];
    *instance = NULL;
    *geometry = found->item.geometry;
    *primitive = listed;
    if (found->mesh != CAPTURE_NONE)
        return &report->meshes[found->mesh];
    *instance = &report->instances[listed];
    *geometry = 0;
    if (!(*instance)->accelerationStructureReference)
        return NULL;
    const struct report_mesh *mesh =
        &report->meshes[(*instance)->accelerationStructureReference - 1];
    const uint32_t count = mesh->input.geometry_count ? mesh->input.ranges[0].primitiveCount : 0;
    *primitive = count ? (uint32_t)(rays_random(random) % count) : 0;
    return count ? mesh : NULL;
}

/* Traces rays at the primitives of a row: those of a mesh in its own space. */
static void trace_row(void *context, uint32_t index)
{
    const struct search *search = context;
    struct found *found = &search->found[index];
    const uint32_t asked = search->report->options->rays,
                   rays = asked && asked < AIMED_RAYS ? asked : AIMED_RAYS;
    struct trace_counters work = {0};
    uint64_t random = index;
    for (uint32_t i = 0; found->item.listed && i < rays && work.nodes + work.primitives < WORK_MOST;
         i++) {
        const VkAccelerationStructureInstanceKHR *instance;
        struct trace_ray ray;
        struct answer truth, answer;
        uint32_t geometry, primitive;
        const struct report_mesh *mesh =
            choose(search->report, found, &random, &geometry, &primitive, &instance);
        if (!mesh || !mesh->tree ||
            !rays_aim(mesh, geometry, primitive, is_of_edges(found->item.kind), instance, &random,
                      &ray))
            continue;
        struct trace_scene scene = report_scene(search->report, TRACE_EXACT);
        scene.counters = &work;
        if (!instance)
            scene.structure = mesh->tree;
        answer_find(&scene, &ray, &truth);
        scene.accuracy = TRACE_ROBUST;
        answer_find(&scene, &ray, &answer);
        wrong_add(&found->robust, &truth, &answer);
    }
}

/* By kind, the worst first. */
static int compare_found(const void *a, const void *b)
{
    const struct found *x = a, *y = b;
    if (x->item.kind != y->item.kind)
        return x->item.kind < y->item.kind ? -1 : 1;
    if (x->item.figure != y->item.figure)
        return x->item.figure > y->item.figure ? -1 : 1;
    if (x->item.count != y->item.count)
        return x->item.count > y->item.count ? -1 : 1;
    if (x->mesh != y->mesh)
        return x->mesh < y->mesh ? -1 : 1;
    return x->item.geometry < y->item.geometry ? -1 : x->item.geometry > y->item.geometry;
}

static json_t *make_row(const struct report *report, const struct found *found)
{
    const struct fragile *item = &found->item;
    const uint32_t structure =
        found->mesh == CAPTURE_NONE ? report->top : report->meshes[found->mesh].structure;
    json_t *primitives = json_array(),
           *row = json_pack("{s:s, s:s, s:I}", "kind", kinds[item->kind].name, "says",
                            kinds[item->kind].says, "count", (json_int_t)item->count);
    for (uint32_t i = 0; i < item->listed && i < 8; i++)
        json_array_append_new(primitives, json_integer(item->primitives[i]));
    if (structure != CAPTURE_NONE)
        json_object_update_new(row, json_pack("{s:I, s:s}", "structure",
                                              (json_int_t)report->capture->structures[structure].id,
                                              "name", report_name(report, structure)));
    if (item->geometry != CAPTURE_NONE)
        json_object_set_new(row, "geometry", json_integer(item->geometry));
    json_object_set_new(row, found->mesh == CAPTURE_NONE ? "instances" : "primitives", primitives);
    if (kinds[item->kind].figure[0])
        json_object_update_new(
            row,
            json_pack("{s:s, s:o}", "figure of", kinds[item->kind].figure, "figure",
                      isfinite(item->figure) ? json_real(item->figure) : json_string("infinite")));
    if (found->robust.rays)
        json_object_set_new(row, "robust", wrong_make(&found->robust));
    return row;
}

void fragile_report(struct report *report)
{
    struct search search = {.report = report};
    uint32_t count = 0, shown = 0;
    const struct builder_input top = report_top_input(report, 0);
    report_progress(report, "fragile inputs");
    search.lists = capture_allocate(NULL, report->mesh_count + 1ull, sizeof(*search.lists));
    memset(search.lists, 0, (report->mesh_count + 1ull) * sizeof(*search.lists));
    report_parallel(report->mesh_count, find_in_mesh, &search);
    if (report->top != CAPTURE_NONE)
        fragile_find(&top, report->tree, &search.lists[report->mesh_count]);
    for (uint32_t i = 0; i <= report->mesh_count; i++)
        count += search.lists[i].count;
    search.found = capture_allocate(NULL, count + 1ull, sizeof(*search.found));
    count = 0;
    for (uint32_t i = 0; i <= report->mesh_count; i++) {
        for (uint32_t n = 0; n < search.lists[i].count; n++)
            search.found[count++] =
                (struct found){.mesh = i < report->mesh_count ? i : CAPTURE_NONE,
                               .item = search.lists[i].items[n]};
        free(search.lists[i].items);
    }
    qsort(search.found, count, sizeof(*search.found), compare_found);
    json_t *rows = json_array(), *more = json_array();
    for (uint32_t begin = 0, end; begin < count; begin = end) {
        const uint32_t kind = search.found[begin].item.kind,
                       most = kind == OPEN_EDGE || kind == SHARED_EDGE || kind == BOX
                                  ? ROWS_OF_USUAL_KIND
                                  : ROWS_OF_KIND;
        uint64_t sum = 0;
        for (end = begin; end < count && search.found[end].item.kind == kind; end++)
            if (end - begin < most)
                search.found[shown++] = search.found[end];
            else
                sum += search.found[end].item.count;
        if (end - begin > most)
            json_array_append_new(more,
                                  json_pack("{s:s, s:i, s:I}", "kind", kinds[kind].name, "rows",
                                            (int)(end - begin - most), "count", (json_int_t)sum));
    }
    report_parallel(shown, trace_row, &search);
    for (uint32_t i = 0; i < shown; i++)
        json_array_append_new(rows, make_row(report, &search.found[i]));
    json_object_set_new(report->root, "fragile",
                        json_pack("{s:o, s:o}", "rows", rows, "more", more));
    free(search.lists);
    free(search.found);
}
