/* SPDX-License-Identifier: Apache-2.0 */
/* Cases 65 to 67: dense geometry (VK_AMDX_dense_geometry_format), from blocks that are written here
 * by the words of the specification. */
#include <math.h>
#include <string.h>

#include "cases.h"

#define BLOCK 128
#define TRIANGLES 20
#define VERTICES 30

enum { RESTART, EDGE1, EDGE2, BACKTRACK };

/* What a block says. */
struct content {
    uint32_t vertices, triangles;
    uint32_t offset_bits[3], exponent;
    int32_t anchor[3];
    uint16_t offsets[VERTICES][3];
    uint8_t controls[TRIANGLES], corners[TRIANGLES][3];
    uint8_t used[3 * TRIANGLES]; /* vertices in the order in which they are stored */
    uint32_t used_count;
    uint32_t geometry[TRIANGLES];
    bool opaque[TRIANGLES];
    uint32_t base, descriptors;
    bool has_palette, has_user_data;
};

static uint32_t position_bits(const struct content *content)
{
    return content->offset_bits[0] + content->offset_bits[1] + content->offset_bits[2];
}

/* A strip at random: each triangle's control, then its new vertices, fresh ones or used again. */
static void make_strip(struct content *content, uint64_t *random)
{
    uint32_t fresh = 0;
    for (uint32_t i = 0; i < content->triangles; i++) {
        uint8_t *to = content->corners[i], before = i > 0 ? content->controls[i - 1] : RESTART;
        uint8_t control = (uint8_t)(i == 0 ? RESTART : fixture_random(random) % 4);
        if (control == BACKTRACK && before != EDGE1 && before != EDGE2)
            control = EDGE2;
        content->controls[i] = control;
        for (uint32_t j = control == RESTART ? 0 : 2; j < 3; j++) {
            bool is_fresh = content->used_count < 3 ||
                            (fresh < content->vertices && fixture_random(random) % 3 > 0);
            to[j] = (uint8_t)(is_fresh ? fresh++ : fixture_random(random) % fresh);
            content->used[content->used_count++] = to[j];
        }
        const uint8_t *from = i >= 2 && control == BACKTRACK ? content->corners[i - 2]
                              : i >= 1                       ? content->corners[i - 1]
                                                             : to;
        bool is_second = control == EDGE1 || (control == BACKTRACK && before == EDGE2);
        if (control != RESTART) { /* "reuse the 1->2 edge": 2, 1; "the 2->0 edge": 0, 2 */
            to[0] = from[is_second ? 2 : 0];
            to[1] = from[is_second ? 1 : 2];
        }
    }
    content->vertices = fresh;
}

static struct content make_content(uint64_t *random, uint32_t base)
{
    struct content content = {.vertices = VERTICES, .triangles = TRIANGLES, .base = base};
    make_strip(&content, random);
    content.exponent = 120 + (uint32_t)(fixture_random(random) % 5);
    content.has_palette = fixture_random(random) % 2; /* beside small offsets there is room */
    for (int i = 0; i < 3; i++) {
        content.offset_bits[i] = content.has_palette || fixture_random(random) % 2 ? 4 : 8;
        content.anchor[i] = (int32_t)(fixture_random(random) % 2000) - 1000;
    }
    for (uint32_t i = 0; i < content.vertices; i++)
        for (int j = 0; j < 3; j++)
            content.offsets[i][j] =
                (uint16_t)(fixture_random(random) & ((1u << content.offset_bits[j]) - 1));
    content.has_user_data = fixture_random(random) % 2;
    content.descriptors = content.has_palette ? 0 : (uint32_t)(fixture_random(random) % 3);
    if (content.vertices * position_bits(&content) > 480)
        content.descriptors = 0;
    for (uint32_t i = 0; i < content.triangles; i++) {
        bool is_first = !content.has_palette || i % 3 == 0;
        content.geometry[i] = is_first ? 300 : 301;
        content.opaque[i] = is_first;
    }
    return content;
}

static uint32_t write_palette(uint8_t *block, uint32_t at, const struct content *content)
{
    const uint32_t payloads[3] = {300 << 1 | 1, 301 << 1, 0x12d << 1};
    uint32_t begin = at, prefix = 15, rest = 25 - prefix;
    fixture_put_bits(block, 22, 10, prefix | 2 << 5); /* three payloads */
    fixture_put_bits(block, at, prefix, payloads[0] >> rest);
    at += prefix;
    for (uint32_t i = 0; i < content->triangles; i++, at += 2)
        fixture_put_bits(block, at, 2, i % 3);
    for (int i = 0; i < 3; i++, at += rest)
        fixture_put_bits(block, at, rest, payloads[i] & ((1u << rest) - 1));
    return begin + (at - begin + 7) / 8 * 8;
}

static void write_topology(uint8_t *block, uint32_t reuse, const struct content *content)
{
    uint32_t first_bit = 8 * BLOCK - 2 * (content->triangles - 1), fresh = 3;
    for (uint32_t i = 1; i < content->triangles; i++)
        fixture_put_bits(block, 8 * BLOCK - 2 * i, 2, content->controls[i]);
    for (uint32_t i = 3; i < content->used_count; i++) {
        bool is_first = content->used[i] == fresh;
        fixture_put_bits(block, --first_bit, 1, is_first);
        fresh += is_first;
        if (!is_first) {
            fixture_put_bits(block, reuse, 5, content->used[i]);
            reuse += 5;
        }
    }
}

static void write_block(uint8_t block[BLOCK], const struct content *content)
{
    memset(block, 0, BLOCK);
    fixture_put_bits(block, 0, 8, 6);
    fixture_put_bits(block, 8, 2, 2); /* 5 bits an index */
    fixture_put_bits(block, 10, 6, content->vertices - 1);
    fixture_put_bits(block, 16, 6, content->triangles - 1);
    fixture_put_bits(block, 22, 10, content->geometry[0] << 1 | content->opaque[0]);
    fixture_put_bits(block, 32, 8, content->exponent);
    for (uint32_t i = 0; i < 3; i++) {
        fixture_put_bits(block, (uint32_t[]){64, 68, 96}[i], 4, content->offset_bits[i] - 1);
        fixture_put_bits(block, 40 + 32 * i, 24, (uint32_t)content->anchor[i]);
    }
    fixture_put_bits(block, 100, 3, content->descriptors);
    fixture_put_bits(block, 103, 1, content->has_palette);
    fixture_put_bits(block, 128, 29, content->base);
    fixture_put_bits(block, 157, 1, content->has_user_data);
    uint32_t at = content->has_user_data ? 192 : 160;
    if (content->has_user_data)
        fixture_put_bits(block, 160, 32, 0xdeadbeef);
    for (uint32_t i = 0; i < content->vertices; i++)
        for (int j = 0; j < 3; j++) {
            fixture_put_bits(block, at, content->offset_bits[j], content->offsets[i][j]);
            at += content->offset_bits[j];
        }
    at = (at + 7) / 8 * 8;
    if (content->descriptors > 0)
        at += 64 + 32 * content->descriptors + (content->descriptors > 1 ? 24 : 0);
    if (content->has_palette)
        at = write_palette(block, at, content);
    write_topology(block, at, content);
}

static void corners_of(const struct content *content, uint32_t triangle, float corners[9])
{
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            int32_t at = content->anchor[j] + content->offsets[content->corners[triangle][i]][j];
            corners[3 * i + j] = ldexpf((float)at, (int)content->exponent - 127);
        }
}

static void describe(struct fixture_input *input, const uint8_t *blocks, uint32_t count)
{
    fixture_input_triangles(input, NULL, count * TRIANGLES);
    input->geometry.type = VK_GEOMETRY_TYPE_DENSE_GEOMETRY_FORMAT_TRIANGLES_AMDX;
    input->geometry.dense = (struct builder_dense){
        .data = blocks, .size = (uint64_t)count * BLOCK, .max_primitive = 0x1fffffff};
}

/* A ray to a point of each triangle: it meets it with the weights, numbers and opacity there. */
static void expect_triangles(const void *structure, const struct content *content)
{
    for (uint32_t i = 0; i < content->triangles; i++) {
        float corners[9];
        double normal[3], target[3], size = 0;
        corners_of(content, i, corners);
        for (int j = 0; j < 3; j++) {
            int k = (j + 1) % 3, l = (j + 2) % 3;
            normal[j] = (double)(corners[3 + k] - corners[k]) * (corners[6 + l] - corners[l]) -
                        (double)(corners[3 + l] - corners[l]) * (corners[6 + k] - corners[k]);
            target[j] = 0.1 * corners[j] + 0.6 * corners[3 + j] + 0.3 * corners[6 + j];
            size += fabs(normal[j]);
        }
        if (size == 0) /* a line or a point */
            continue;
        struct trace_ray ray = fixture_ray(0, 0, 0, 0, 0, 0);
        for (int j = 0; j < 3; j++) {
            ray.direction[j] = (float)(-normal[j] / size);
            ray.origin[j] = (float)(target[j] - ray.direction[j]);
        }
        const struct fixture_hits hits = case_hits(structure, ray);
        const struct trace_hit *hit = case_find_hit(&hits, content->base + i);
        EXPECT(hit && hit->geometry == content->geometry[i] && hit->opaque == content->opaque[i] &&
               hit->front_face && fabsf(hit->u - 0.6f) < 1e-3f && fabsf(hit->v - 0.3f) < 1e-3f);
    }
}

CASE(65, 0, 0, "blocks of dense geometry", "dense geometry")
{
    enum { COUNT = 24 };
    static uint8_t blocks[COUNT][BLOCK];
    static struct content contents[COUNT];
    struct fixture_input input;
    uint64_t random = 109;
    for (uint32_t i = 0; i < COUNT; i++) {
        contents[i] = make_content(&random, 1000 * i);
        write_block(blocks[i], &contents[i]);
    }
    describe(&input, blocks[0], COUNT);
    void *structure = case_build(&input);
    EXPECT(report.active == COUNT * TRIANGLES);
    for (uint32_t i = 0; i < COUNT; i++)
        expect_triangles(structure, &contents[i]);
}

/* Without a palette and without descriptors. */
static struct content make_plain_content(uint64_t random, uint32_t base)
{
    struct content content = make_content(&random, base);
    content.has_palette = false;
    content.descriptors = 0;
    return content;
}

/* What no block may say: nothing is read outside, and the build says where. */
CASE(66, 0, 0, "blocks that aren't sound", "dense geometry")
{
    uint8_t good[BLOCK], bad[BLOCK];
    struct fixture_input input;
    struct content content = make_plain_content(113, 7);
    content.controls[1] = EDGE1;
    write_block(good, &content);
    const struct {
        uint32_t at, bits, value;
        bool is_undefined;
    } damages[] = {
        {0, 8, 7, false},             /* magic */
        {64, 4, 14, false},           /* vertices that aren't multiples of 4 bits */
        {10, 6, 0, false},            /* fewer vertices than indices name */
        {8 * BLOCK - 2, 2, 3, false}, /* a second triangle that goes back */
        {103, 1, 1, false},           /* a palette that doesn't fit */
        {32, 8, 0, true},             /* exponents */
        {32, 8, 233, true},
        {128, 29, 0x1fffffff, true}, /* numbers that need 30 bits */
    };
    for (size_t i = 0; i < sizeof(damages) / sizeof(damages[0]); i++) {
        memcpy(bad, good, BLOCK);
        fixture_put_bits(bad, damages[i].at, damages[i].bits, damages[i].value);
        if (damages[i].at == 103)
            fixture_put_bits(bad, 22, 10, 0x3ff); /* a prefix of 31 bits */
        describe(&input, bad, 1);
        input.input.quality = setting.quality;
        void *structure = fixture_build(&input.input, &report);
        EXPECT((structure != NULL) == damages[i].is_undefined);
        EXPECT(damages[i].is_undefined ? report.undefined > 0 : report.out_of_range > 0);
    }
    describe(&input, good, 1);
    input.geometry.dense.size = BLOCK - 1;
    EXPECT(case_fails(&input) && report.out_of_range == TRIANGLES);
    describe(&input, good, 1);
    input.geometry.dense.max_primitive = 7 + 3;
    case_build(&input);
    EXPECT(report.undefined == TRIANGLES - 4);
}

/* Positions may change, and opacities go by the numbers in the blocks. */
CASE(67, 0, 0, "updates and opacities of dense geometry", "dense geometry")
{
    uint8_t block[BLOCK];
    struct fixture_input input;
    struct content content = make_plain_content(127, 2);
    for (uint32_t i = 0; i < content.triangles; i++) {
        content.geometry[i] = 300;
        content.opaque[i] = true;
    }
    write_block(block, &content);
    describe(&input, block, 1);
    void *structure = case_build(&input);
    struct builder_sizes sizes;
    EXPECT(builder_get_sizes(&input.input, NULL, &sizes) == BUILDER_OK);
    content.anchor[0] += 40;
    write_block(block, &content);
    EXPECT(fixture_refit(&input.input, structure, structure, NULL) == BUILDER_OK);
    expect_triangles(structure, &content);
    case_expect_same_bounds(structure, case_build(&input));
    uint8_t indices[TRIANGLES + 2];
    memset(indices, 0xfd, sizeof(indices)); /* -3 but for primitive 2, the first of the block */
    indices[2] = 0xfe;
    struct builder_opacity opacity = {.index_type = VK_INDEX_TYPE_UINT8_KHR,
                                      .indices = indices,
                                      .indices_size = sizeof(indices),
                                      .stride = 1};
    input.geometry.dense.opacity = &opacity;
    input.geometry.dense.max_primitive = TRIANGLES + 1;
    structure = case_build(&input);
    for (uint32_t i = 1; i < content.triangles; i++)
        content.opaque[i] = false;
    expect_triangles(structure, &content);
    input.geometry.dense.max_primitive++;
    EXPECT(case_fails(&input));
}
