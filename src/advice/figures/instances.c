/* SPDX-License-Identifier: Apache-2.0 */
#include "src/advice/figures/instances.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#define XXH_INLINE_ALL
#include <xxhash.h>

#include "src/bvh/expansion.h"

/* ---- instances that repeat another one */

enum { PLACEMENTS_MAX = 1 << 18 };

/* What was placed where: a hash table, never more than half full. */
struct placements {
    uint64_t mask; /* of places in the table */
    struct placement {
        XXH128_hash_t key;
        uint32_t first;
        uint32_t visible; /* the masks of all that are placed here; 0: the place is empty */
    } items[];
};

static struct placements *make_placements(uint32_t capacity)
{
    uint64_t size = 16;
    while (size < 2 * (uint64_t)capacity)
        size *= 2;
    struct placements *placements =
        capacity <= PLACEMENTS_MAX
            ? calloc(1, sizeof(*placements) + size * sizeof(placements->items[0]))
            : NULL;
    if (placements)
        placements->mask = size - 1;
    return placements;
}

/* The custom index and the mask may differ. */
static XXH128_hash_t key_of(const VkAccelerationStructureInstanceKHR *instance)
{
    VkAccelerationStructureInstanceKHR key = *instance;
    key.instanceCustomIndex = 0;
    key.mask = 0;
    return XXH3_128bits(&key, sizeof(key));
}

static struct placement *find_placement(struct placements *placements, XXH128_hash_t key)
{
    uint64_t at = key.low64 & placements->mask;
    while (placements->items[at].visible && !XXH128_isEqual(placements->items[at].key, key))
        at = (at + 1) & placements->mask;
    return &placements->items[at];
}

static void add_placement(struct instance_figures *figures, uint32_t index,
                          const VkAccelerationStructureInstanceKHR *instance)
{
    if (!figures->placements)
        return;
    const XXH128_hash_t key = key_of(instance);
    struct placement *placement = find_placement(figures->placements, key);
    if (placement->visible & instance->mask && !figures->repeated++) {
        figures->first_repeated = index;
        figures->twin = placement->first;
    }
    if (!placement->visible)
        *placement = (struct placement){.key = key, .first = index};
    placement->visible |= instance->mask;
}

/* ---- determinants */

/* The sum of the terms of the determinant, and of their magnitudes. */
struct determinant {
    double sum, size;
};

static struct determinant determinant_of(const VkTransformMatrixKHR *transform)
{
    const float(*m)[4] = transform->matrix;
    struct determinant found = {0, 0};
    for (int i = 0; i < 3; i++) {
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        const double a = (double)m[0][i] * m[1][j] * m[2][k],
                     b = (double)m[0][i] * m[1][k] * m[2][j];
        found.sum += a - b;
        found.size += fabs(a) + fabs(b);
    }
    /* A sum that small is rounding errors. */
    if (fabs(found.sum) <= found.size * 0x1p-40)
        found.sum = transform_determinant(transform);
    return found;
}

#define LOSSY_PARTS 0x1p10

static void measure_loss(struct instance_figures *figures, uint32_t index,
                         const struct determinant *determinant)
{
    if (determinant->size > LOSSY_PARTS * fabs(determinant->sum) && !figures->lossy++) {
        figures->first_lossy = index;
        figures->lost_bits = log2(determinant->size / fabs(determinant->sum));
    }
}

/* ---- transforms that are stored by columns */

struct axes {
    double of[3][3]; /* the vectors that the three axes become */
};

static struct axes axes_of(const VkTransformMatrixKHR *transform)
{
    struct axes axes;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            axes.of[i][j] = transform->matrix[j][i];
    return axes;
}

static struct axes axes_by_columns(const VkTransformMatrixKHR *transform)
{
    struct axes axes;
    for (int i = 0; i < 9; i++)
        axes.of[i / 3][i % 3] = transform->matrix[i / 4][i % 4];
    return axes;
}

#define ORTHOGONAL 1e-4 /* the most that rounding makes of a right angle */
#define OBLIQUE 0.1     /* the least of axes that are meant to be oblique */
#define PARALLEL 0.9

static double product_of(const double one[3], const double other[3])
{
    return one[0] * other[0] + one[1] * other[1] + one[2] * other[2];
}

/* Returns the square of the largest cosine of the angle between two axes; 1 if one of them is 0.
 * Most products are 0, which needs no division. */
static double largest_squared_cosine(const struct axes *axes)
{
    double squares[3], largest = 0;
    for (int i = 0; i < 3; i++)
        squares[i] = product_of(axes->of[i], axes->of[i]);
    if (squares[0] == 0 || squares[1] == 0 || squares[2] == 0)
        return 1;
    for (int i = 0; i < 3; i++) {
        const double product = product_of(axes->of[i], axes->of[(i + 1) % 3]);
        if (product != 0)
            largest = fmax(largest, product * product / (squares[i] * squares[(i + 1) % 3]));
    }
    return largest;
}

/* Most oblique axes stay oblique by columns, as two of them show. */
static bool are_orthogonal(const struct axes *axes)
{
    for (int i = 0; i < 3; i++) {
        const double *one = axes->of[i], *other = axes->of[(i + 1) % 3];
        const double squares = product_of(one, one) * product_of(other, other),
                     product = product_of(one, other);
        if (squares == 0 || product * product > ORTHOGONAL * ORTHOGONAL * squares)
            return false;
    }
    return true;
}

/* `largest` is the square of the largest cosine of the transform's axes. */
static void measure_rotation(struct instance_figures *figures, uint32_t index,
                             const VkTransformMatrixKHR *transform, double largest)
{
    if (largest < OBLIQUE * OBLIQUE)
        return;
    const struct axes axes = axes_by_columns(transform);
    if (!are_orthogonal(&axes))
        return;
    bool is_free = true;
    for (int i = 0; i < 9; i++)
        is_free &= axes.of[i / 3][i % 3] != 0;
    figures->is_rotated_freely |= is_free;
    if (!figures->rotated++)
        figures->first_rotated = index;
}

/* The third row is at least so many times as large as the first two. */
#define LARGE_ROW 4

static bool has_large_row(const VkTransformMatrixKHR *transform)
{
    const float(*m)[4] = transform->matrix;
    float most = 0;
    for (int i = 0; i < 6; i++)
        most = fmaxf(most, fabsf(m[i / 3][i % 3]));
    return fmaxf(fabsf(m[2][0]), fabsf(m[2][1])) >= LARGE_ROW * most;
}

static void measure_shear(struct instance_figures *figures, uint32_t index,
                          const VkTransformMatrixKHR *transform, double largest)
{
    const float(*m)[4] = transform->matrix;
    if (m[0][3] != 0 || m[1][3] != 0 || m[2][3] != 0)
        return;
    figures->unmoved++;
    if (largest < PARALLEL * PARALLEL || !has_large_row(transform))
        return;
    if (!figures->sheared++) {
        figures->first_sheared = index;
        memcpy(figures->sheared_row, m[2], sizeof(figures->sheared_row));
    }
    for (int i = 0; i < 3; i++)
        figures->sheared_rows_differ |= figures->sheared_row[i] != m[2][i];
}

bool instances_are_stored_by_columns(const struct instance_figures *figures, uint32_t *first)
{
    const bool are_rotated =
        figures->rotated && figures->rotated == figures->placed && figures->is_rotated_freely;
    const bool are_sheared = figures->unmoved == figures->placed && figures->sheared_rows_differ &&
                             figures->sheared * 2 >= figures->placed;
    *first = are_rotated ? figures->first_rotated : figures->first_sheared;
    return !figures->singular && (are_rotated || are_sheared);
}

/* ---- instances */

static bool is_finite(const VkTransformMatrixKHR *transform)
{
    bool all = true;
    for (int i = 0; i < 12; i++)
        all &= isfinite(transform->matrix[i / 4][i % 4]) != 0;
    return all;
}

void instance_figures_begin(struct instance_figures *figures, uint32_t capacity)
{
    *figures = (struct instance_figures){.placements = make_placements(capacity)};
}

static void measure_box(struct instance_figures *figures,
                        const VkAccelerationStructureInstanceKHR *instance, double determinant,
                        const struct figure_box *box)
{
    if (box)
        box_figures_add(&figures->boxes, box, &instance->transform, determinant, instance->mask);
    else
        figures->unboxed++;
}

static void place(struct instance_figures *figures, uint32_t index,
                  const VkAccelerationStructureInstanceKHR *instance, const struct figure_box *box)
{
    const struct determinant determinant = determinant_of(&instance->transform);
    const struct axes axes = axes_of(&instance->transform);
    if (determinant.sum == 0) {
        figures->singular++;
        return;
    }
    const double largest = largest_squared_cosine(&axes);
    figures->placed++;
    measure_loss(figures, index, &determinant);
    measure_rotation(figures, index, &instance->transform, largest);
    measure_shear(figures, index, &instance->transform, largest);
    add_placement(figures, index, instance);
    measure_box(figures, instance, determinant.sum, box);
}

void instance_figures_add(struct instance_figures *figures,
                          const VkAccelerationStructureInstanceKHR *instance,
                          const struct figure_box *box)
{
    const uint32_t index = (uint32_t)figures->count++;
    if (!instance->accelerationStructureReference)
        figures->inactive++;
    else if (!instance->mask)
        figures->masked++;
    else if (is_finite(&instance->transform))
        place(figures, index, instance, box);
    else
        figures->unboxed++;
}

void instance_figures_end(struct instance_figures *figures)
{
    free(figures->placements);
    figures->placements = NULL;
}
