/* SPDX-License-Identifier: Apache-2.0 */
/* Indices of 16 bits that are read as 32, and valid ones that look like a mistake.
 * tests/programs/advice/data.cases has other mistakes. */
#include <string.h>

#include "src/advice/figures/indices.h"
#include "src/bvh/input/formats.h"
#include "tests/unit/random.h"
#include "tests/unit/unit_test.h"

enum { SIDE = 8, COUNT = 6 * SIDE * SIDE, VERTICES = (SIDE + 1) * (SIDE + 1) };

/* Writes the indices of a square of SIDE * SIDE smaller squares. The first vertex is `first`. */
static void mesh(uint32_t indices[COUNT], uint32_t first)
{
    static const uint32_t corners[] = {0, 1, SIDE + 1, 1, SIDE + 2, SIDE + 1};
    for (uint32_t i = 0; i < COUNT; i++)
        indices[i] = first + i / 6 / SIDE * (SIDE + 1) + i / 6 % SIDE + corners[i % 6];
}

static void narrow(const uint32_t indices[COUNT], uint16_t shorts[COUNT])
{
    for (uint32_t i = 0; i < COUNT; i++)
        shorts[i] = (uint16_t)indices[i];
}

static bool suit(const void *indices, uint32_t size, uint64_t count, uint64_t limit,
                 struct other_indices *other)
{
    return indices_suit_another_size(indices, size, count, indices_max(indices, size, count), limit,
                                     other);
}

/* One index beyond 16 bits, or a vertex 0 that all triangles have. */
TEST(test_narrow_indices_with_zeros)
{
    uint16_t shorts[COUNT] = {0};
    struct other_indices other;
    for (uint16_t i = 0; i < COUNT / 3; i++) {
        shorts[3 * i + 1] = i + 1;
        shorts[3 * i + 2] = i + 2;
    }
    assert_false(suit(shorts, 2, COUNT, UINT16_MAX, &other)); /* a fan */
    memset(shorts, 0, sizeof(shorts));
    assert_false(suit(shorts, 2, COUNT, UINT16_MAX, &other)); /* one vertex */
    uint32_t indices[COUNT];
    mesh(indices, 0);
    memcpy(shorts, indices, sizeof(shorts));
    shorts[7] = 1;
    assert_false(suit(shorts, 2, COUNT, UINT16_MAX, &other));
    assert_false(suit(indices, 2, 12, UINT16_MAX, &other)); /* two triangles are too few */
}

TEST(test_narrow_indices_read_as_wide_ones)
{
    uint32_t indices[COUNT], joined[COUNT];
    uint16_t shorts[2 * COUNT];
    struct other_indices other;
    mesh(indices, 0);
    narrow(indices, shorts);
    narrow(indices, shorts + COUNT);
    memcpy(joined, shorts, sizeof(joined));
    assert_true(suit(joined, 4, COUNT, UINT64_C(1) << 32, &other));
    assert_int_equal(other.size, 2);
    assert_int_equal(other.triangles, COUNT / 3);
    assert_int_equal(other.max, VERTICES - 1);
    assert_false(suit(joined, 4, COUNT, VERTICES - 1, &other)); /* no room for the largest */
}

/* A mesh whose vertices begin at a multiple of 65536 uses few vertices, too. */
TEST(test_wide_indices_of_a_pool)
{
    uint32_t indices[COUNT];
    struct other_indices other;
    const uint32_t firsts[] = {0, 1, 65535, 65536, 65537, 1 << 24, (1 << 24) + 1, 0xfffe0000};
    for (size_t i = 0; i < sizeof(firsts) / sizeof(firsts[0]); i++) {
        mesh(indices, firsts[i]);
        assert_false(suit(indices, 4, COUNT, UINT64_C(1) << 32, &other));
    }
    /* One vertex of every 65536. */
    for (uint32_t i = 0; i < COUNT; i++)
        indices[i] = i << 16;
    assert_false(suit(indices, 4, COUNT, UINT64_C(1) << 32, &other));
    /* Vertices of two far places in turn: the halves make triangles, but the upper ones are few. */
    mesh(indices, 0);
    for (uint32_t i = 0; i < COUNT; i++)
        indices[i] += (VERTICES + i % 2) << 16;
    assert_false(suit(indices, 4, COUNT, UINT64_C(1) << 32, &other));
}

/* Meshes in random order, at random places of a pool, with and without degenerate triangles. */
TEST(test_random_meshes)
{
    struct random random = random_of("indices");
    for (int round = 0; round < 2000; round++) {
        uint32_t indices[COUNT];
        uint16_t shorts[COUNT];
        struct other_indices other;
        mesh(indices, random_one_in(&random, 2) ? random_below(&random, 60000) : 0);
        for (uint32_t i = 0; i < COUNT; i += 3)
            if (random_one_in(&random, 2)) {
                const uint32_t j = 3 * random_below(&random, COUNT / 3), kept = indices[i];
                indices[i] = indices[j];
                indices[j] = kept;
                indices[i + 1] = random_one_in(&random, 3) ? indices[i] : indices[i + 1];
            }
        narrow(indices, shorts);
        assert_false(suit(indices, 4, COUNT, UINT64_C(1) << 32, &other));
        assert_false(suit(shorts, 2, COUNT, UINT64_C(1) << 16, &other));
    }
}

TEST(test_used_vertices)
{
    static const uint32_t some[] = {70, 3, 3, 5, 70, 64};
    static const uint8_t bytes[] = {0, 0, 0};
    struct used_vertices used;
    assert_true(indices_find_used((const void *)some, 4, 6, 70, &used));
    assert_int_equal(used.smallest, 3);
    assert_int_equal(used.largest, 70);
    assert_int_equal(used.count, 4);
    assert_true(indices_find_used(bytes, 1, 3, 0, &used));
    assert_int_equal(used.smallest, 0);
    assert_int_equal(used.count, 1);
}
