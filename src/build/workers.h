/* SPDX-License-Identifier: Apache-2.0 */
/* A few threads that live as long as one build; none where one is enough. */
#ifndef ASSAY_BUILD_WORKERS_H
#define ASSAY_BUILD_WORKERS_H

#include <pthread.h>
#include <stdbool.h>
#include <stdint.h>

#define WORKERS_MAX 64u

/* The caller is one of them. Fields other than `count` belong to workers.c. */
struct workers {
    uint32_t count;
    pthread_t threads[WORKERS_MAX - 1];
    pthread_mutex_t lock;
    pthread_cond_t begin, end;
    void (*job)(void *context);
    void *context;
    uint64_t round; /* counts jobs, so that each thread takes each once */
    uint32_t busy;
    bool is_ending;
};

/* Fewer than `wanted` where the system gives no more. */
void workers_start(struct workers *workers, uint32_t wanted);
/* Runs `job` on all at once and returns when all have returned. */
void workers_run(struct workers *workers, void (*job)(void *context), void *context);
void workers_stop(struct workers *workers);

#endif
