/* SPDX-License-Identifier: Apache-2.0 */
/* submit_bench [--builds N] [--rounds N] [--no-time-bars]
 *
 * What the layer costs where recorded builds are submitted, on the null driver: CPU time a build of
 * vkQueueSubmit beyond that at level state, and memory kept for a build that can't be updated, from
 * its recording until after its submission. Exit status 1 if a bar is not met. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "machine.h"
#include "tests/tools/measure.h"

enum { BUILDS = 10000, ROUNDS = 15, BUILDS_A_CALL = 100, TIME_BAR = 100, MEMORY_BAR = 256 };

struct bench {
    struct fixture fixture;
    struct machine machine;
    uint32_t build_count, rounds;
    VkAccelerationStructureKHR *structures;
    struct shape_arguments arguments;
    VkDeviceSize size; /* of a structure */
};

/* Medians, nanoseconds a build; and bytes a build. */
struct figures {
    double first, again, updates;
    double bytes;
};

/* ---- structures */

static void create_structures(struct bench *bench, const struct test_buffer *buffer)
{
    for (uint32_t i = 0; i < bench->build_count; i++) {
        const STRUCT(VkAccelerationStructureCreateInfoKHR, info, .buffer = buffer->handle,
                     .offset = i * bench->size, .size = bench->size,
                     .type = VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR);
        expect_success(bench->fixture.vk.CreateAccelerationStructureKHR(
                           bench->fixture.device, &info, NULL, &bench->structures[i]),
                       "vkCreateAccelerationStructureKHR");
    }
}

static void destroy_structures(struct bench *bench)
{
    for (uint32_t i = 0; i < bench->build_count; i++)
        bench->fixture.vk.DestroyAccelerationStructureKHR(bench->fixture.device,
                                                          bench->structures[i], NULL);
}

/* ---- recording and submitting */

static void record_call(struct bench *bench, uint32_t cb, uint32_t first, uint32_t count,
                        bool update)
{
    VkAccelerationStructureBuildGeometryInfoKHR infos[BUILDS_A_CALL];
    const VkAccelerationStructureBuildRangeInfoKHR *ranges[BUILDS_A_CALL];
    for (uint32_t i = 0; i < count; i++) {
        infos[i] = bench->arguments.info;
        infos[i].dstAccelerationStructure = bench->structures[first + i];
        infos[i].scratchData.deviceAddress = bench->machine.scratch.address + i * bench->size;
        if (update) {
            infos[i].mode = VK_BUILD_ACCELERATION_STRUCTURE_MODE_UPDATE_KHR;
            infos[i].srcAccelerationStructure = infos[i].dstAccelerationStructure;
        }
        ranges[i] = bench->arguments.ranges;
    }
    bench->fixture.vk.CmdBuildAccelerationStructuresKHR(bench->machine.command_buffers[cb], count,
                                                        infos, ranges);
}

static void record(struct bench *bench, uint32_t cb, const struct shape *shape, bool update)
{
    shape_fill(&bench->arguments, bench->machine.scene, shape, false);
    machine_step(&bench->machine, &(struct step)BEGIN((unsigned char)cb));
    for (uint32_t i = 0; i < bench->build_count; i += BUILDS_A_CALL) {
        const uint32_t left = bench->build_count - i;
        record_call(bench, cb, i, left < BUILDS_A_CALL ? left : BUILDS_A_CALL, update);
    }
    machine_step(&bench->machine, &(struct step)END((unsigned char)cb));
}

/* Nanoseconds a build. */
static double submit(struct bench *bench, uint32_t cb)
{
    const STRUCT(VkSubmitInfo, info, .commandBufferCount = 1,
                 .pCommandBuffers = &bench->machine.command_buffers[cb]);
    const double start = thread_time();
    expect_success(
        bench->fixture.vk.QueueSubmit(bench->machine.queues[0], 1, &info, VK_NULL_HANDLE),
        "vkQueueSubmit");
    const double spent = thread_time() - start;
    machine_step(&bench->machine, &(struct step)IDLE);
    return spent / bench->build_count;
}

/* ---- measuring */

static void find_size(struct bench *bench, const struct shape *shape)
{
    const VkAccelerationStructureBuildSizesInfoKHR sizes = shape_sizes(bench->machine.scene, shape);
    bench->size = sizes.accelerationStructureSize;
    if (bench->size < sizes.buildScratchSize)
        bench->size = sizes.buildScratchSize;
    bench->size = (bench->size + 255) / 256 * 256;
}

static void measure_rounds(struct bench *bench, const struct test_buffer *buffer,
                           struct figures *figures)
{
    double *const first = calloc(3 * (size_t)bench->rounds, sizeof(*first));
    double *const again = first + bench->rounds, *const updates = again + bench->rounds;
    struct shape updatable = shape_plain(), plain = shape_plain();
    plain.flags = 0;
    for (uint32_t i = 0; i < bench->rounds; i++) {
        create_structures(bench, buffer);
        const double before = bytes_allocated();
        record(bench, A, &plain, false);
        first[i] = submit(bench, A);
        if (i == 0) /* later recordings reuse what this one leaves */
            figures->bytes = (bytes_allocated() - before) / bench->build_count;
        again[i] = submit(bench, A);
        machine_step(&bench->machine, &(struct step)RESET_POOL(A));

        record(bench, A, &updatable, false);
        record(bench, B, &updatable, true);
        submit(bench, A);
        updates[i] = submit(bench, B);
        destroy_structures(bench);
        /* Their ends are taken note of by the next submission, whatever it is. */
        machine_step(&bench->machine, &(struct step)BATCH);
        machine_step(&bench->machine, &(struct step)SUBMIT(0));
        machine_step(&bench->machine, &(struct step)RESET_POOL(A));
        machine_step(&bench->machine, &(struct step)RESET_POOL(B));
    }
    figures->first = quantile(first, bench->rounds, 0.5);
    figures->again = quantile(again, bench->rounds, 0.5);
    figures->updates = quantile(updates, bench->rounds, 0.5);
    free(first);
}

static void measure(struct bench *bench, const struct platform *platform, const char *level,
                    struct figures *figures)
{
    const struct setup setup = {.level = level};
    const struct shape shape = shape_plain();
    if (fixture_open(&bench->fixture, platform, &setup) != NULL)
        exit(1);
    machine_open(&bench->machine, &bench->fixture, VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR);
    find_size(bench, &shape);
    struct scene *scene = bench->machine.scene;
    const struct test_buffer buffer =
        scene_buffer(scene, bench->build_count * bench->size, ACCEL_USAGE);
    bench->machine.scratch = scene_buffer(scene, BUILDS_A_CALL * bench->size, SCRATCH_USAGE);
    bench->structures = calloc(bench->build_count, sizeof(*bench->structures));
    measure_rounds(bench, &buffer, figures);
    if (bench->fixture.messages.count != 0) {
        printf("unexpected: %.600s\n", bench->fixture.messages.items[0].text);
        exit(1);
    }
    free(bench->structures);
    machine_close(&bench->machine);
    fixture_close(&bench->fixture);
}

static bool meets(const char *what, double value, double bar, const char *unit)
{
    printf("%-50s %7.1f %s (at most %.0f)%s\n", what, value, unit, bar,
           value <= bar ? "" : "  TOO MUCH");
    return value <= bar;
}

static bool has_option(int argc, char **argv, const char *name)
{
    for (int i = 1; i < argc; i++)
        if (strcmp(argv[i], name) == 0)
            return true;
    return false;
}

static uint32_t read_number(int argc, char **argv, const char *name, uint32_t otherwise)
{
    for (int i = 1; i + 1 < argc; i++)
        if (strcmp(argv[i], name) == 0)
            return (uint32_t)strtoul(argv[i + 1], NULL, 0);
    return otherwise;
}

int main(int argc, char **argv)
{
    static struct platform platform;
    static struct bench bench;
    struct figures at_state, at_execution;
    bench.build_count = read_number(argc, argv, "--builds", BUILDS);
    bench.rounds = read_number(argc, argv, "--rounds", ROUNDS);
    const char *missing = platform_open(&platform, "null");
    if (missing != NULL || bench.build_count == 0 || bench.rounds == 0) {
        fprintf(stderr, "%s\n", missing != NULL ? missing : "nothing to measure");
        return 2;
    }
    measure(&bench, &platform, "state", &at_state);
    measure(&bench, &platform, "execution", &at_execution);

    printf("%u builds in one command buffer, %u rounds, medians\n", bench.build_count,
           bench.rounds);
    bool fast = meets("first submission of builds", at_execution.first - at_state.first, TIME_BAR,
                      "ns a build");
    fast =
        meets("their resubmission", at_execution.again - at_state.again, TIME_BAR, "ns a build") &&
        fast;
    fast = meets("submission of updates", at_execution.updates - at_state.updates, TIME_BAR,
                 "ns a build") &&
           fast;
    const bool small = meets("memory kept for a build that can't be updated",
                             at_execution.bytes - at_state.bytes, MEMORY_BAR, "bytes a build");
    return small && (fast || has_option(argc, argv, "--no-time-bars")) ? 0 : 1;
}
