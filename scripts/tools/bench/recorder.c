/* SPDX-License-Identifier: Apache-2.0 */
/* Recording and measuring. */
#include "recorder.h"

#include <pthread.h>

#include "scripts/tools/measure.h"

void recorder_open(struct recorder *recorder, const struct side *side)
{
    const VkCommandPoolCreateInfo pool_info =
        MAKE(VkCommandPoolCreateInfo, .flags = VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT,
             .queueFamilyIndex = side->gpu.queue_family);
    recorder->side = side;
    TOOL_CALL(side->gpu.calls, CreateCommandPool, side->gpu.device, &pool_info, NULL,
              &recorder->pool);
    TOOL_CALL(side->gpu.calls, AllocateCommandBuffers, side->gpu.device,
              &MAKE(VkCommandBufferAllocateInfo, .commandPool = recorder->pool,
                    .level = VK_COMMAND_BUFFER_LEVEL_PRIMARY, .commandBufferCount = 1),
              &recorder->commands);
    TOOL_CALL(side->gpu.calls, CreateFence, side->gpu.device, &MAKE(VkFenceCreateInfo), NULL,
              &recorder->fence);
}

void recorder_close(struct recorder *recorder)
{
    const struct gpu *gpu = &recorder->side->gpu;
    gpu->calls.DestroyFence(gpu->device, recorder->fence, NULL);
    gpu->calls.DestroyCommandPool(gpu->device, recorder->pool, NULL);
}

void recorder_begin(const struct recorder *recorder, VkCommandBufferUsageFlags flags)
{
    const VkCommandBufferBeginInfo info = MAKE(VkCommandBufferBeginInfo, .flags = flags);
    TOOL_CALL(recorder->side->gpu.calls, BeginCommandBuffer, recorder->commands, &info);
}

void recorder_end(const struct recorder *recorder)
{
    TOOL_CALL(recorder->side->gpu.calls, EndCommandBuffer, recorder->commands);
}

static void reset(const struct recorder *recorder)
{
    TOOL_CALL(recorder->side->gpu.calls, ResetCommandBuffer, recorder->commands, 0);
}

static void build(const struct recorder *recorder, const struct scene *scene, uint32_t first,
                  uint32_t count)
{
    recorder->side->gpu.calls.CmdBuildAccelerationStructuresKHR(
        recorder->commands, count, &scene->infos[first], &scene->range_pointers[first]);
}

/* One call of its own command buffer. */
static void record_call(const struct recorder *recorder, const struct scene *scene, uint32_t first,
                        uint32_t count)
{
    recorder_begin(recorder, VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT);
    build(recorder, scene, first, count);
    recorder_end(recorder);
    reset(recorder);
}

void recorder_run(const struct recorder *recorder, const struct scene *scene,
                  uint32_t builds_per_call, uint32_t times)
{
    for (uint32_t i = 0; i < times; i++) {
        for (uint32_t first = 0; first < scene->count; first += builds_per_call) {
            uint32_t left = scene->count - first;
            record_call(recorder, scene, first, left < builds_per_call ? left : builds_per_call);
        }
    }
}

double recorder_time(const struct recorder *recorder, const struct scene *scene,
                     uint32_t builds_per_call, uint32_t times)
{
    double before = thread_time();
    recorder_run(recorder, scene, builds_per_call, times);
    return thread_time() - before;
}

/* ---- submissions */

void recorder_submit_and_wait(const struct recorder *recorder)
{
    const struct gpu *gpu = &recorder->side->gpu;
    TOOL_CALL(gpu->calls, QueueSubmit, gpu->queue, 1,
              &MAKE(VkSubmitInfo, .commandBufferCount = 1, .pCommandBuffers = &recorder->commands),
              recorder->fence);
    TOOL_CALL(gpu->calls, WaitForFences, gpu->device, 1, &recorder->fence, VK_TRUE, UINT64_MAX);
    TOOL_CALL(gpu->calls, ResetFences, gpu->device, 1, &recorder->fence);
}

struct submit_times recorder_submit(const struct recorder *recorder, const struct scene *scene)
{
    recorder_begin(recorder, 0);
    build(recorder, scene, 0, scene->count);
    recorder_end(recorder);
    double before = thread_time();
    recorder_submit_and_wait(recorder);
    double between = thread_time();
    recorder_submit_and_wait(recorder);
    struct submit_times times = {.first = between - before, .again = thread_time() - between};
    reset(recorder);
    return times;
}

void recorder_clear_inputs(const struct recorder *recorder, const struct scene *scene)
{
    static const enum scene_part inputs[] = {PART_VERTICES, PART_INDICES};
    const struct side *side = recorder->side;
    recorder_begin(recorder, VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT);
    for (size_t i = 0; i < sizeof(inputs) / sizeof(inputs[0]); i++) {
        const struct scene_ranges *ranges = &scene->parts[inputs[i]];
        for (uint32_t b = 0; b < ranges->buffer_count; b++)
            side->gpu.calls.CmdFillBuffer(recorder->commands, ranges->buffers[b], 0, VK_WHOLE_SIZE,
                                          0);
    }
    recorder_end(recorder);
    recorder_submit_and_wait(recorder);
    reset(recorder);
}

/* ---- memory */

double recorder_memory(const struct scene *scene, uint32_t builds_per_call)
{
    struct recorder recorder;
    recorder_open(&recorder, scene->side);
    double before = bytes_allocated();
    recorder_begin(&recorder, VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT);
    for (uint32_t first = 0; first < scene->count; first += builds_per_call) {
        uint32_t left = scene->count - first;
        build(&recorder, scene, first, left < builds_per_call ? left : builds_per_call);
    }
    double after = bytes_allocated();
    recorder_end(&recorder);
    reset(&recorder);
    recorder_close(&recorder);
    return after > 0 ? after - before : -1;
}

/* ---- threads */

struct recording_thread {
    pthread_t thread;
    pthread_barrier_t *start;
    struct recorder recorder;
    const struct scene *scene;
    uint32_t first, builds, times;
    double began, ended, cpu;
};

static void record(const struct recording_thread *self, uint32_t times)
{
    for (uint32_t i = 0; i < times; i++)
        record_call(&self->recorder, self->scene, self->first, self->builds);
}

static void *run(void *argument)
{
    struct recording_thread *self = argument;
    record(self, 1); /* what is done once a thread */
    pthread_barrier_wait(self->start);
    double cpu = thread_time();
    self->began = read_clock(CLOCK_MONOTONIC);
    record(self, self->times);
    self->ended = read_clock(CLOCK_MONOTONIC);
    self->cpu = thread_time() - cpu;
    return NULL;
}

struct thread_times threads_time(const struct side *side, const struct scene *scene, uint32_t count,
                                 uint32_t builds, uint32_t times)
{
    struct recording_thread threads[MOST_THREADS];
    pthread_barrier_t start;
    pthread_barrier_init(&start, NULL, count);
    for (uint32_t i = 0; i < count; i++) {
        threads[i] = (struct recording_thread){
            .start = &start, .scene = scene, .first = i * builds, .builds = builds, .times = times};
        recorder_open(&threads[i].recorder, side);
        if (pthread_create(&threads[i].thread, NULL, run, &threads[i]) != 0)
            tool_fail("a thread can't be created");
    }
    double began = 0, ended = 0, cpu = 0;
    for (uint32_t i = 0; i < count; i++) {
        pthread_join(threads[i].thread, NULL);
        recorder_close(&threads[i].recorder);
        began = i && began < threads[i].began ? began : threads[i].began;
        ended = ended > threads[i].ended ? ended : threads[i].ended;
        cpu += threads[i].cpu;
    }
    pthread_barrier_destroy(&start);
    double recorded = (double)count * builds * times;
    return (struct thread_times){.wall = (ended - began) / recorded, .cpu = cpu / recorded};
}
