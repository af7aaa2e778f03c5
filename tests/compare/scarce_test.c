/* SPDX-License-Identifier: Apache-2.0 */
/* Comparing with memory running out: each allocation of the layer fails in turn, from the
 * submission of an update to the end of the device. Nothing crashes or leaks, and nothing is said
 * of the driver that isn't true. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "../scarce/injector.h"
#include "bench.h"
#include "layer/compare/tracer.h"

/* The messages of one life. */
static void expect_truth(const struct messages *messages, unsigned failing)
{
    uint32_t of_rings = bench_count(DIFFERENCE_MISSED) + bench_count(DIFFERENCE_DOUBLE);
    uint32_t differences = 0;
    for (enum difference d = 0; d < DIFFERENCE_COUNT; d++)
        differences += bench_count(d);
    if (differences != of_rings || (messages->count > differences && failing == 0))
        fail_msg("allocation %u: %s", failing, messages->items[0].text);
}

/* A fan is built and updated. False once there are fewer allocations. */
static bool live(unsigned failing)
{
    struct subject subject;
    struct compare_structure structure = {0}, update = {0};
    subject_ring(&subject);
    subject.parameters.info.flags = VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_UPDATE_BIT_KHR;
    assert_null(bench_open(BENCH_PLAIN));
    const struct compare_device *device = &bench.compare;
    VkCommandBuffer commands = bench_begin();
    GET(compare_structure_create(device, &subject.input, NULL, &structure));
    GET(compare_structure_create(device, &subject.input, &structure, &update));
    compare_structure_build(device, commands, &subject.input, NULL, &structure);
    compare_structure_build(device, commands, &subject.input, &structure, &update);
    bench_submit(commands);
    injector_fail_at(failing);
    bench_finish(commands);
    compare_structure_free(device, &update);
    compare_structure_free(device, &structure);
    bench_close();
    expect_truth(&bench.instance.messages, failing);
    assert_int_equal(injector_live(), 0);
    return injector_failed() != 0;
}

TEST(test_each_allocation)
{
    unsigned failing = 1;
    live(0);
    assert_true(injector_watch(LAYER_LIBRARY));
    while (live(failing))
        failing++;
    print_message("%u allocations\n", failing - 1);
    assert_true(failing > 20);
}

const char *unit_test_open(const char *argument)
{
    setenv("VK_ASSAY_VALIDATION_LEVEL", "content", 1);
    setenv("VK_ASSAY_VALIDATION_COMPARE_RAYS", "64", 1);
    const char *lacks = bench_open(BENCH_PLAIN);
    bench_close();
    return lacks;
}
