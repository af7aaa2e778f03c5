/* SPDX-License-Identifier: Apache-2.0 */
/* Decodes the blocks of displacement micromaps. Positions are in bits. */
#include "src/bvh/input/displacement.h"

#include <stdbool.h>

#define VALUE_BITS 11
#define FIELDS 4 /* shifts for the interior and the edges 0-1, 1-2, 2-0 */

/* The layout of a format: the corrections of all levels follow the anchors without gaps. */
struct block_format {
    uint32_t level, bytes;
    bool is_plain; /* values are stored without prediction */
    uint8_t bits[DISPLACEMENT_MAX_LEVEL + 1];
    uint8_t shift_bits[DISPLACEMENT_MAX_LEVEL + 1]; /* 0 if there are no shifts */
    uint16_t shifts[DISPLACEMENT_MAX_LEVEL + 1];
};

static const struct block_format formats[] = {
    {3, 64, true, {11, 11, 11, 11}, {0}, {0}},
    {4, 128, false, {11, 11, 11, 10, 5}, {0, 0, 0, 1, 3}, {0, 0, 0, 1018, 1006}},
    {5, 128, false, {11, 11, 8, 4, 2, 1}, {0, 0, 2, 3, 4, 4}, {0, 0, 1014, 1002, 986, 970}},
};

uint64_t displacement_bytes(uint32_t format, uint32_t level)
{
    if (format < 1 || format > sizeof(formats) / sizeof(formats[0]) ||
        level > DISPLACEMENT_MAX_LEVEL)
        return 0;
    const struct block_format *found = &formats[format - 1];
    uint32_t beyond = level > found->level ? level - found->level : 0;
    return (uint64_t)found->bytes << 2 * beyond;
}

static struct displacement_corner middle(struct displacement_corner a, struct displacement_corner b)
{
    return (struct displacement_corner){(uint8_t)((a.u + b.u) / 2), (uint8_t)((a.v + b.v) / 2)};
}

void displacement_part(uint32_t cuts, uint32_t index, uint32_t size,
                       struct displacement_corner corners[3])
{
    struct displacement_corner a = {0, 0}, b = {(uint8_t)size, 0}, c = {0, (uint8_t)size};
    while (cuts-- > 0) {
        struct displacement_corner ab = middle(a, b), bc = middle(b, c), ac = middle(a, c);
        switch (index >> 2 * cuts & 3) {
        case 0:
            b = ab;
            c = ac;
            break;
        case 1:
            a = ac;
            b = bc;
            c = ab;
            break;
        case 2:
            a = ab;
            c = bc;
            break;
        default:
            a = bc;
            b = ac;
            break;
        }
    }
    corners[0] = a;
    corners[1] = b;
    corners[2] = c;
}

/* Moves every second position on an edge to its neighbour towards the nearer end. The middle of an
 * edge with two segments moves to the first end. */
static uint32_t decimated(uint32_t place, uint32_t length)
{
    return (place + (place > length / 2)) & ~1u;
}

static struct displacement_corner decimate(uint32_t level, uint32_t edges,
                                           struct displacement_corner corner)
{
    uint32_t length = 1u << level, u = corner.u, v = corner.v;
    if (level == 0)
        return corner;
    if (edges & 1 && v == 0) {
        u = decimated(u, length);
    } else if (edges & 2 && u + v == length) {
        v = decimated(v, length);
        u = length - v;
    } else if (edges & 4 && u == 0) {
        v = length - decimated(length - v, length);
    }
    return (struct displacement_corner){(uint8_t)u, (uint8_t)v};
}

void displacement_microtriangle(uint32_t level, uint32_t index, uint32_t edges,
                                struct displacement_corner corners[3])
{
    displacement_part(level, index, 1u << level, corners);
    bool is_flipped = (corners[1].u > corners[0].u) != (corners[2].v > corners[0].v);
    struct displacement_corner first = corners[0];
    if (is_flipped) {
        corners[0] = corners[1];
        corners[1] = first;
    }
    for (int i = 0; i < 3; i++)
        corners[i] = decimate(level, edges, corners[i]);
}

/* Reads at most 16 bits. No field lies only in the last two bytes of a block. */
static uint32_t read_bits(const uint8_t *block, uint32_t at, uint32_t count)
{
    uint32_t bits = block[at / 8];
    for (uint32_t shift = 8; shift < at % 8 + count; shift += 8)
        bits |= (uint32_t)block[(at + shift) / 8] << shift;
    return bits >> at % 8 & ((1u << count) - 1);
}

struct decoding {
    const struct block_format *format;
    const uint8_t *block;
    uint32_t level; /* level at which the block is decoded */
    uint32_t now;   /* level that is being read */
    uint32_t at;    /* position of the next field */
    uint16_t *values;
};

static uint32_t read_shift(const struct decoding *decoding, uint32_t u, uint32_t v)
{
    uint32_t bits = decoding->format->shift_bits[decoding->now], field = 0;
    if (bits == 0)
        return 0;
    if (v == 0)
        field = 1;
    else if (u + v == 1u << decoding->level)
        field = 2;
    else if (u == 0)
        field = 3;
    return read_bits(decoding->block, decoding->format->shifts[decoding->now] + field * bits, bits);
}

/* Reads the vertex at (u, v), which is predicted from the vertices at (u - du, v - dv) and
 * (u + du, v + dv). */
static void read_vertex(struct decoding *decoding, uint32_t u, uint32_t v, int du, int dv)
{
    uint32_t bits = decoding->format->bits[decoding->now], level = decoding->level;
    uint32_t value = read_bits(decoding->block, decoding->at, bits);
    uint16_t *values = decoding->values;
    decoding->at += bits;
    if (!decoding->format->is_plain) {
        uint32_t a = values[displacement_place(level, u - (uint32_t)du, v - (uint32_t)dv)];
        uint32_t b = values[displacement_place(level, u + (uint32_t)du, v + (uint32_t)dv)];
        uint32_t sign = 1u << (bits - 1), correction = (value ^ sign) - sign;
        value = (a + b + 1) / 2 + (correction << read_shift(decoding, u, v));
    }
    values[displacement_place(level, u, v)] = (uint16_t)(value & DISPLACEMENT_ONE);
}

static void read_level(struct decoding *decoding)
{
    uint32_t cuts = decoding->now - 1;
    int step = 1 << (decoding->level - decoding->now);
    for (uint32_t i = 0; i < 1u << 2 * cuts; i++) {
        struct displacement_corner corners[3];
        displacement_part(cuts, i, 1u << decoding->level, corners);
        if (corners[2].v < corners[0].v)
            continue;
        uint32_t u = corners[2].u, v = corners[0].v;
        read_vertex(decoding, u, v + (uint32_t)step, 0, step);
        read_vertex(decoding, u + (uint32_t)step, v + (uint32_t)step, step, -step);
        read_vertex(decoding, u + (uint32_t)step, v, step, 0);
    }
}

static void decode_block(const struct block_format *format, uint32_t level, const uint8_t *block,
                         uint16_t *values)
{
    uint32_t edge = 1u << level;
    struct decoding decoding = {
        .format = format, .block = block, .level = level, .at = 3 * VALUE_BITS, .values = values};
    values[displacement_place(level, 0, 0)] = (uint16_t)read_bits(block, 0, VALUE_BITS);
    values[displacement_place(level, edge, 0)] = (uint16_t)read_bits(block, VALUE_BITS, VALUE_BITS);
    values[displacement_place(level, 0, edge)] =
        (uint16_t)read_bits(block, 2 * VALUE_BITS, VALUE_BITS);
    for (decoding.now = 1; decoding.now <= level; decoding.now++)
        read_level(&decoding);
}

/* Copies the values of a block to the positions of its vertices in the whole triangle. */
static void place_block(uint32_t cuts, uint32_t index, uint32_t level, const uint16_t *from,
                        uint16_t *to)
{
    struct displacement_corner corners[3];
    int edge = 1 << (level - cuts);
    displacement_part(cuts, index, 1u << level, corners);
    for (int v = 0; v <= edge; v++)
        for (int u = 0; u + v <= edge; u++) {
            int x = (corners[0].u * (edge - u - v) + corners[1].u * u + corners[2].u * v) / edge;
            int y = (corners[0].v * (edge - u - v) + corners[1].v * u + corners[2].v * v) / edge;
            to[displacement_place(level, (uint32_t)x, (uint32_t)y)] = *from++;
        }
}

void displacement_decode(uint32_t format, uint32_t level, const uint8_t *blocks, uint16_t *values)
{
    const struct block_format *found = &formats[format - 1];
    if (level <= found->level) {
        decode_block(found, level, blocks, values);
        return;
    }
    uint16_t part[DISPLACEMENT_MAX_VERTICES];
    uint32_t cuts = level - found->level;
    for (uint32_t i = 0; i < 1u << 2 * cuts; i++) {
        decode_block(found, found->level, blocks + (uint64_t)i * found->bytes, part);
        place_block(cuts, i, level, part, values);
    }
}
