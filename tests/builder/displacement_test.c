/* SPDX-License-Identifier: Apache-2.0 */
/* Blocks of displacement micromaps: by hand, against an encoder, and with any bytes. */
#include <string.h>

#include "displacement_encoder.h"
#include "src/bvh/input/displacement.h"
#include "tests/builder/fixture.h"
#include "tests/unit/unit_test.h"

/* Level 2, in quarters of an edge. */
static const uint8_t order[15][2] = {
    {0, 0}, {4, 0}, {0, 4},                         /* the whole's */
    {0, 2}, {2, 2}, {2, 0},                         /* level 1 */
    {0, 1}, {1, 1}, {1, 0}, {2, 1}, {3, 1}, {3, 0}, /* level 2: at vertex 0, at vertex 1, */
    {0, 3}, {1, 3}, {1, 2},                         /* at vertex 2 */
};

TEST(test_order_of_vertices)
{
    uint8_t block[64] = {0};
    uint16_t values[DISPLACEMENT_MAX_VERTICES];
    for (uint32_t i = 0; i < 45; i++)
        fixture_put_bits(block, 11 * i, 11, 2000 + i);
    displacement_decode(1, 2, block, values);
    for (uint32_t i = 0; i < 15; i++)
        assert_int_equal(values[displacement_place(2, order[i][0], order[i][1])], 2000 + i);
    displacement_decode(1, 0, block, values);
    for (uint32_t i = 0; i < 3; i++)
        assert_int_equal(values[displacement_place(0, order[i][0] / 4, order[i][1] / 4)], 2000 + i);
}

/* Each part begins where the one before ends, and all have the same size. */
TEST(test_curve)
{
    for (uint32_t cuts = 0; cuts <= 5; cuts++) {
        struct displacement_corner before = {0, 0};
        for (uint32_t i = 0; i < 1u << 2 * cuts; i++) {
            struct displacement_corner c[3];
            displacement_part(cuts, i, 32, c);
            int area =
                (c[1].u - c[0].u) * (c[2].v - c[0].v) - (c[2].u - c[0].u) * (c[1].v - c[0].v);
            int edge = 32 >> cuts;
            assert_true(area == edge * edge || area == -edge * edge);
            assert_true(c[0].u == before.u && c[0].v == before.v);
            before = c[2];
        }
        assert_true(before.u == 0 && before.v == 32);
    }
}

/* Level 2 with its edges decimated: vertices 1 and 3 of each go to its ends. Of level 1 the middle
 * goes to the edge's first vertex. */
TEST(test_decimated_edges)
{
    for (uint32_t edges = 0; edges < 8; edges++) {
        uint32_t seen[5][5] = {{0}}, left = 0;
        for (uint32_t i = 0; i < 16; i++) {
            struct displacement_corner c[3];
            displacement_microtriangle(2, i, edges, c);
            for (int j = 0; j < 3; j++)
                seen[c[j].u][c[j].v]++;
        }
        for (uint32_t i = 0; i < 25; i++)
            left += seen[i / 5][i % 5] > 0;
        assert_int_equal(left, 15 - 2 * (uint32_t)__builtin_popcount(edges));
        assert_true((seen[1][0] + seen[3][0] == 0) == (edges & 1));
        assert_true((seen[3][1] + seen[1][3] == 0) == (edges >> 1 & 1));
        assert_true((seen[0][1] + seen[0][3] == 0) == (edges >> 2 & 1));
        assert_true(seen[0][0] == (edges & 1 ? edges & 4 ? 7 : 4 : edges & 4 ? 4 : 1));
    }
    struct displacement_corner c[3];
    displacement_microtriangle(1, 1, 7, c); /* the middle becomes the whole */
    assert_true(c[0].u == 2 && c[0].v == 0 && c[1].u == 0 && c[1].v == 2 && c[2].u == 0 &&
                c[2].v == 0);
    displacement_microtriangle(0, 0, 7, c);
    assert_true(c[0].u == 0 && c[1].u == 1 && c[2].v == 1);
}

/* Format 3: predictions, corrections of either sign, shifts, and what wraps at 11 bits. */
TEST(test_corrections)
{
    static const struct {
        uint32_t at, count, value;
    } fields[] = {
        {0, 11, 100},  {11, 11, 200},  {22, 11, 2047}, /* anchors */
        {33, 11, 5},   {44, 11, 2047}, {55, 11, 1900}, /* level 1 */
        {66, 8, 0x80}, {74, 8, 0x7f},  {82, 8, 0xff},  /* the first three of level 2 */
        {1014, 2, 1},  {1016, 2, 2},   {1018, 2, 0},   {1020, 2, 3},
    };
    static const struct {
        uint8_t u, v;
        uint16_t value;
    } expected[] = {
        {0, 2, 1079}, /* (100 + 2047 + 1) / 2 + 5 */
        {2, 2, 1123}, /* (200 + 2047 + 1) / 2 - 1 */
        {2, 0, 2},    /* (100 + 200 + 1) / 2 + 1900 - 2048 */
        {0, 1, 1614}, /* (100 + 1079 + 1) / 2 - 128 * 8 + 2048 */
        {1, 1, 795},  /* (2 + 1079 + 1) / 2 + 127 * 2 */
        {1, 0, 47},   /* (100 + 2 + 1) / 2 - 1 * 4 */
    };
    uint8_t block[128] = {0};
    uint16_t values[DISPLACEMENT_MAX_VERTICES];
    for (size_t i = 0; i < sizeof(fields) / sizeof(fields[0]); i++)
        fixture_put_bits(block, fields[i].at, fields[i].count, fields[i].value);
    displacement_decode(3, 2, block, values);
    for (size_t i = 0; i < sizeof(expected) / sizeof(expected[0]); i++)
        assert_int_equal(values[displacement_place(2, expected[i].u, expected[i].v)],
                         expected[i].value);
}

/* Every value of every format and level; those that aren't compressed as they were wanted. */
TEST(test_encoded)
{
    uint64_t random = 11;
    for (uint32_t i = 0; i < 50 * 3 * 6; i++) {
        uint32_t format = 1 + i % 3, level = i / 3 % 6, edge = 1u << level;
        struct encoder_values wanted, coded;
        uint8_t blocks[ENCODER_BYTES];
        uint16_t values[DISPLACEMENT_MAX_VERTICES];
        for (uint32_t j = 0; j < ENCODER_EDGE * ENCODER_EDGE; j++)
            wanted.at[j / ENCODER_EDGE][j % ENCODER_EDGE] =
                (uint16_t)(fixture_random(&random) & 2047);
        assert_int_equal(encoder_encode(format, level, &wanted, &random, blocks, &coded),
                         displacement_bytes(format, level));
        displacement_decode(format, level, blocks, values);
        for (uint32_t v = 0; v <= edge; v++)
            for (uint32_t u = 0; u + v <= edge; u++) {
                uint16_t value = values[displacement_place(level, u, v)];
                assert_int_equal(value, coded.at[u][v]);
                if (format == 1 || (format == 2 && level <= 2) || level <= 1)
                    assert_int_equal(value, wanted.at[u][v]);
            }
    }
}

/* Whatever the bytes, all vertices get a value, and no others. */
TEST(test_any_bytes)
{
    uint64_t random = 5;
    for (uint32_t i = 0; i < 20 * 3 * 6; i++) {
        uint32_t format = 1 + i % 3, level = i / 3 % 6, count = displacement_vertex_count(level);
        uint8_t blocks[ENCODER_BYTES];
        uint16_t values[DISPLACEMENT_MAX_VERTICES + 1];
        for (uint32_t j = 0; j < ENCODER_BYTES; j++)
            blocks[j] = (uint8_t)fixture_random(&random);
        memset(values, 0xff, sizeof(values));
        displacement_decode(format, level, blocks, values);
        for (uint32_t j = 0; j <= DISPLACEMENT_MAX_VERTICES; j++)
            assert_true(j < count ? values[j] <= DISPLACEMENT_ONE : values[j] == 0xffff);
    }
}

TEST(test_bytes)
{
    static const uint32_t bytes[3][6] = {{64, 64, 64, 64, 256, 1024},
                                         {128, 128, 128, 128, 128, 512},
                                         {128, 128, 128, 128, 128, 128}};
    for (uint32_t i = 0; i < 18; i++)
        assert_int_equal(displacement_bytes(1 + i / 6, i % 6), bytes[i / 6][i % 6]);
    assert_int_equal(displacement_bytes(0, 0), 0);
    assert_int_equal(displacement_bytes(4, 0), 0);
    assert_int_equal(displacement_bytes(1, 6), 0);
}
