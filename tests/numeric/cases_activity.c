/* SPDX-License-Identifier: Apache-2.0 */
/* Cases 1 to 4, 16 and 35 to 41: what is read from where, and what is active. */
#include <math.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

#include "cases.h"

#define ROW 5

/* Unit triangles side by side along X: number i is hit at x = 2 i + 0.25. */
static void make_row(float corners[9 * ROW])
{
    for (int i = 0; i < ROW; i++) {
        float x = (float)(2 * i), one[9] = {x, 0, 0, x + 1, 0, 0, x, 1, 0};
        memcpy(corners + (size_t)9 * i, one, sizeof(one));
    }
}

static struct trace_ray ray_to(int number)
{
    return fixture_ray((float)(2 * number) + 0.25f, 0.25f, 1, 0, 0, -1);
}

/* Whether exactly the triangles are hit whose bit is set, each by its number. */
static void check_row(const void *structure, unsigned active)
{
    for (int i = 0; i < ROW; i++) {
        const struct fixture_hits hits = case_hits(structure, ray_to(i));
        EXPECT(hits.count == (active >> i & 1));
        EXPECT(hits.count == 0 || hits.hits[0].primitive == (uint32_t)i);
    }
}

static void check_nan(int corner, int axis, float nan, const VkTransformMatrixKHR *transform)
{
    float corners[9 * ROW];
    make_row(corners);
    corners[9 * 2 + 3 * corner + axis] = nan;
    INPUT(triangles, input, corners, ROW);
    fixture_input_transform(&input, transform);
    void *structure = case_build(&input);
    EXPECT(report.active == ROW - 1 && report.inactive == 1);
    EXPECT(report.undefined == (axis > 0));
    EXPECT(axis == 0 || report.first_undefined.primitive == 2);
    check_row(structure, 0x1b);
}

CASE(1, 0, 0, "NaN in X of one vertex", "inactive")
{
    for (int corner = 0; corner < 3; corner++)
        check_nan(corner, 0, NAN, NULL);
}

CASE(2, 0, 0, "NaN in Y or Z only", "NaN in Y or Z")
{
    for (int i = 0; i < 6; i++)
        check_nan(i / 2, 1 + i % 2, NAN, NULL);
}

CASE(3, 0, 0, "signalling and negative NaN", "inactive")
{
    const uint32_t bits[] = {0x7fa00000, 0xffc00000, 0xff800001, 0x7f800001};
    for (int i = 0; i < 4; i++) {
        float corners[9 * ROW];
        make_row(corners);
        memcpy(&corners[9 * 2], &bits[i], sizeof(bits[i]));
        void *structure = case_triangles(corners, ROW);
        EXPECT(report.inactive == 1 && report.undefined == 0);
        check_row(structure, 0x1b);
    }
}

/* The identity keeps the row where it is; the NaN of X would spread to Y and Z. */
CASE(4, 0, 0, "NaN in X and a transform", "inactive")
{
    const VkTransformMatrixKHR identity = {{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}};
    check_nan(1, 0, NAN, &identity);
    check_nan(0, 0, -NAN, &identity);
}

CASE(16, 0, 0, "-0 and +0", "axis")
{
    float corners[9 * ROW], negative[9 * ROW];
    make_row(corners);
    for (int i = 0; i < 9 * ROW; i++)
        negative[i] = corners[i] == 0 ? -0.0f : corners[i];
    void *one = case_triangles(corners, ROW);
    void *other = case_triangles(negative, ROW);
    EXPECT(memcmp(one, other, builder_size(one)) == 0);
    check_row(other, 0x1f);
    for (int i = 0; i < ROW; i++) {
        struct trace_ray ray = ray_to(i), minus = ray;
        struct trace_hit hit, same;
        minus.direction[0] = minus.direction[1] = -0.0f;
        EXPECT(case_trace(one, ray, &hit) && case_trace(other, minus, &same) && hit.t == same.t);
    }
}

/* The row with every offset in use: positions scaled down by 2, moved back by the transform. */
CASE(35, 0, 0, "all offsets at once", "offsets in the build range")
{
    enum { SKIP = 3, FIRST = 2, STRIDE = 20 };
    static uint8_t vertices[64 + STRIDE * (SKIP + FIRST + 3 * ROW)];
    static uint16_t indices[8 + 3 * ROW];
    static VkTransformMatrixKHR transforms[2];
    float corners[9 * ROW];
    make_row(corners);
    transforms[1] = (VkTransformMatrixKHR){{{2, 0, 0, 2}, {0, 2, 0, -4}, {0, 0, 2, 6}}};
    for (int indexed = 0; indexed < 2; indexed++) {
        memset(vertices, 0x7f, sizeof(vertices));
        for (int i = 0; i < 3 * ROW; i++) {
            float at[3] = {(corners[3 * i] - 2) / 2, (corners[3 * i + 1] + 4) / 2,
                           (corners[3 * i + 2] - 6) / 2};
            int place = indexed ? SKIP + FIRST + i : FIRST + i;
            memcpy(vertices + (indexed ? 0 : 8) + (size_t)place * STRIDE, at, sizeof(at));
            indices[4 + i] = (uint16_t)(SKIP + i);
        }
        INPUT(triangles, input, NULL, ROW);
        input.range.firstVertex = FIRST;
        input.range.primitiveOffset = 8;
        input.range.transformOffset = sizeof(transforms[0]);
        struct builder_triangles *triangles = &input.geometry.triangles;
        triangles->vertices = vertices;
        triangles->vertices_size = sizeof(vertices);
        triangles->vertex_stride = STRIDE;
        triangles->max_vertex = SKIP + FIRST + 3 * ROW;
        triangles->index_type = indexed ? VK_INDEX_TYPE_UINT16 : VK_INDEX_TYPE_NONE_KHR;
        triangles->indices = indices;
        triangles->indices_size = sizeof(indices);
        triangles->transforms = transforms;
        triangles->transforms_size = sizeof(transforms);
        void *structure = case_build(&input);
        check_row(structure, 0x1f);
    }
}

static void *build_format(VkFormat format, const void *vertices, uint64_t stride,
                          uint32_t triangles, const VkTransformMatrixKHR *transform)
{
    INPUT(triangles, input, vertices, triangles);
    input.geometry.triangles.vertex_format = format;
    input.geometry.triangles.vertex_stride = stride;
    input.geometry.triangles.vertices_size = stride * triangles * 3;
    fixture_input_transform(&input, transform);
    return case_build(&input);
}

static void expect_bounds(const void *structure, const float lower[3], const float upper[3])
{
    float low[3], high[3];
    EXPECT(builder_bounds(structure, low, high));
    for (int i = 0; i < 3; i++)
        EXPECT(low[i] == lower[i] && high[i] == upper[i]);
}

CASE(36, 0, 0, "lowest SNORM16", "positions of 16 bits or fewer")
{
    const int16_t two[6] = {-32768, -32767, 32767, -32768, -32768, 32767};
    void *structure = build_format(VK_FORMAT_R16G16_SNORM, two, 4, 1, NULL);
    expect_bounds(structure, (float[3]){-1, -1, 0}, (float[3]){1, 1, 0});
    const int16_t four[12] = {-32768, -32767, 0, 7, 32767, -32768, 0, 7, -32768, 32767, -32768, 7};
    structure = build_format(VK_FORMAT_R16G16B16A16_SNORM, four, 8, 1, NULL);
    expect_bounds(structure, (float[3]){-1, -1, -1}, (float[3]){1, 1, 0});
}

CASE(37, 0, 0, "half: subnormal, infinite, NaN", "positions of 16 bits or fewer")
{
    /* 2^-24, the least; -2^-15, subnormal; 65504, the greatest */
    const uint16_t tiny[6] = {0x0001, 0x8200, 0x7bff, 0x8200, 0x0001, 0x7bff};
    void *structure = build_format(VK_FORMAT_R16G16_SFLOAT, tiny, 4, 1, NULL);
    expect_bounds(structure, (float[3]){0x1p-24f, -0x1p-15f, 0}, (float[3]){65504, 65504, 0});
    /* an infinite corner, then NaN in X, then a plain triangle */
    const uint16_t odd[36] = {0x7c00, 0, 0, 0, 0,      0x3c00, 0, 0, 0, 0,      0x3c00, 0,
                              0xfe01, 0, 0, 0, 0x3c00, 0,      0, 0, 0, 0,      0,      0,
                              0,      0, 0, 0, 0x3c00, 0,      0, 0, 0, 0x3c00, 0,      0};
    structure = build_format(VK_FORMAT_R16G16B16A16_SFLOAT, odd, 8, 3, NULL);
    EXPECT(report.active == 2 && report.inactive == 1);
    const struct fixture_hits hits = case_hits(structure, case_ray_down(0.25f, 0.25f));
    EXPECT(hits.count == 1 && hits.hits[0].primitive == 2);
}

CASE(38, 0, 0, "fourth component and a translation", "fourth component")
{
    const float vertices[12] = {0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, NAN};
    const VkTransformMatrixKHR moved = {{{1, 0, 0, 10}, {0, 1, 0, 20}, {0, 0, 1, 30}}};
    void *structure = build_format(VK_FORMAT_R32G32B32A32_SFLOAT, vertices, 16, 1, &moved);
    expect_bounds(structure, (float[3]){10, 20, 30}, (float[3]){11, 21, 30});
}

/* Vertices 3 GiB apart, in memory that is never filled: products need 64 bits. */
CASE(39, 0, 0, "large stride times index", "offsets in the build range")
{
    uint64_t stride = 0xfffffff0u, size = 3 * stride + 4096;
    uint8_t *vertices = mmap(NULL, size, PROT_READ | PROT_WRITE,
                             MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    EXPECT(vertices != MAP_FAILED);
    if (vertices == MAP_FAILED)
        return;
    const float corners[3][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    for (uint64_t i = 0; i < 3; i++)
        memcpy(vertices + (i + 1) * stride, corners[i], sizeof(corners[i]));
    const uint32_t indices[3] = {1, 2, 3}, wrapping[3] = {0xffffffff, 0x80000000, 0x10000001};
    struct fixture_mesh mesh = {(float *)vertices, (uint32_t *)indices, 4, 1};
    INPUT(mesh, input, &mesh);
    input.geometry.triangles.vertex_stride = stride;
    input.geometry.triangles.vertices_size = size;
    void *structure = case_build(&input);
    EXPECT(case_meets(structure, case_ray_down(0.25f, 0.25f)));
    input.geometry.triangles.indices = wrapping;
    input.geometry.triangles.max_vertex = 0xffffffff;
    input.range.firstVertex = 0xffffffff;
    EXPECT(case_fails(&input) && report.out_of_range == 1);
    munmap(vertices, size);
}

/* Vertices end where a page without access begins. */
CASE(40, 0, 0, "index out of range", "index out of range")
{
    size_t page = (size_t)sysconf(_SC_PAGESIZE);
    uint8_t *pages =
        mmap(NULL, 2 * page, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    EXPECT(pages != MAP_FAILED);
    if (pages == MAP_FAILED)
        return;
    mprotect(pages + page, page, PROT_NONE);
    const float corners[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    memcpy(pages + page - sizeof(corners), corners, sizeof(corners));
    const uint32_t indices[6] = {0, 1, 2, 0, 3, 2};
    struct fixture_mesh mesh = {(float *)(void *)(pages + page - sizeof(corners)),
                                (uint32_t *)indices, 3, 2};
    INPUT(mesh, input, &mesh);
    input.input.quality = setting.quality;
    EXPECT(case_fails(&input));
    EXPECT(report.out_of_range == 1 && report.first_out_of_range.primitive == 1);
    /* ... and where only maxVertex says so */
    input.geometry.triangles.vertices_size = BUILDER_ANY_SIZE;
    EXPECT(case_fails(&input) && report.out_of_range == 1);
    input.range.primitiveCount = 1;
    case_build(&input);
    munmap(pages, 2 * page);
}

CASE(41, 0, 0, "no primitives, no geometries", "nothing active")
{
    struct fixture_input input;
    struct trace_ray ray = fixture_ray(0, 0, 0, 0, 0, 1);
    float low[3], high[3];
    for (int i = 0; i < 3; i++) {
        if (i == 2)
            fixture_input_instances(&input, NULL, 0);
        else
            fixture_input_triangles(&input, NULL, 0);
        input.input.geometry_count = i == 1 ? 0 : 1;
        void *structure = case_build(&input);
        EXPECT(!case_meets(structure, ray));
        EXPECT(!builder_bounds(structure, low, high));
        EXPECT(builder_compacted_size(structure) <= builder_size(structure));
    }
}
