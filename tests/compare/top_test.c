/* SPDX-License-Identifier: Apache-2.0 */
/* Top-level builds on lavapipe, compared without the layer: instances of separate triangles and
 * boxes are right, and what is wrong of a BLAS is found through an instance, too. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bench.h"

enum { RAYS = 4096, BOTTOMS = 3, INSTANCES = 9 };

static struct tally tally;
static struct input_copy *bottoms[BOTTOMS]; /* separate triangles, boxes, a closed fan */

static VkAccelerationStructureInstanceKHR instance_of(float angle, float size, float x)
{
    float c = size * cosf(angle), s = size * sinf(angle);
    return (VkAccelerationStructureInstanceKHR){
        .transform.matrix = {{c, -s, 0, x}, {s, c, 0, 2}, {0, 0, size, -1}}, .mask = 0xff};
}

static void trace(const struct top_input *input, const struct top_rays *rays,
                  struct compare_answer *answers)
{
    struct compare_input inputs[BOTTOMS];
    VkAccelerationStructureInstanceKHR instances[INSTANCES];
    for (uint32_t i = 0; i < BOTTOMS; i++)
        inputs[i] = bottoms[i]->input;
    for (uint32_t i = 0; i < input->count; i++) {
        instances[i] = input->instances[i].given;
        instances[i].accelerationStructureReference =
            input->instances[i].bottom == TOP_NO_BOTTOM ? 0 : input->instances[i].bottom + 1;
    }
    const struct compare_instances top = {
        .count = input->count,
        .instances = instances,
        .array_of_pointers = input->array_of_pointers,
        .flags = input->flags,
    };
    const struct tracer_job job = {
        .queue = bench.queue,
        .input_count = BOTTOMS,
        .inputs = inputs,
        .top = &top,
        .ray_count = rays->count,
        .rays = rays->rays,
        .answers = answers,
    };
    GET(tracer_run(bench.tracer, &job));
}

static void compare(const struct top_instance *instances, uint32_t count, bool array_of_pointers)
{
    const struct top_input input = {.count = count,
                                    .bottom_count = BOTTOMS,
                                    .array_of_pointers = array_of_pointers,
                                    .instances = instances,
                                    .bottoms = (const struct input_copy *const *)bottoms};
    struct top_reference reference;
    struct top_rays rays;
    GET(top_reference_open(&input, &reference));
    GET(top_rays_create(&reference, RAYS, &rays));
    struct compare_answer *answers = calloc(rays.count + 1ull, sizeof(*answers));
    assert_non_null(answers);
    if (rays.count)
        trace(&input, &rays, answers);
    tally = (struct tally){.rays = rays.count};
    for (uint32_t i = 0; i < rays.count; i++) {
        struct judgement judgement;
        if (!top_judge_ray(&reference, &rays, i, &answers[i], &judgement))
            continue;
        tally.all++;
        tally.counts[judgement.difference][judgement.reason]++;
    }
    tally_print(&tally, "top");
    free(answers);
    top_rays_free(&rays);
    top_reference_close(&reference);
}

/* Inactive instances come last: see the next test. */
TEST(test_right)
{
    struct top_instance instances[INSTANCES] = {
        {instance_of(0, 1, 0), 0},     {instance_of(0.5f, 2, 30), 0},
        {instance_of(2, 0.25f, 5), 1}, {instance_of(1, 100, -2000), 0},
        {instance_of(4, 3, 9), 1},     {instance_of(5, 1e-3f, 3), 0},
        {instance_of(0.25f, 1, 2), 0}, {instance_of(1, 1, 1), TOP_NO_BOTTOM},
        {instance_of(3, 1, 8), 0},
    };
    instances[3].given.flags = VK_GEOMETRY_INSTANCE_TRIANGLE_FLIP_FACING_BIT_KHR;
    instances[5].given.transform.matrix[0][0] *= -1; /* mirrored */
    instances[5].given.transform.matrix[0][1] *= -1;
    instances[6].given.instanceShaderBindingTableRecordOffset = 77;
    instances[6].given.instanceCustomIndex = 99;
    instances[8].given.mask = 0;
    compare(instances, INSTANCES, false);
    assert_int_equal(tally.rays, RAYS);
    assert_int_equal(tally.all, 0);
    compare(instances, INSTANCES, true);
    assert_int_equal(tally.all, 0);
    compare(instances, 0, false);
    assert_int_equal(tally.rays, 0);
}

/* Mesa 26.1 loses as many of the last instances as are inactive or have mask 0, or crashes. */
TEST(test_inactive_instance_before_another)
{
    const struct top_instance instances[3] = {{instance_of(0, 1, 0), 0},
                                              {instance_of(1, 1, 1), TOP_NO_BOTTOM},
                                              {instance_of(0.25f, 1, 30), 0}};
    if (strstr(bench.driver, "Mesa 26."))
        skip();
    compare(instances, 3, false);
    assert_int_equal(tally.all, 0);
}

TEST(test_ring)
{
    const struct top_instance instances[2] = {{instance_of(0.5f, 2, 10), 2},
                                              {instance_of(1, 1, -10), 2}};
    compare(instances, 2, false);
    if (strstr(bench.driver, "Mesa 25.0.7"))
        assert_true(tally.counts[DIFFERENCE_DOUBLE][REASON_SHARED] > 0);
    assert_int_equal(tally.all, tally.counts[DIFFERENCE_MISSED][REASON_SHARED] +
                                    tally.counts[DIFFERENCE_DOUBLE][REASON_SHARED]);
}

const char *unit_test_open(const char *argument)
{
    struct subject subjects[BOTTOMS];
    VkAabbPositionsKHR boxes[BOXES];
    const char *lacks = bench_open_tests(argument, BENCH_QUERIES, BENCH_PIPELINES);
    if (lacks)
        return lacks;
    subject_soup(&subjects[0]);
    subject_grid(&subjects[1], boxes);
    subject_ring(&subjects[2]);
    for (int i = 0; i < BOTTOMS; i++) {
        bottoms[i] = input_copy_create(&subjects[i].input);
        assert_non_null(bottoms[i]);
    }
    return NULL;
}

void unit_test_close(void)
{
    for (int i = 0; i < BOTTOMS; i++)
        input_copy_free(bottoms[i]);
    bench_close();
}
