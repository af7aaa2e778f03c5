/* SPDX-License-Identifier: Apache-2.0 */
/* The layer compares what an application builds on lavapipe: which messages come, and that none
 * comes where the driver is right. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bench.h"
#include "layer/compare/structures.h"
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

TEST(test_right)
{
    struct subject source;
    float before[9 * SOUP_TRIANGLES];
    subject_soup(&subject);
    expect_silence(NULL);
    subject.ranges[0] = (VkAccelerationStructureBuildRangeInfoKHR){50, 36 * 5, 0, 0};
    subject_triangles(&subject, soup_vertices, 3 * SOUP_TRIANGLES, NULL, 20);
    expect_silence(NULL);

    subject_update(&source, &subject, before);
    expect_silence(&source);
}

TEST(test_ring)
{
    subject_ring(&subject);
    expect_defect(DIFFERENCE_MISSED,
                  "By exact arithmetic the ray meets exactly one of the triangles that share");
    expect_defect(DIFFERENCE_DOUBLE, "pInfos[0].pGeometries[0] primitive ");
}

TEST(test_first_vertex)
{
    subject_first_vertex(&subject);
    expect_defect(DIFFERENCE_MISSED, "the ray meets the primitive, away from its boundary");
    expect_defect(DIFFERENCE_EXTRA, "misses the primitive that the driver reports");
    expect_defect(DIFFERENCE_PRIMITIVE, "in place of another");
}

TEST(test_inactive)
{
    float vertices[9 * SOUP_TRIANGLES];
    subject_inactive(&subject, vertices);
    expect_defect(DIFFERENCE_MISSED, "Driver: no hit");
}

TEST(test_boxes)
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

/* Of two instances of the subject, or of a copy of it, one of them turned and larger, and an
 * inactive one. */
static void build_top(bool array_of_pointers, bool is_copied)
{
    const struct compare_device *device = &bench.compare;
    VkAccelerationStructureInstanceKHR instances[3] = {
        {.transform.matrix = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}, .mask = 0xff},
        {.transform.matrix = {{0, -2, 0, 40}, {2, 0, 0, 1}, {0, 0, 2, 0}}, .mask = 1},
        {.mask = 0xff},
    };
    const struct compare_instances top = {
        .count = 3, .instances = instances, .array_of_pointers = array_of_pointers};
    struct compare_structure bottom = {0}, copy = {0}, structure = {0};
    VkCommandBuffer commands = bench_begin();
    GET(compare_structure_create(device, &subject.input, NULL, &bottom));
    GET(compare_structure_create(device, &subject.input, NULL, &copy));
    GET(compare_structure_create_top(device, &top, &structure));
    const uint64_t address =
        structure_address(&bench.vk, bench.device, is_copied ? copy.handle : bottom.handle);
    for (uint32_t i = 0; i < 3; i++)
        compare_structure_set_instance(&structure, &top, i, i < 2 ? address : 0, 5);
    compare_structure_build(device, commands, &subject.input, NULL, &bottom);
    if (is_copied)
        copy_structure(commands, &bottom, &copy);
    compare_structure_build_top(device, commands, &structure);
    messages_clear(messages);
    bench_submit(commands);
    bench_finish(commands);
    compare_structure_free(device, &structure);
    compare_structure_free(device, &copy);
    compare_structure_free(device, &bottom);
}

TEST(test_top)
{
    subject_soup(&subject);
    for (int kinds = 0; kinds < 4; kinds++) {
        build_top(kinds & 1, kinds & 2);
        messages_expect_none(messages);
    }
    subject_ring(&subject);
    for (int kinds = 0; kinds < 4; kinds++) {
        build_top(kinds & 1, kinds & 2);
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
    return bench_open_tests(argument, BENCH_LAYER, BENCH_LAYER_PIPELINES);
}

void unit_test_close(void)
{
    bench_close();
}
