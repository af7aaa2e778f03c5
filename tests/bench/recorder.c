/* SPDX-License-Identifier: Apache-2.0 */
/* Recording and measuring. */
#include "recorder.h"

#include <malloc.h>
#include <time.h>

#include "fail.h"

void recorder_open(struct recorder *recorder, const struct side *side)
{
    const VkCommandPoolCreateInfo pool_info = {.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO,
                                               .flags =
                                                   VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT,
                                               .queueFamilyIndex = side->queue_family};
    recorder->side = side;
    bench_check(side->calls.CreateCommandPool(side->device, &pool_info, NULL, &recorder->pool),
                "vkCreateCommandPool");
    const VkCommandBufferAllocateInfo info = {.sType =
                                                  VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO,
                                              .commandPool = recorder->pool,
                                              .level = VK_COMMAND_BUFFER_LEVEL_PRIMARY,
                                              .commandBufferCount = 1};
    bench_check(side->calls.AllocateCommandBuffers(side->device, &info, &recorder->commands),
                "vkAllocateCommandBuffers");
}

void recorder_close(struct recorder *recorder)
{
    recorder->side->calls.DestroyCommandPool(recorder->side->device, recorder->pool, NULL);
}

static void begin(const struct recorder *recorder)
{
    static const VkCommandBufferBeginInfo info = {
        .sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO,
        .flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT};
    bench_check(recorder->side->calls.BeginCommandBuffer(recorder->commands, &info),
                "vkBeginCommandBuffer");
}

static void end(const struct recorder *recorder)
{
    bench_check(recorder->side->calls.EndCommandBuffer(recorder->commands), "vkEndCommandBuffer");
    bench_check(recorder->side->calls.ResetCommandBuffer(recorder->commands, 0),
                "vkResetCommandBuffer");
}

static void build(const struct recorder *recorder, const struct scene *scene, uint32_t first,
                  uint32_t count)
{
    recorder->side->calls.CmdBuildAccelerationStructuresKHR(
        recorder->commands, count, &scene->infos[first], &scene->range_pointers[first]);
}

void recorder_run(const struct recorder *recorder, const struct scene *scene, uint32_t times)
{
    for (uint32_t i = 0; i < times; i++) {
        begin(recorder);
        build(recorder, scene, 0, scene->count);
        end(recorder);
    }
}

static double thread_time(void)
{
    struct timespec now;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return (double)now.tv_sec * 1e9 + (double)now.tv_nsec;
}

double recorder_time(const struct recorder *recorder, const struct scene *scene, uint32_t times)
{
    double before = thread_time();
    recorder_run(recorder, scene, times);
    return thread_time() - before;
}

static double allocated(void)
{
    struct mallinfo2 info = mallinfo2();
    return (double)info.uordblks + (double)info.hblkhd;
}

double recorder_memory(const struct scene *scene, uint32_t builds_per_call)
{
    struct recorder recorder;
    recorder_open(&recorder, scene->side);
    double before = allocated();
    begin(&recorder);
    for (uint32_t first = 0; first < scene->count; first += builds_per_call) {
        uint32_t left = scene->count - first;
        build(&recorder, scene, first, left < builds_per_call ? left : builds_per_call);
    }
    double after = allocated();
    end(&recorder);
    recorder_close(&recorder);
    return after > 0 ? after - before : -1;
}
