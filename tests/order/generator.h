/* SPDX-License-Identifier: Apache-2.0 */
/* Random submissions that an application may make: what they wait for and signal, made both of the
 * order and of the model. */
#ifndef ORDER_GENERATOR_H
#define ORDER_GENERATOR_H

#include "model.h"
#include "tests/unit/random.h"

enum {
    SEMAPHORES = 8, /* handles from 1; kinds below */
    FENCES = 3,
    CALL_BATCHES = 3,
    IN_FLIGHT = 2,
};

enum semaphore_kind {
    BINARY,
    OWNED,   /* signalled by one queue */
    CHAINED, /* each signal waits for the one before, which may be submitted later */
    BY_HOST,
};

/* What the generator knows of a semaphore's use. */
struct usage {
    enum semaphore_kind kind;
    uint32_t index; /* in the model */
    uint64_t top;   /* the largest value signalled */
    uint64_t hole;  /* a smaller value that has not been signalled; 0: none */
    uint64_t below_hole;
    uint64_t waited;    /* binary: the number that was waited for last, */
    uint32_t waiter;    /* by this queue, */
    bool bindings_wait; /* for bindings */
};

struct fence_use {
    bool pending;
    uint32_t last_batch; /* in the model */
};

struct flying {
    struct submission *submission;
    struct model_batch batches[CALL_BATCHES];
    uint32_t batch_count, fence;
};

/* Work of the host under way. */
struct work {
    struct submission *submission;
    struct model_batch batch;
};

struct test {
    struct random random;
    struct program program;
    struct model model;
    struct usage usage[SEMAPHORES + 1];
    struct fence_use fences[FENCES + 1];
    struct flying flying[IN_FLIGHT];
    struct work works[IN_FLIGHT];
    uint32_t work_count, flying_count, semaphore_count, name_count;
};

/* 0 to count - 1. */
uint32_t below(struct test *test, uint32_t count);

/* Anew, of the kind that its handle has. */
void create_semaphore(struct test *test, uint32_t handle);

/* Where the signal of that value has happened in the model. */
node signal_node(const struct test *test, const struct usage *usage, uint64_t value);

/* A call submits to it and has not returned; it has batches that are held. */
bool queue_is_flying(const struct test *test, uint32_t queue);
bool queue_is_held(const struct test *test, uint32_t queue);

/* A call is made; it may stay under way. */
void submit_some(struct test *test);
/* One of the calls under way returns. */
void land_some(struct test *test);

#endif
