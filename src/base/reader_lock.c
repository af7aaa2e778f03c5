/* SPDX-License-Identifier: Apache-2.0 */
/* A striped lock. */
#include "src/base/reader_lock.h"

#include "src/platform/clock.h"

/* The thread that holds the flag may be waiting for this processor. clock_yield() runs threads of
 * the same priority; sleeping also runs threads of lower priority. */
enum { YIELDS = 32, SLEEP_NS = 20000 };

/* A thread-local integer needs no destructor, so the library can be unloaded while threads that
 * used it are alive. */
unsigned reader_lock_stripe(void)
{
    static atomic_uint next;
    static _Thread_local unsigned stripe = READER_LOCK_STRIPES;
    if (stripe == READER_LOCK_STRIPES)
        stripe = atomic_fetch_add_explicit(&next, 1, memory_order_relaxed) % READER_LOCK_STRIPES;
    return stripe;
}

static bool try_acquire_flag(atomic_bool *flag)
{
    return !atomic_exchange_explicit(flag, true, memory_order_acquire);
}

__attribute__((noinline, cold)) static void wait_for_flag(atomic_bool *flag)
{
    unsigned tries = 0;
    do {
        if (tries++ < YIELDS)
            clock_yield();
        else
            clock_sleep(SLEEP_NS);
    } while (atomic_load_explicit(flag, memory_order_relaxed) || !try_acquire_flag(flag));
}

static void acquire_flag(atomic_bool *flag)
{
    if (!try_acquire_flag(flag))
        wait_for_flag(flag);
}

static void release_flag(atomic_bool *flag)
{
    atomic_store_explicit(flag, false, memory_order_release);
}

unsigned reader_lock_enter(struct reader_lock *lock)
{
    unsigned stripe = reader_lock_stripe();
    acquire_flag(&lock->stripes[stripe].is_taken);
    return stripe;
}

bool reader_lock_try_enter(struct reader_lock *lock, unsigned *stripe)
{
    *stripe = 0;
    return try_acquire_flag(&lock->stripes[0].is_taken);
}

void reader_lock_leave(struct reader_lock *lock, unsigned stripe)
{
    release_flag(&lock->stripes[stripe].is_taken);
}

/* Writers take the stripes in ascending order, so two writers cannot deadlock. */
void reader_lock_write(struct reader_lock *lock)
{
    for (unsigned i = 0; i < READER_LOCK_STRIPES; i++)
        acquire_flag(&lock->stripes[i].is_taken);
}

void reader_lock_write_done(struct reader_lock *lock)
{
    for (unsigned i = READER_LOCK_STRIPES; i-- > 0;)
        release_flag(&lock->stripes[i].is_taken);
}
