/* SPDX-License-Identifier: Apache-2.0 */
/* The striped lock. */
#include "state/reader_lock.h"

#include <stdatomic.h>

void reader_lock_init(struct reader_lock *lock)
{
    for (unsigned i = 0; i < READER_LOCK_STRIPES; i++)
        pthread_mutex_init(&lock->stripes[i].lock, NULL);
}

void reader_lock_destroy(struct reader_lock *lock)
{
    for (unsigned i = 0; i < READER_LOCK_STRIPES; i++)
        pthread_mutex_destroy(&lock->stripes[i].lock);
}

/* A thread-local integer needs no destructor, so the library can be
 * unloaded while threads that used it live on. */
unsigned reader_lock_stripe(void)
{
    static atomic_uint next;
    static _Thread_local unsigned stripe = READER_LOCK_STRIPES;
    if (stripe == READER_LOCK_STRIPES)
        stripe = atomic_fetch_add_explicit(&next, 1, memory_order_relaxed) % READER_LOCK_STRIPES;
    return stripe;
}

unsigned reader_lock_enter(struct reader_lock *lock)
{
    unsigned stripe = reader_lock_stripe();
    pthread_mutex_lock(&lock->stripes[stripe].lock);
    return stripe;
}

void reader_lock_leave(struct reader_lock *lock, unsigned stripe)
{
    pthread_mutex_unlock(&lock->stripes[stripe].lock);
}

/* Stripes are always taken in ascending order, so two writers cannot wait for each other. */
void reader_lock_write(struct reader_lock *lock)
{
    for (unsigned i = 0; i < READER_LOCK_STRIPES; i++)
        pthread_mutex_lock(&lock->stripes[i].lock);
}

void reader_lock_write_done(struct reader_lock *lock)
{
    for (unsigned i = READER_LOCK_STRIPES; i-- > 0;)
        pthread_mutex_unlock(&lock->stripes[i].lock);
}
