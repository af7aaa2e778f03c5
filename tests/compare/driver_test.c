/* SPDX-License-Identifier: Apache-2.0 */
/* What lavapipe builds and traces, right and wrong, compared without the layer. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bench.h"

enum { RAYS = 4096 };

static struct subject subject;
static struct tally tally;

static void compare(const struct subject *source, const char *name)
{
    bench_compare(source, &subject, RAYS, &tally);
    tally_print(&tally, name);
}

/* ---- what it does right: no finding */

static void expect_silence(const struct subject *source, const char *name)
{
    compare(source, name);
    assert_int_equal(tally.all, 0);
}

TEST(test_ranges)
{
    uint32_t indices[3 * SOUP_TRIANGLES];
    for (uint32_t i = 0; i < 3 * SOUP_TRIANGLES; i++)
        indices[i] = i;
    subject_soup(&subject);
    expect_silence(NULL, "separate triangles");
    subject.ranges[0] = (VkAccelerationStructureBuildRangeInfoKHR){50, 36 * 5, 0, 0};
    expect_silence(NULL, "primitiveOffset of vertices");
    subject_triangles(&subject, soup_vertices, 3 * SOUP_TRIANGLES, indices, SOUP_TRIANGLES);
    subject.ranges[1] = (VkAccelerationStructureBuildRangeInfoKHR){40, 12 * 5, 0, 0};
    expect_silence(NULL, "two geometries, primitiveOffset of indices");
    subject_triangles(&subject, NULL, 3, NULL, 0);
    expect_silence(NULL, "and an empty one");
}

TEST(test_transform)
{
    VkTransformMatrixKHR transforms[2] = {0};
    transforms[1] = (VkTransformMatrixKHR){{{0, 1, 0, 3}, {2, 0, 0, 0}, {0, 0, .5f, 1}}};
    subject_soup(&subject);
    subject.geometries[0].geometry.triangles.transformData.hostAddress = transforms;
    subject.ranges[0].transformOffset = sizeof(transforms[0]);
    expect_silence(NULL, "a transform at an offset");
}

TEST(test_formats)
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
    expect_silence(NULL, "normalized vertices, indices of 16 bits");
    triangles->vertexFormat = VK_FORMAT_R16G16_SNORM;
    expect_silence(NULL, "in a plane"); /* they overlap, and any of them may come first */
}

TEST(test_update)
{
    struct subject source;
    float before[9 * SOUP_TRIANGLES];
    subject_update(&source, &subject, before);
    expect_silence(&source, "an update");
}

/* Boxes are met but for rays that end or begin at a face. */
TEST(test_boxes)
{
    VkAabbPositionsKHR boxes[BOXES];
    subject_grid(&subject, boxes);
    compare(NULL, "boxes");
    assert_int_equal(tally.all, tally.by_aim[AIM_LIMIT]);
}

/* ---- what lavapipe of Mesa 25.0.7 does wrong, and others may not */

static void expect_defect(const char *name, enum difference difference, enum judge_reason reason)
{
    compare(NULL, name);
    if (strstr(bench.driver, "Mesa 25.0.7"))
        assert_true(tally.counts[difference][reason] > 0);
}

TEST(test_ring)
{
    subject_ring(&subject);
    expect_defect("a closed fan", DIFFERENCE_MISSED, REASON_SHARED);
    expect_defect("a closed fan", DIFFERENCE_DOUBLE, REASON_SHARED);
    assert_true(tally.once > RAYS / 4);
    assert_int_equal(tally.all, tally.counts[DIFFERENCE_MISSED][REASON_SHARED] +
                                    tally.counts[DIFFERENCE_DOUBLE][REASON_SHARED]);
}

/* What isn't at a shared edge or vertex is right. */
TEST(test_sphere)
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
    compare(NULL, "a sphere");
    assert_true(tally.once > RAYS / 2);
    assert_int_equal(tally.all, tally.counts[DIFFERENCE_MISSED][REASON_SHARED] +
                                    tally.counts[DIFFERENCE_DOUBLE][REASON_SHARED]);
}

TEST(test_first_vertex)
{
    subject_first_vertex(&subject);
    expect_defect("firstVertex", DIFFERENCE_MISSED, REASON_MEETS);
    expect_defect("firstVertex", DIFFERENCE_EXTRA, REASON_PASSES);
    expect_defect("firstVertex", DIFFERENCE_PRIMITIVE, REASON_PASSES);
}

TEST(test_inactive)
{
    VkAabbPositionsKHR boxes[BOXES];
    float vertices[9 * SOUP_TRIANGLES];
    subject_inactive(&subject, vertices);
    expect_defect("the last triangle inactive", DIFFERENCE_MISSED, REASON_MEETS);
    subject_grid(&subject, boxes);
    boxes[13].minX = NAN;
    expect_defect("a box inactive", DIFFERENCE_MISSED, REASON_MEETS);
    expect_defect("a box inactive", DIFFERENCE_MISSED, REASON_LIMIT);
}

const char *unit_test_open(const char *argument)
{
    return bench_open_tests(argument, BENCH_QUERIES, BENCH_PIPELINES);
}

void unit_test_close(void)
{
    bench_close();
}
