/* SPDX-License-Identifier: Apache-2.0 */
#include "src/advice/figures/indices.h"

#include <stdlib.h>

#include "src/bvh/input/source.h"

/* Fewer triangles, or vertices, prove nothing. */
enum { TRIANGLES_MIN = 4, VERTICES_MIN = 16 };

static uint32_t index_at(const uint8_t *indices, uint32_t size, uint64_t position)
{
    return source_read_number(indices + position * size, size);
}

/* The triangles that have an index twice. */
static uint64_t count_repeating(const uint8_t *indices, uint32_t size, uint64_t triangles)
{
    uint64_t found = 0;
    for (uint64_t i = 0; i < triangles; i++) {
        const uint32_t a = index_at(indices, size, 3 * i), b = index_at(indices, size, 3 * i + 1),
                       c = index_at(indices, size, 3 * i + 2);
        found += a == b || b == c || c == a;
    }
    return found;
}

/* Nearly all triangles of a mesh have three vertices. */
static bool is_mesh(const uint8_t *indices, const struct other_indices *other)
{
    return other->triangles >= TRIANGLES_MIN &&
           count_repeating(indices, other->size, other->triangles) * 10 <= other->triangles;
}

/* ---- too narrow */

/* Whether only every `step`-th index is not 0. */
static bool others_are_zero(const uint8_t *indices, uint32_t size, uint64_t count, uint64_t step)
{
    for (uint64_t i = 0; i < count; i++)
        if (i % step && index_at(indices, size, i))
            return false;
    return true;
}

/* As many indices have zeros behind them, whose triangles have 0 twice. */
static bool suit_wider(const uint8_t *indices, uint32_t size, uint64_t count, uint32_t max,
                       struct other_indices *other)
{
    const uint32_t step = other->size / size;
    other->triangles = count / step / 3;
    other->max = max; /* bytes above it are 0 */
    return others_are_zero(indices, size, count, step) && is_mesh(indices, other);
}

/* ---- too wide: 32 bits that are two indices of 16 bits each */

struct short_indices {
    uint64_t seen[(UINT16_MAX + 1) / 64];
};

/* Counts the values at the even, or odd, positions that were not seen. */
static uint64_t count_new(struct short_indices *short_indices, const uint8_t *indices,
                          uint64_t count, uint64_t first)
{
    uint64_t found = 0;
    for (uint64_t i = first; i < count; i += 2) {
        const uint32_t index = index_at(indices, sizeof(uint16_t), i);
        const uint64_t bit = UINT64_C(1) << index % 64;
        found += !(short_indices->seen[index / 64] & bit);
        short_indices->seen[index / 64] |= bit;
    }
    return found;
}

/* The upper halves of real indices have few values. Those of two indices have as many as the lower
 * ones, and together they use nearly all vertices. */
static bool halves_are_alike(const uint8_t *indices, uint64_t count, uint32_t max)
{
    struct short_indices lower = {0}, upper = {0};
    const uint64_t of_lower = count_new(&lower, indices, count, 0),
                   of_upper = count_new(&upper, indices, count, 1),
                   all = of_lower + count_new(&lower, indices, count, 1);
    return all >= VERTICES_MIN && of_lower * 2 >= all && of_upper * 2 >= all &&
           all * 10 >= ((uint64_t)max + 1) * 9;
}

/* Judges indices that were read with more bits than they have. Read so, they use less than a
 * hundredth of the vertices up to the largest one. */
static bool suit_narrower(const uint8_t *indices, uint64_t count, uint64_t max, uint64_t limit,
                          struct other_indices *other)
{
    if (count * 100 > max + 1)
        return false;
    other->triangles = count / 3;
    other->max = indices_max(indices, other->size, count);
    return other->max < limit && halves_are_alike(indices, count, other->max) &&
           is_mesh(indices, other);
}

bool indices_suit_another_size(const uint8_t *indices, uint32_t size, uint64_t count, uint32_t max,
                               uint64_t limit, struct other_indices *other)
{
    for (other->size = 2 * size; other->size <= sizeof(uint32_t); other->size *= 2)
        if (suit_wider(indices, size, count, max, other))
            return true;
    other->size = sizeof(uint16_t);
    return size == sizeof(uint32_t) && suit_narrower(indices, count, max, limit, other);
}

bool indices_find_used(const uint8_t *indices, uint32_t size, uint64_t count, uint32_t largest,
                       struct used_vertices *used)
{
    uint64_t *seen = calloc((size_t)largest / 64 + 1, sizeof(*seen));
    *used = (struct used_vertices){.smallest = largest, .largest = largest};
    for (uint64_t i = 0; seen && i < count; i++) {
        const uint32_t index = index_at(indices, size, i);
        const uint64_t bit = UINT64_C(1) << index % 64;
        used->count += !(seen[index / 64] & bit);
        used->smallest = index < used->smallest ? index : used->smallest;
        seen[index / 64] |= bit;
    }
    free(seen);
    return seen;
}
