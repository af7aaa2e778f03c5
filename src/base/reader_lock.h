/* SPDX-License-Identifier: Apache-2.0 */
/* A read-write lock for state that every recorded command reads and that only creating and
 * destroying objects writes. The lock is striped: a reader takes the one stripe of its thread, so
 * that readers on different threads do not share a cache line; a writer takes all stripes. The lock
 * is not recursive.
 *
 * A stripe is a flag. Acquiring it is one atomic operation and releasing it is a plain store, so
 * that outstanding loads of a look-up do not delay the thread, as they would when a mutex is
 * unlocked. Contended acquires call clock_yield(), then sleep. Critical sections are short, so
 * neither readers nor writers wait long. */
#ifndef ASSAY_BASE_READER_LOCK_H
#define ASSAY_BASE_READER_LOCK_H

#include <stdatomic.h>
#include <stdbool.h>

#include "src/platform/clock.h"

enum { READER_LOCK_STRIPES = 8, READER_LOCK_STRIPE_SIZE = 128 };

/* Each stripe spans two cache lines, which separates the flags of two stripes without an alignment
 * that calloc would not provide. All-zero is the released state; the lock needs no destruction. */
struct reader_lock {
    union {
        atomic_bool is_taken;
        char size[READER_LOCK_STRIPE_SIZE];
    } stripes[READER_LOCK_STRIPES];
};

/* Returns the stripe of the calling thread, below READER_LOCK_STRIPES. Stripes are assigned to
 * threads in rotation. */
unsigned reader_lock_stripe(void);

/* Acquires the lock for reading. Returns the stripe, which the caller passes to
 * reader_lock_leave(). */
unsigned reader_lock_enter(struct reader_lock *lock);
/* Acquires the lock for reading without waiting: returns false if the lock is taken. A signal
 * handler may call it. */
bool reader_lock_try_enter(struct reader_lock *lock, unsigned *stripe);
void reader_lock_leave(struct reader_lock *lock, unsigned stripe);

/* Acquires and releases the lock for writing. */
void reader_lock_write(struct reader_lock *lock);
void reader_lock_write_done(struct reader_lock *lock);

#endif
