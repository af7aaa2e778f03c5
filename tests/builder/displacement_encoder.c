/* SPDX-License-Identifier: Apache-2.0 */
/* Displacement blocks, written. */
#include "displacement_encoder.h"

#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

/* The specification's tables: where fields begin, and their bits. */
struct fields {
    uint32_t start, bits, shift_start, shift_bits;
};
static const struct {
    uint32_t level, bytes;
    struct fields levels[6];
} tables[] = {
    {3, 64, {{0, 11, 0, 0}, {33, 11, 0, 0}, {66, 11, 0, 0}, {165, 11, 0, 0}}},
    {4,
     128,
     {{0, 11, 0, 0}, {33, 11, 0, 0}, {66, 11, 0, 0}, {165, 10, 1018, 1}, {465, 5, 1006, 3}}},
    {5,
     128,
     {{0, 11, 0, 0},
      {33, 11, 0, 0},
      {66, 8, 1014, 2},
      {138, 4, 1002, 3},
      {258, 2, 986, 4},
      {474, 1, 970, 4}}},
};

enum { BYTES_MAX = 16 * 128 }; /* of a triangle */

struct point {
    int u, v;
};

static struct point between(struct point a, struct point b)
{
    return (struct point){(a.u + b.u) / 2, (a.v + b.v) / 2};
}

struct block {
    uint32_t format, level; /* of what is coded: at most the format's */
    uint8_t *bytes;
    struct point whole[3]; /* the block's corners in the triangle */
    const struct encoder_values *wanted;
    struct encoder_values *coded;
    uint32_t shifts[6][4];
    uint32_t done[6]; /* fields of each level */
};

/* Returns the point with these weights within the block. */
static struct point in_whole(const struct block *block, struct point p)
{
    int edge = 1 << block->level, w = edge - p.u - p.v;
    const struct point *whole = block->whole;
    return (struct point){(whole[0].u * w + whole[1].u * p.u + whole[2].u * p.v) / edge,
                          (whole[0].v * w + whole[1].v * p.u + whole[2].v * p.v) / edge};
}

static uint16_t *coded(struct block *block, struct point p)
{
    struct point at = in_whole(block, p);
    return &block->coded->at[at.u][at.v];
}

static void put_anchor(struct block *block, struct point p)
{
    struct point at = in_whole(block, p);
    fixture_put_bits(block->bytes, 11 * block->done[0]++, 11, block->wanted->at[at.u][at.v]);
    *coded(block, p) = block->wanted->at[at.u][at.v];
}

/* The middle of an edge, at `level`. */
static void put_middle(struct block *block, uint32_t level, struct point a, struct point b)
{
    const struct fields *fields = &tables[block->format - 1].levels[level];
    struct point p = between(a, b), at = in_whole(block, p);
    int edge = 1 << block->level, wanted = block->wanted->at[at.u][at.v];
    int kind = p.v == 0 ? 1 : p.u + p.v == edge ? 2 : p.u == 0 ? 3 : 0;
    int shift = (int)block->shifts[level][kind], low = -(1 << (fields->bits - 1));
    int predicted = (*coded(block, a) + *coded(block, b) + 1) / 2;
    int correction = wanted - predicted;
    if (block->format == 1) {
        *coded(block, p) = (uint16_t)wanted;
        correction = wanted;
    } else {
        correction = ((correction + 1024) & 2047) - 1024; /* the shorter way round */
        correction = shift < 11 ? correction / (1 << shift) : -1;
        correction = correction < low ? low : correction > -low - 1 ? -low - 1 : correction;
        *coded(block, p) = (uint16_t)((predicted + correction * (1 << shift)) & 2047);
    }
    fixture_put_bits(block->bytes, fields->start + fields->bits * block->done[level]++,
                     fields->bits, (uint32_t)correction);
}

/* The middles that the parts name which are cut `cuts` times more. */
static void put_level(struct block *block, uint32_t level, uint32_t cuts, struct point a,
                      struct point b, struct point c)
{
    struct point ab = between(a, b), bc = between(b, c), ac = between(a, c);
    if (cuts > 0) {
        put_level(block, level, cuts - 1, a, ab, ac);
        put_level(block, level, cuts - 1, ac, bc, ab);
        put_level(block, level, cuts - 1, ab, b, bc);
        put_level(block, level, cuts - 1, bc, ac, c);
    } else if (c.v > a.v) {
        bool is_flipped = b.u < a.u;
        put_middle(block, level, is_flipped ? b : a, c);
        put_middle(block, level, is_flipped ? a : b, c);
        put_middle(block, level, a, b);
    }
}

static void put_shifts(struct block *block, uint64_t *random)
{
    uint32_t limit = 0;
    for (uint32_t level = 1; level <= tables[block->format - 1].level; level++) {
        const struct fields *fields = &tables[block->format - 1].levels[level];
        for (uint32_t i = 0; fields->shift_bits > 0 && i < 4; i++) {
            limit = 1u << fields->shift_bits;
            block->shifts[level][i] = (uint32_t)fixture_random(random) % limit;
            fixture_put_bits(block->bytes, fields->shift_start + i * fields->shift_bits,
                             fields->shift_bits, block->shifts[level][i]);
        }
    }
}

static void put_block(struct block *block, uint64_t *random)
{
    int edge = 1 << block->level;
    struct point a = {0, 0}, b = {edge, 0}, c = {0, edge};
    memset(block->done, 0, sizeof(block->done));
    for (uint32_t i = 0; i < tables[block->format - 1].bytes; i++) /* what isn't used is any */
        block->bytes[i] = (uint8_t)fixture_random(random);
    put_shifts(block, random);
    put_anchor(block, a);
    put_anchor(block, b);
    put_anchor(block, c);
    for (uint32_t level = 1; level <= block->level; level++)
        put_level(block, level, level - 1, a, b, c);
    block->bytes += tables[block->format - 1].bytes;
}

static void put_blocks(struct block *block, uint32_t cuts, struct point a, struct point b,
                       struct point c, uint64_t *random)
{
    struct point ab = between(a, b), bc = between(b, c), ac = between(a, c);
    if (cuts == 0) {
        block->whole[0] = a;
        block->whole[1] = b;
        block->whole[2] = c;
        put_block(block, random);
        return;
    }
    put_blocks(block, cuts - 1, a, ab, ac, random);
    put_blocks(block, cuts - 1, ac, bc, ab, random);
    put_blocks(block, cuts - 1, ab, b, bc, random);
    put_blocks(block, cuts - 1, bc, ac, c, random);
}

/* Writes blocks of values as near to `wanted` as random shifts allow, which then are in `coded`.
 * Returns the bytes. */
static uint32_t encode(uint32_t format, uint32_t level, const struct encoder_values *wanted,
                       uint64_t *random, uint8_t *blocks, struct encoder_values *coded)
{
    uint32_t most = tables[format - 1].level, cuts = level > most ? level - most : 0;
    int edge = 1 << level;
    struct block block = {
        .format = format, .level = level - cuts, .bytes = blocks, .wanted = wanted, .coded = coded};
    put_blocks(&block, cuts, (struct point){0, 0}, (struct point){edge, 0}, (struct point){0, edge},
               random);
    return (uint32_t)(block.bytes - blocks);
}

/* ---- micromaps */

static void want(struct encoder_values *wanted, uint32_t triangle, uint32_t level,
                 encoder_value *value, void *context)
{
    uint32_t edge = 1u << level;
    for (uint32_t u = 0; u <= edge; u++)
        for (uint32_t v = 0; u + v <= edge; v++)
            wanted->at[u][v] = value(context, triangle, level, u, v);
}

struct micromap_input fixture_micromap_input(VkMicromapTypeEXT type, uint32_t usage_count,
                                             const VkMicromapUsageEXT *usages, const void *data,
                                             uint64_t data_size, uint32_t triangle_count,
                                             const VkMicromapTriangleEXT *triangles)
{
    return (struct micromap_input){.type = type,
                                   .usage_count = usage_count,
                                   .usages = usages,
                                   .data = data,
                                   .triangles = triangles,
                                   .data_size = data_size,
                                   .triangles_size = triangle_count * sizeof(*triangles),
                                   .stride = sizeof(*triangles)};
}

void *fixture_micromap(const struct micromap_input *input)
{
    uint64_t size;
    if (micromap_get_size(input, &size) != BUILDER_OK)
        abort();
    void *micromap = fixture_allocate(size);
    if (micromap_build(input, micromap, size) != BUILDER_OK)
        abort();
    return micromap;
}

/* What triangles have is in `coded`, one a triangle. */
static void *make_micromap(uint32_t format, uint32_t count, const uint8_t *levels,
                           encoder_value *value, void *context, VkMicromapUsageEXT *usages,
                           struct encoder_values *coded)
{
    VkMicromapTriangleEXT *triangles = fixture_allocate(count * sizeof(*triangles));
    uint8_t *data = fixture_allocate((uint64_t)count * BYTES_MAX);
    uint64_t random = 13;
    uint32_t used = 0;
    for (uint32_t i = 0; i < 6; i++)
        usages[i] = (VkMicromapUsageEXT){0, i, format};
    for (uint32_t i = 0; i < count; i++) {
        struct encoder_values wanted;
        want(&wanted, i, levels[i], value, context);
        triangles[i] = (VkMicromapTriangleEXT){used, levels[i], (uint16_t)format};
        used += encode(format, levels[i], &wanted, &random, data + used, &coded[i]);
        usages[levels[i]].count++;
    }
    const struct micromap_input input = fixture_micromap_input(
        VK_MICROMAP_TYPE_DISPLACEMENT_MICROMAP_NV, 6, usages, data, used, count, triangles);
    return fixture_micromap(&input);
}

void open_displaced(struct displaced *displaced, uint32_t format, uint32_t count,
                    const uint8_t *levels, encoder_value *value, void *context,
                    const float *vectors, uint64_t vectors_size)
{
    displaced->coded = fixture_allocate(count * sizeof(*displaced->coded));
    displaced->micromap =
        make_micromap(format, count, levels, value, context, displaced->usages, displaced->coded);
    displaced->displacement = (struct builder_displacement){
        .usage_count = 6,
        .usages = displaced->usages,
        .vector_format = VK_FORMAT_R32G32B32_SFLOAT,
        .bias_and_scale_format = VK_FORMAT_R32G32_SFLOAT,
        .index_type = VK_INDEX_TYPE_NONE_KHR,
        .vectors = vectors,
        .vectors_size = vectors_size,
        .vector_stride = 12,
        .bias_and_scale_stride = 8,
        .micromap = (uintptr_t)displaced->micromap,
    };
}

uint16_t random_value(void *context, uint32_t triangle, uint32_t level, uint32_t u, uint32_t v)
{
    (void)triangle;
    (void)level;
    (void)u;
    (void)v;
    return (uint16_t)(fixture_random(context) & 2047);
}
