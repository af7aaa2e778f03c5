/* SPDX-License-Identifier: Apache-2.0 */
/* Recording on several threads. */
#include "threads.h"

#include <pthread.h>

#include "tests/tools/fail.h"
#include "tests/tools/measure.h"

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
    recorder_run_some(&self->recorder, self->scene, self->first, self->builds, times);
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
