/* SPDX-License-Identifier: Apache-2.0 */
/* The layer compares what an application builds on lavapipe: which messages come, and that none
 * comes where the driver is right. What is wrong of a BLAS is found through an instance, too. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bench.h"
#include "layer/compare/tracer.h"
#include "tests/fixture/copies.h"

static struct subject subject;
static struct messages *const messages = &bench.instance.messages;

/* Builds on the application's queue, in memory of its own; `source` as in bench_compare(). */
static void build(const struct subject *source)
{
    const struct compare_device *device = &bench.compare;
    struct compare_structure structure = {0}, update = {0};
    const struct subject *first = source ? source : &subject;
    VkCommandBuffer commands = bench_begin();
    GET(compare_structure_create(device, &first->input, NULL, &structure));
    compare_structure_build(device, commands, &first->input, NULL, &structure);
    if (source) {
        GET(compare_structure_create(device, &subject.input, &structure, &update));
        compare_structure_build(device, commands, &subject.input, &structure, &update);
    }
    messages_clear(messages);
    bench_submit(commands);
    bench_finish(commands);
    compare_structure_free(device, &update);
    compare_structure_free(device, &structure);
}

static void expect_silence(const struct subject *source)
{
    build(source);
    messages_expect_none(messages);
}

/* The message is there if this is the lavapipe that errs. */
static void expect_defect(enum difference difference, const char *words)
{
    build(NULL);
    if (!strstr(bench.driver, "Mesa 25.0.7"))
        return;
    assert_int_equal(bench_count(difference), 1);
    if (!messages_count(messages, difference_id(difference), words))
        fail_msg("\"%s\" is not in: %s", words, messages->items[0].text);
}

TEST(ranges)
{
    uint32_t indices[3 * SOUP_TRIANGLES];
    for (uint32_t i = 0; i < 3 * SOUP_TRIANGLES; i++)
        indices[i] = i;
    subject_soup(&subject);
    expect_silence(NULL);
    subject.ranges[0] = (VkAccelerationStructureBuildRangeInfoKHR){50, 36 * 5, 0, 0};
    expect_silence(NULL);
    subject_triangles(&subject, soup_vertices, 3 * SOUP_TRIANGLES, indices, SOUP_TRIANGLES);
    subject.ranges[1] = (VkAccelerationStructureBuildRangeInfoKHR){40, 12 * 5, 0, 0};
    expect_silence(NULL);
    subject_triangles(&subject, NULL, 3, NULL, 0); /* an empty geometry */
    expect_silence(NULL);
}

TEST(a_transform_at_an_offset)
{
    VkTransformMatrixKHR transforms[2] = {0};
    transforms[1] = (VkTransformMatrixKHR){{{0, 1, 0, 3}, {2, 0, 0, 0}, {0, 0, .5f, 1}}};
    subject_soup(&subject);
    subject.geometries[0].geometry.triangles.transformData.hostAddress = transforms;
    subject.ranges[0].transformOffset = sizeof(transforms[0]);
    expect_silence(NULL);
}

TEST(formats)
{
    uint16_t indices[3 * SOUP_TRIANGLES];
    int16_t vertices[3 * SOUP_TRIANGLES][4];
    for (uint32_t i = 0; i < 3 * SOUP_TRIANGLES; i++) {
        indices[i] = (uint16_t)i;
        for (int j = 0; j < 4; j++)
            vertices[i][j] = j == 3 ? 0 : (int16_t)(soup_vertices[3 * i + (uint32_t)j] * 3000);
    }
    subject_begin(&subject);
    subject_triangles(&subject, NULL, 3 * SOUP_TRIANGLES, NULL, SOUP_TRIANGLES);
    VkAccelerationStructureGeometryTrianglesDataKHR *triangles =
        &subject.geometries[0].geometry.triangles;
    triangles->indexType = VK_INDEX_TYPE_UINT16;
    triangles->indexData.hostAddress = indices;
    triangles->vertexFormat = VK_FORMAT_R16G16B16A16_SNORM;
    triangles->vertexStride = sizeof(vertices[0]);
    triangles->vertexData.hostAddress = vertices;
    expect_silence(NULL);
    triangles->vertexFormat = VK_FORMAT_R16G16_SNORM;
    expect_silence(NULL); /* they overlap, and any of them may come first */
}

TEST(updates)
{
    struct subject source;
    float before[9 * SOUP_TRIANGLES];
    subject_update(&source, &subject, before);
    expect_silence(&source);
}

TEST(ring)
{
    subject_ring(&subject);
    expect_defect(DIFFERENCE_MISSED,
                  "By exact arithmetic the ray meets exactly one of the triangles that share");
    expect_defect(DIFFERENCE_DOUBLE, "pInfos[0].pGeometries[0] primitive ");
}

TEST(first_vertex)
{
    subject_first_vertex(&subject);
    expect_defect(DIFFERENCE_MISSED, "the ray meets the primitive, away from its boundary");
    expect_defect(DIFFERENCE_EXTRA, "misses the primitive that the driver reports");
    expect_defect(DIFFERENCE_PRIMITIVE, "in place of another");
}

TEST(inactive)
{
    float vertices[9 * SOUP_TRIANGLES];
    VkAabbPositionsKHR boxes[BOXES];
    subject_inactive(&subject, vertices);
    expect_defect(DIFFERENCE_MISSED, "Driver: no hit");
    subject_grid(&subject, boxes);
    boxes[13].minX = NAN;
    expect_defect(DIFFERENCE_MISSED, "the ray meets the box");
}

/* What isn't at a shared edge or vertex is right. */
TEST(sphere)
{
    enum { RINGS = 60, SEGMENTS = 120 };
    static float vertices[RINGS + 1][SEGMENTS][3];
    static uint32_t indices[RINGS * SEGMENTS][6];
    for (uint32_t i = 0; i <= RINGS; i++)
        for (uint32_t j = 0; j < SEGMENTS; j++) {
            double polar = M_PI * i / RINGS, around = 2 * M_PI * j / SEGMENTS;
            double radius = i == 0 || i == RINGS ? 0 : sin(polar);
            vertices[i][j][0] = (float)(radius * cos(around));
            vertices[i][j][1] = (float)(radius * sin(around));
            vertices[i][j][2] = (float)cos(polar);
        }
    for (uint32_t i = 0; i < RINGS * SEGMENTS; i++) {
        uint32_t next = i % SEGMENTS == SEGMENTS - 1 ? i + 1 - SEGMENTS : i + 1;
        const uint32_t corners[6] = {i, i + SEGMENTS, next + SEGMENTS, i, next + SEGMENTS, next};
        memcpy(indices[i], corners, sizeof(corners));
    }
    subject_begin(&subject);
    subject_triangles(&subject, &vertices[0][0][0], (RINGS + 1) * SEGMENTS, &indices[0][0],
                      2 * RINGS * SEGMENTS);
    build(NULL);
    assert_int_equal(bench_count(DIFFERENCE_MISSED) + bench_count(DIFFERENCE_DOUBLE),
                     messages->count);
}

TEST(boxes)
{
    VkAabbPositionsKHR boxes[BOXES];
    subject_grid(&subject, boxes);
    expect_defect(DIFFERENCE_MISSED,
                  "the ray meets the box at tmin or tmax, which counts as a hit");
    assert_true(messages->count <= 1);
}

static void copy_structure(VkCommandBuffer commands, const struct compare_structure *from,
                           const struct compare_structure *to)
{
    const VkCopyAccelerationStructureInfoKHR info =
        copy_info(from->handle, to->handle, VK_COPY_ACCELERATION_STRUCTURE_MODE_CLONE_KHR);
    bench.vk.CmdCopyAccelerationStructureKHR(commands, &info);
    commands_barrier(&bench.vk, commands);
}

enum { INSTANCES_MAX = 9 };

/* An instance of the subject, or of boxes. */
struct placed {
    float angle, size, x;
    enum { OF_SUBJECT, OF_BOXES, OF_NOTHING } of;
    bool is_flipped, is_mirrored, is_masked;
};

static VkAccelerationStructureInstanceKHR instance_of(const struct placed *placed)
{
    const float c = placed->size * cosf(placed->angle), s = placed->size * sinf(placed->angle);
    const float side = placed->is_mirrored ? -1 : 1;
    return (VkAccelerationStructureInstanceKHR){
        .transform.matrix = {{side * c, side * -s, 0, placed->x},
                             {s, c, 0, 2},
                             {0, 0, placed->size, -1}},
        .mask = placed->is_masked ? 0 : 0xff,
        .flags = placed->is_flipped ? VK_GEOMETRY_INSTANCE_TRIANGLE_FLIP_FACING_BIT_KHR : 0,
        .instanceCustomIndex = 99};
}

/* Builds a top-level structure with instances of the subject, or of a copy of it. */
static void build_top(const struct placed *placed, uint32_t count, bool array_of_pointers,
                      bool is_copied)
{
    const struct compare_device *device = &bench.compare;
    static VkAabbPositionsKHR grid[BOXES];
    struct subject boxes;
    VkAccelerationStructureInstanceKHR instances[INSTANCES_MAX];
    struct compare_structure bottom = {0}, copy = {0}, of_boxes = {0}, structure = {0};
    VkCommandBuffer commands = bench_begin();
    subject_grid(&boxes, grid);
    for (uint32_t i = 0; i < count; i++)
        instances[i] = instance_of(&placed[i]);
    const struct compare_instances top = {
        .count = count, .instances = instances, .array_of_pointers = array_of_pointers};
    GET(compare_structure_create(device, &subject.input, NULL, &bottom));
    GET(compare_structure_create(device, &subject.input, NULL, &copy));
    GET(compare_structure_create(device, &boxes.input, NULL, &of_boxes));
    GET(compare_structure_create_top(device, &top, &structure));
    const uint64_t addresses[] = {
        structure_address(&bench.vk, bench.device, is_copied ? copy.handle : bottom.handle),
        structure_address(&bench.vk, bench.device, of_boxes.handle), 0};
    for (uint32_t i = 0; i < count; i++)
        compare_structure_set_instance(&structure, &top, i, addresses[placed[i].of], 5);
    compare_structure_build(device, commands, &subject.input, NULL, &bottom);
    compare_structure_build(device, commands, &boxes.input, NULL, &of_boxes);
    if (is_copied)
        copy_structure(commands, &bottom, &copy);
    compare_structure_build_top(device, commands, &structure);
    messages_clear(messages);
    bench_submit(commands);
    bench_finish(commands);
    compare_structure_free(device, &structure);
    compare_structure_free(device, &of_boxes);
    compare_structure_free(device, &copy);
    compare_structure_free(device, &bottom);
}

/* Only what the boxes by themselves have. */
static void expect_right_top(void)
{
    for (uint32_t i = 0; i < messages_kept(messages); i++)
        assert_lacks(messages->items[i].text, "makes a TLAS");
}

/* Inactive instances come last: Mesa 26.1 loses as many of the last instances as are inactive or
 * have mask 0, or crashes. */
TEST(tops)
{
    static const struct placed right[INSTANCES_MAX] = {
        {0, 1, 0, OF_SUBJECT},
        {0.5f, 2, 30, OF_SUBJECT},
        {2, 0.25f, 5, OF_BOXES},
        {1, 100, -2000, OF_SUBJECT, .is_flipped = true},
        {4, 3, 9, OF_BOXES},
        {5, 1e-3f, 3, OF_SUBJECT, .is_mirrored = true},
        {0.25f, 1, 2, OF_SUBJECT},
        {1, 1, 1, OF_NOTHING},
        {3, 1, 8, OF_SUBJECT, .is_masked = true}};
    subject_soup(&subject);
    for (uint32_t kinds = 0; kinds < 4; kinds++) {
        build_top(right, INSTANCES_MAX, kinds & 1, kinds & 2);
        expect_right_top();
    }
    build_top(right, 0, false, false);
    expect_right_top();
    if (strstr(bench.driver, "Mesa 26."))
        return;
    build_top((const struct placed[]){right[0], right[7], right[1]}, 3, false, false);
    expect_right_top();
}

TEST(rings_in_tops)
{
    static const struct placed two[] = {{0.5f, 2, 10, OF_SUBJECT}, {1, 1, -10, OF_SUBJECT}};
    subject_ring(&subject);
    for (uint32_t kinds = 0; kinds < 4; kinds++) {
        build_top(two, 2, kinds & 1, kinds & 2);
        if (!strstr(bench.driver, "Mesa 25.0.7"))
            continue;
        assert_int_equal(bench_count(DIFFERENCE_DOUBLE), 2);
        assert_true(messages_count(messages, difference_id(DIFFERENCE_DOUBLE),
                                   "pInfos[0] makes a TLAS whose instance") > 0);
    }
}

const char *unit_test_open(const char *argument)
{
    setenv("VK_ASSAY_VALIDATION_LEVEL", "content", 1);
    setenv("VK_ASSAY_VALIDATION_COMPARE_RAYS", "4096", 1);
    setenv("VK_ASSAY_VALIDATION_ENABLE_MESSAGE_LIMIT", "false", 1);
    return bench_open_tests(argument);
}

void unit_test_close(void)
{
    bench_close();
}
