/* SPDX-License-Identifier: Apache-2.0 */
/* submit_bench [--builds N] [--rounds N] [--no-time-bars]
 *
 * What the layer costs where recorded builds are submitted, on the null driver: CPU time a build of
 * vkQueueSubmit beyond that at level state, and memory kept for a build that can't be updated, from
 * its recording until after its submission. Exit status 1 if a bar is not met. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "scripts/tools/measure.h"
#include "tests/fixture/geometry.h"
#include "tests/player/play.h"

enum { BUILDS = 10000, ROUNDS = 15, BUILDS_A_CALL = 100, TIME_BAR = 100, MEMORY_BAR = 256 };

struct bench {
    struct play play;
    struct program program; /* of one line at a time */
    uint32_t build_count, rounds;
    VkAccelerationStructureKHR *structures;
    VkDeviceAddress vertices, scratch;
    VkDeviceSize size; /* of a structure */
};

#define RUN(bench, ...) play_text(&(bench)->play, &(bench)->program, __VA_ARGS__)

/* Medians, nanoseconds a build; and bytes a build. */
struct figures {
    double first, again, updates;
    double bytes;
};

/* ---- structures */

static void create_structures(struct bench *bench, VkBuffer buffer)
{
    for (uint32_t i = 0; i < bench->build_count; i++) {
        const STRUCT(VkAccelerationStructureCreateInfoKHR, info, .buffer = buffer,
                     .offset = i * bench->size, .size = bench->size,
                     .type = VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR);
        GET(bench->play.vk.CreateAccelerationStructureKHR(bench->play.device, &info, NULL,
                                                          &bench->structures[i]));
    }
}

static void destroy_structures(struct bench *bench)
{
    for (uint32_t i = 0; i < bench->build_count; i++)
        bench->play.vk.DestroyAccelerationStructureKHR(bench->play.device, bench->structures[i],
                                                       NULL);
}

/* ---- recording and submitting */

enum shape { PLAIN, UPDATABLE, UPDATE };

static void record_call(struct bench *bench, VkCommandBuffer commands, uint32_t first,
                        uint32_t count, enum shape shape)
{
    const VkAccelerationStructureGeometryKHR geometry =
        triangles_geometry(bench->vertices, 5, VK_INDEX_TYPE_NONE_KHR, 0);
    const VkAccelerationStructureBuildRangeInfoKHR range = {.primitiveCount = 2};
    VkAccelerationStructureBuildGeometryInfoKHR infos[BUILDS_A_CALL];
    const VkAccelerationStructureBuildRangeInfoKHR *ranges[BUILDS_A_CALL];
    for (uint32_t i = 0; i < count; i++) {
        const VkAccelerationStructureKHR dst = bench->structures[first + i];
        infos[i] =
            MAKE(VkAccelerationStructureBuildGeometryInfoKHR,
                 .type = VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR,
                 .flags = shape == PLAIN ? 0 : VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_UPDATE_BIT_KHR,
                 .mode = shape == UPDATE ? VK_BUILD_ACCELERATION_STRUCTURE_MODE_UPDATE_KHR
                                         : VK_BUILD_ACCELERATION_STRUCTURE_MODE_BUILD_KHR,
                 .srcAccelerationStructure = shape == UPDATE ? dst : VK_NULL_HANDLE,
                 .dstAccelerationStructure = dst, .geometryCount = 1, .pGeometries = &geometry,
                 .scratchData.deviceAddress = bench->scratch + i * bench->size);
        ranges[i] = &range;
    }
    bench->play.vk.CmdBuildAccelerationStructuresKHR(commands, count, infos, ranges);
}

static VkCommandBuffer commands_of(struct bench *bench, const char *name)
{
    return play_object(&bench->play, name)->commands;
}

static void record(struct bench *bench, const char *name, enum shape shape)
{
    RUN(bench, "begin %s", name);
    for (uint32_t i = 0; i < bench->build_count; i += BUILDS_A_CALL) {
        const uint32_t left = bench->build_count - i;
        record_call(bench, commands_of(bench, name), i, left < BUILDS_A_CALL ? left : BUILDS_A_CALL,
                    shape);
    }
    RUN(bench, "end");
}

/* Nanoseconds a build. */
static double submit(struct bench *bench, const char *name)
{
    const VkCommandBuffer commands = commands_of(bench, name);
    const STRUCT(VkSubmitInfo, info, .commandBufferCount = 1, .pCommandBuffers = &commands);
    const double start = thread_time();
    GET(bench->play.vk.QueueSubmit(bench->play.queues[0], 1, &info, VK_NULL_HANDLE));
    const double spent = thread_time() - start;
    RUN(bench, "host wait idle");
    return spent / bench->build_count;
}

/* ---- measuring */

static void find_size(struct bench *bench)
{
    const VkAccelerationStructureBuildSizesInfoKHR sizes = play_build_sizes(
        &bench->play, (char *[]){"B0", NULL}, VK_ACCELERATION_STRUCTURE_BUILD_TYPE_DEVICE_KHR);
    bench->size = sizes.accelerationStructureSize;
    if (bench->size < sizes.buildScratchSize)
        bench->size = sizes.buildScratchSize;
    bench->size = (bench->size + 255) / 256 * 256;
}

static void measure_rounds(struct bench *bench, VkBuffer buffer, struct figures *figures)
{
    double *const first = calloc(3 * (size_t)bench->rounds, sizeof(*first));
    double *const again = first + bench->rounds, *const updates = again + bench->rounds;
    for (uint32_t i = 0; i < bench->rounds; i++) {
        create_structures(bench, buffer);
        const double before = bytes_allocated();
        record(bench, "c0", PLAIN);
        first[i] = submit(bench, "c0");
        if (i == 0) /* later recordings reuse what this one leaves */
            figures->bytes = (bytes_allocated() - before) / bench->build_count;
        again[i] = submit(bench, "c0");
        RUN(bench, "reset pool c0");

        record(bench, "c0", UPDATABLE);
        record(bench, "c1", UPDATE);
        submit(bench, "c0");
        updates[i] = submit(bench, "c1");
        destroy_structures(bench);
        /* Their ends are taken note of by the next submission, whatever it is. */
        RUN(bench, "submit1; reset pool c0; reset pool c1");
    }
    figures->first = quantile(first, bench->rounds, 0.5);
    figures->again = quantile(again, bench->rounds, 0.5);
    figures->updates = quantile(updates, bench->rounds, 0.5);
    free(first);
}

static void measure(struct bench *bench, const struct platform *platform, const char *level,
                    struct figures *figures)
{
    struct play *play = &bench->play;
    *play = (struct play){.platform = platform, .level = level};
    if (!play_begin(play, &bench->program))
        exit(1);
    find_size(bench);
    const VkBufferCreateInfo structures = play_buffer_info(play, bench->build_count * bench->size);
    const VkBufferCreateInfo scratches = play_buffer_info(play, BUILDS_A_CALL * bench->size);
    struct device_buffer buffer =
        buffer_create(&play->vk, play->device, play->memory_type, &structures);
    struct device_buffer scratch =
        buffer_create(&play->vk, play->device, play->memory_type, &scratches);
    bench->vertices = play_address(play, "V0");
    bench->scratch = scratch.address;
    bench->structures = calloc(bench->build_count, sizeof(*bench->structures));
    measure_rounds(bench, buffer.handle, figures);
    messages_expect_none(&play->fixture.messages);
    free(bench->structures);
    buffer_destroy(&play->vk, play->device, &buffer);
    buffer_destroy(&play->vk, play->device, &scratch);
    play_end(play);
    play_close(play);
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
