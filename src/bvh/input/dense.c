/* SPDX-License-Identifier: Apache-2.0 */
/* Decodes dense geometry. A block has 128 bytes: vertices on a grid, a generalized strip of
 * triangles that reuses edges and vertices, and the numbers of the triangles. Positions below are
 * in bits. */
#include "src/bvh/input/input.h"

#include <math.h>
#include <vulkan/vulkan_beta.h>

#define BLOCK_BYTES VK_COMPRESSED_TRIANGLE_FORMAT_DGF1_BYTE_STRIDE_AMDX
#define BLOCK_BITS (8 * BLOCK_BYTES)
#define HEADER_BITS 160
#define MAGIC 6
#define FRONT_MAX (96 * 8)
#define REUSE_MAX (24 * 8)
#define TRIANGLES_MAX 64
#define NUMBER_MAX 0x1fffffffu

/* The decoded header fields. */
struct block {
    const uint8_t *bytes;
    uint32_t index_bits, vertices, triangles;
    uint32_t identity, has_palette; /* "geom_id_meta" and its mode */
    uint32_t exponent, offset_bits[3];
    int32_t anchor[3];
    uint32_t descriptors, base;
    uint32_t front; /* start of the vertices */
    /* Start of the palette of geometry indices; start of the reused vertices. */
    uint32_t palette, reuse;
};

static uint32_t read_bits(const struct block *block, uint32_t at, uint32_t count)
{
    uint64_t bits = 0;
    for (uint32_t byte = at / 8; byte < BLOCK_BYTES && byte <= (at + count) / 8; byte++)
        bits |= (uint64_t)block->bytes[byte] << (byte - at / 8) * 8;
    return (uint32_t)(bits >> at % 8 & (((uint64_t)1 << count) - 1));
}

static uint32_t whole_bytes(uint32_t bits)
{
    return (bits + 7) / 8 * 8;
}

/* Returns the number of bits that a number below `count` needs. */
static uint32_t bits_below(uint32_t count)
{
    return count > 1 ? 32 - (uint32_t)__builtin_clz(count - 1) : 0;
}

static void read_header(struct block *block)
{
    block->index_bits = read_bits(block, 8, 2) + 3;
    block->vertices = read_bits(block, 10, 6) + 1;
    block->triangles = read_bits(block, 16, 6) + 1;
    block->identity = read_bits(block, 22, 10);
    block->exponent = read_bits(block, 32, 8);
    block->offset_bits[0] = read_bits(block, 64, 4) + 1;
    block->offset_bits[1] = read_bits(block, 68, 4) + 1;
    block->offset_bits[2] = read_bits(block, 96, 4) + 1;
    for (uint32_t i = 0; i < 3; i++) /* signed 24 bits */
        block->anchor[i] = (int32_t)(read_bits(block, 40 + 32 * i, 24) ^ 0x800000) - 0x800000;
    block->descriptors = read_bits(block, 100, 3);
    block->has_palette = read_bits(block, 103, 1);
    block->base = read_bits(block, 128, 29);
    block->front = HEADER_BITS + 32 * read_bits(block, 157, 1);
}

/* prefix_bits() and payloads(): the number of prefix bits and of payloads in the geometry
 * palette. */
static uint32_t prefix_bits(const struct block *block)
{
    return block->identity & 0x1f;
}

static uint32_t payloads(const struct block *block)
{
    return (block->identity >> 5) + 1;
}

static uint32_t palette_bits(const struct block *block)
{
    uint32_t prefix = prefix_bits(block), count = payloads(block);
    if (!block->has_palette)
        return 0;
    return whole_bytes(prefix + block->triangles * bits_below(count) + count * (25 - prefix));
}

static uint32_t opacity_bits(const struct block *block)
{
    uint32_t count = block->descriptors;
    return count == 0 ? 0 : 64 + 32 * count + whole_bytes(block->triangles * bits_below(count));
}

/* Computes the position of each part. Returns false if the layout is invalid. */
static bool lay_out(struct block *block)
{
    uint32_t vertex = block->offset_bits[0] + block->offset_bits[1] + block->offset_bits[2];
    if (read_bits(block, 0, 8) != MAGIC || vertex % 4 != 0 ||
        (block->has_palette && prefix_bits(block) > 25))
        return false;
    block->palette = block->front + whole_bytes(vertex * block->vertices) + opacity_bits(block);
    block->reuse = block->palette + palette_bits(block);
    return block->reuse - block->front <= FRONT_MAX;
}

enum control {
    RESTART,
    EDGE1,
    EDGE2,
    BACKTRACK,
};

/* Reads vertex numbers one at a time. A bit marks the first use of a vertex, whose number is
 * counted; the numbers of reused vertices are stored. The controls run backwards from the end of
 * the block, followed by these bits. */
struct strip {
    const struct block *block;
    uint32_t first_bit; /* position of the next bit plus 1 */
    uint32_t reused, fresh, count;
    bool is_well_formed;
};

static uint32_t next_vertex(struct strip *strip)
{
    const struct block *block = strip->block;
    uint32_t vertex = strip->fresh;
    bool is_first = strip->count++ < 3 || read_bits(block, --strip->first_bit, 1);
    if (is_first) {
        strip->fresh++;
    } else {
        vertex = read_bits(block, strip->reused, block->index_bits);
        strip->reused += block->index_bits;
    }
    strip->is_well_formed &= vertex < block->vertices && strip->reused <= strip->first_bit &&
                             strip->reused - block->reuse <= REUSE_MAX;
    return vertex;
}

/* Copies an edge that the next triangle shares, in reverse, so that the winding is kept. */
static void copy_edge(uint8_t triangle[3], const uint8_t from[3], bool is_second)
{
    triangle[0] = is_second ? from[2] : from[0];
    triangle[1] = is_second ? from[1] : from[2];
}

/* Reads the vertices of each triangle. Returns false if the strip is malformed. */
static bool read_strip(const struct block *block, uint8_t triangles[TRIANGLES_MAX][3])
{
    struct strip strip = {.block = block,
                          .first_bit = BLOCK_BITS - 2 * (block->triangles - 1),
                          .reused = block->reuse,
                          .is_well_formed = true};
    enum control before = RESTART;
    for (uint32_t i = 0; i < block->triangles && strip.is_well_formed; i++) {
        enum control control =
            i == 0 ? RESTART : (enum control)read_bits(block, BLOCK_BITS - 2 * i, 2);
        uint8_t *triangle = triangles[i];
        if (control == BACKTRACK) {
            if (before != EDGE1 && before != EDGE2)
                return false;
            copy_edge(triangle, triangles[i - 2], before == EDGE2);
        } else if (control == RESTART) {
            triangle[0] = (uint8_t)next_vertex(&strip);
            triangle[1] = (uint8_t)next_vertex(&strip);
        } else {
            copy_edge(triangle, triangles[i - 1], control == EDGE1);
        }
        triangle[2] = (uint8_t)next_vertex(&strip);
        before = control;
    }
    return strip.is_well_formed;
}

/* Reads the geometry index and the opaque bit, 25 bits. Returns false if the payload does not
 * exist. */
static bool read_identity(const struct block *block, uint32_t triangle, uint32_t *identity)
{
    uint32_t prefix = prefix_bits(block), count = payloads(block), bits = bits_below(count);
    *identity = block->identity;
    if (!block->has_palette)
        return true;
    uint32_t indices = block->palette + prefix, rest = 25 - prefix;
    uint32_t index = read_bits(block, indices + triangle * bits, bits);
    if (index >= count)
        return false;
    *identity = read_bits(block, block->palette, prefix) << rest |
                read_bits(block, indices + block->triangles * bits + index * rest, rest);
    return true;
}

/* Computes an exact integer times a power of two. */
static void read_position(const struct block *block, uint32_t vertex, float position[3])
{
    const uint32_t *bits = block->offset_bits;
    uint32_t at = block->front + vertex * (bits[0] + bits[1] + bits[2]);
    for (int i = 0; i < 3; i++) {
        int32_t on_grid = block->anchor[i] + (int32_t)read_bits(block, at, bits[i]);
        position[i] = ldexpf((float)on_grid, (int)block->exponent - 127);
        at += bits[i];
    }
}

static void decode_triangle(const struct block *block, uint32_t number, const uint8_t vertices[3],
                            struct dense_triangle *to)
{
    uint32_t identity;
    *to = (struct dense_triangle){.found = SOURCE_ACTIVE};
    if (!read_identity(block, number, &identity)) {
        to->found = SOURCE_OUT_OF_RANGE;
        return;
    }
    read_position(block, vertices[0], to->a);
    read_position(block, vertices[1], to->b);
    read_position(block, vertices[2], to->c);
    to->geometry = identity >> 1;
    to->is_opaque = identity & 1;
    to->primitive = block->base + number;
    float sum = 0; /* 0 unless a component is not finite */
    for (int i = 0; i < 3; i++)
        sum += to->a[i] * 0 + to->b[i] * 0 + to->c[i] * 0;
    if (block->exponent < 1 || block->exponent > 232 || to->primitive > NUMBER_MAX || sum != 0)
        to->found = SOURCE_UNDEFINED;
}

void dense_decode(const struct builder_dense *dense, uint32_t count, struct dense_triangle *to)
{
    uint32_t done = 0;
    for (uint64_t at = 0; done < count && dense->size - at >= BLOCK_BYTES; at += BLOCK_BYTES) {
        struct block block = {.bytes = (const uint8_t *)dense->data + at};
        uint8_t triangles[TRIANGLES_MAX][3];
        read_header(&block);
        bool is_well_formed = lay_out(&block) && read_strip(&block, triangles);
        for (uint32_t i = 0; i < block.triangles && done < count; i++, done++)
            if (is_well_formed)
                decode_triangle(&block, i, triangles[i], &to[done]);
            else
                to[done] = (struct dense_triangle){.found = SOURCE_OUT_OF_RANGE};
    }
    for (; done < count; done++)
        to[done] = (struct dense_triangle){.found = SOURCE_OUT_OF_RANGE};
}
