/* SPDX-License-Identifier: Apache-2.0 */
/* A read-write lock for state that is read on every recorded command and written when objects come
 * and go. It is striped: a reader takes one stripe, chosen by its thread, so readers on different
 * threads do not share a cache line; a writer takes all of them. A thread may not enter it twice.
 *
 * A stripe is a flag, which is taken by one atomic operation and given back by a plain store: what
 * a look-up fetches from memory needn't have arrived before the thread goes on, as it must where a
 * mutex is unlocked. Who finds it taken, seldom and by a short piece of work, tries again, and soon
 * sleeps in between. A look-up holds it for so short that neither writers nor readers wait long for
 * the other. */
#ifndef ASSAY_BASE_READER_LOCK_H
#define ASSAY_BASE_READER_LOCK_H

#include <stdatomic.h>
#include <stdbool.h>

enum { READER_LOCK_STRIPES = 8, READER_LOCK_STRIPE_SIZE = 128 };

/* Two cache lines a stripe keep the flags of two stripes apart without asking for alignment, which
 * calloc would not give. All zero: free; there is nothing to release. */
struct reader_lock {
    union {
        atomic_bool is_taken;
        char size[READER_LOCK_STRIPE_SIZE];
    } stripes[READER_LOCK_STRIPES];
};

/* A number below READER_LOCK_STRIPES, of this thread: threads take them in turn. */
unsigned reader_lock_stripe(void);

/* Returns the stripe, to be handed to reader_lock_leave. */
unsigned reader_lock_enter(struct reader_lock *lock);
void reader_lock_leave(struct reader_lock *lock, unsigned stripe);

void reader_lock_write(struct reader_lock *lock);
void reader_lock_write_done(struct reader_lock *lock);

#endif
