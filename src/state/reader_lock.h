/* SPDX-License-Identifier: Apache-2.0 */
/* A read-write lock for state that is read on every recorded command and written when objects come
 * and go. It is striped: a reader takes one stripe, chosen by its thread, so readers on different
 * threads do not share a cache line; a writer takes all of them. A thread may not enter it twice.
 *
 * A stripe is a mutex: many readers of a read-write lock can keep a writer waiting for seconds, or
 * writers a reader, while readers of one stripe hold it for a look-up only. */
#ifndef ASSAY_STATE_READER_LOCK_H
#define ASSAY_STATE_READER_LOCK_H

#include <pthread.h>

enum { READER_LOCK_STRIPES = 8, READER_LOCK_STRIPE_SIZE = 128 };

/* Two cache lines a stripe keep the locks of two stripes apart without asking for alignment, which
 * calloc would not give. */
struct reader_lock {
    union {
        pthread_mutex_t lock;
        char size[READER_LOCK_STRIPE_SIZE];
    } stripes[READER_LOCK_STRIPES];
};

/* For locks of static storage; these need no destruction. */
#define READER_LOCK_INITIALIZER                                                                    \
    {                                                                                              \
        .stripes = { [0 ... READER_LOCK_STRIPES - 1] = {.lock = PTHREAD_MUTEX_INITIALIZER} }       \
    }

/* A number below READER_LOCK_STRIPES, of this thread: threads take them in turn. */
unsigned reader_lock_stripe(void);

void reader_lock_init(struct reader_lock *lock);
void reader_lock_destroy(struct reader_lock *lock);

/* Returns the stripe, to be handed to reader_lock_leave. */
unsigned reader_lock_enter(struct reader_lock *lock);
void reader_lock_leave(struct reader_lock *lock, unsigned stripe);

void reader_lock_write(struct reader_lock *lock);
void reader_lock_write_done(struct reader_lock *lock);

#endif
