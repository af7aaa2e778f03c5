/* SPDX-License-Identifier: Apache-2.0 */
/* Functions that scan many values at once agree with code that reads one at a time. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "src/bvh/bvh.h"
#include "src/bvh/expansion.h"
#include "src/bvh/input/formats.h"
#include "tests/unit/random.h"
#include "tests/unit/unit_test.h"

enum { ROUNDS = 20000, MOST = 70, STRIDE_MAX = 40 };

static uint32_t max_one_by_one(const uint8_t *indices, uint32_t size, uint64_t count)
{
    uint32_t max = 0;
    for (uint64_t i = 0; i < count; i++) {
        uint32_t index = 0;
        memcpy(&index, indices + i * size, size); /* little endian */
        max = index > max ? index : max;
    }
    return max;
}

TEST(test_largest_index)
{
    struct random random = random_of("largest index");
    uint8_t bytes[4 * MOST + 1];
    for (int round = 0; round < ROUNDS; round++) {
        const uint32_t size = 1u << random_below(&random, 3), at = random_below(&random, 2);
        const uint32_t count = random_below(&random, MOST);
        const bool is_small = random_one_in(&random, 2);
        for (size_t i = 0; i < sizeof(bytes); i++)
            bytes[i] = is_small && random_below(&random, 40) ? 0 : (uint8_t)random_next(&random);
        assert_int_equal(indices_max(bytes + at, size, count),
                         max_one_by_one(bytes + at, size, count));
    }
}

/* Infinities, the largest numbers and NaNs of either sign with any fraction. */
static float some_float(struct random *random, bool may_be_nan)
{
    static const uint32_t others[] = {0x7f800000, 0xff800000, 0x7f7fffff, 0, 0x80000000, 1};
    uint32_t bits = others[random_below(random, 6)];
    if (may_be_nan && random_one_in(random, 60))
        bits = 0x7f800000 | (random_one_in(random, 2) ? 0x80000000 : 0) |
               (1u << random_below(random, 23));
    float number;
    memcpy(&number, &bits, sizeof(number));
    return number;
}

TEST(test_positions_with_nan)
{
    struct random random = random_of("positions with nan");
    static uint8_t bytes[STRIDE_MAX * MOST + 16];
    uint32_t found = 0;
    for (int round = 0; round < ROUNDS; round++) {
        const uint32_t at = random_below(&random, 4), count = random_below(&random, MOST);
        const uint32_t stride = random_one_in(&random, 2) ? 12 : 12 + random_below(&random, 28);
        const bool may_be_nan = random_one_in(&random, 2);
        bool has_nan = false;
        memset(bytes, 0xff, sizeof(bytes)); /* NaN between the positions */
        for (uint32_t i = 0; i < 3 * count; i++) {
            const float number = some_float(&random, may_be_nan);
            memcpy(bytes + at + i / 3 * stride + i % 3 * 4, &number, 4);
            has_nan |= isnan(number);
        }
        assert_int_equal(positions_have_nan(bytes + at, stride, count), has_nan);
        found += has_nan;
    }
    assert_true(found > ROUNDS / 10 && found < ROUNDS);
}

/* Matrices whose last row is nearly, or exactly, a sum of the others. */
static VkTransformMatrixKHR some_matrix(struct random *random)
{
    static const float scales[] = {1, 1e-20F, 1e15F, 1e-38F, 3e38F};
    VkTransformMatrixKHR matrix = {0};
    const float scale = scales[random_below(random, 5)];
    for (int row = 0; row < 2; row++)
        for (int column = 0; column < 3; column++)
            matrix.matrix[row][column] = scale * ((float)random_below(random, 2001) / 1000 - 1);
    for (int column = 0; column < 3; column++)
        matrix.matrix[2][column] = matrix.matrix[0][column] - matrix.matrix[1][column];
    const int exponent = (int)random_below(random, 121) - 60; /* rows of unequal size */
    for (int column = 0; column < 3; column++)
        matrix.matrix[2][column] = ldexpf(matrix.matrix[2][column], exponent);
    float *changed = &matrix.matrix[random_below(random, 3)][random_below(random, 3)];
    if (random_one_in(random, 2))
        *changed = nextafterf(*changed, random_one_in(random, 2) ? INFINITY : -INFINITY);
    if (random_one_in(random, 8))
        *changed = random_one_in(random, 2) ? INFINITY : NAN;
    return matrix;
}

TEST(test_sign_of_determinant)
{
    struct random random = random_of("sign of determinant");
    uint32_t zeros = 0;
    for (int round = 0; round < ROUNDS; round++) {
        const VkTransformMatrixKHR matrix = some_matrix(&random);
        const double exact = transform_determinant(&matrix);
        const int sign = (exact > 0) - (exact < 0);
        assert_int_equal(builder_determinant_sign(&matrix), sign);
        zeros += sign == 0;
    }
    assert_true(zeros > ROUNDS / 20 && zeros < ROUNDS);
}
