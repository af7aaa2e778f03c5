/* SPDX-License-Identifier: Apache-2.0 */
/* A few threads that live as long as one build. */
#include "build/workers.h"

#include <signal.h>

static void *worker_main(void *argument)
{
    struct workers *workers = argument;
    uint64_t seen = 0;
    pthread_mutex_lock(&workers->lock);
    for (;;) {
        while (workers->round == seen && !workers->is_ending)
            pthread_cond_wait(&workers->begin, &workers->lock);
        if (workers->is_ending)
            break;
        seen = workers->round;
        void (*job)(void *) = workers->job;
        void *context = workers->context;
        pthread_mutex_unlock(&workers->lock);
        job(context);
        pthread_mutex_lock(&workers->lock);
        if (--workers->busy == 0)
            pthread_cond_signal(&workers->end);
    }
    pthread_mutex_unlock(&workers->lock);
    return NULL;
}

void workers_start(struct workers *workers, uint32_t wanted)
{
    workers->count = 1;
    if (wanted <= 1)
        return;
    workers->round = 0;
    workers->busy = 0;
    workers->is_ending = false;
    pthread_mutex_init(&workers->lock, NULL);
    pthread_cond_init(&workers->begin, NULL);
    pthread_cond_init(&workers->end, NULL);
    if (wanted > WORKERS_MAX)
        wanted = WORKERS_MAX;
    /* The application's signal handlers are not for these threads. */
    sigset_t all, before;
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &before);
    while (workers->count < wanted &&
           pthread_create(&workers->threads[workers->count - 1], NULL, worker_main, workers) == 0)
        workers->count++;
    pthread_sigmask(SIG_SETMASK, &before, NULL);
    if (workers->count == 1) {
        pthread_mutex_destroy(&workers->lock);
        pthread_cond_destroy(&workers->begin);
        pthread_cond_destroy(&workers->end);
    }
}

void workers_run(struct workers *workers, void (*job)(void *context), void *context)
{
    if (workers->count == 1) {
        job(context);
        return;
    }
    pthread_mutex_lock(&workers->lock);
    workers->job = job;
    workers->context = context;
    workers->busy = workers->count - 1;
    workers->round++;
    pthread_cond_broadcast(&workers->begin);
    pthread_mutex_unlock(&workers->lock);
    job(context);
    pthread_mutex_lock(&workers->lock);
    while (workers->busy > 0)
        pthread_cond_wait(&workers->end, &workers->lock);
    pthread_mutex_unlock(&workers->lock);
}

void workers_stop(struct workers *workers)
{
    if (workers->count == 1)
        return;
    pthread_mutex_lock(&workers->lock);
    workers->is_ending = true;
    pthread_cond_broadcast(&workers->begin);
    pthread_mutex_unlock(&workers->lock);
    for (uint32_t i = 0; i + 1 < workers->count; i++)
        pthread_join(workers->threads[i], NULL);
    pthread_mutex_destroy(&workers->lock);
    pthread_cond_destroy(&workers->begin);
    pthread_cond_destroy(&workers->end);
}
