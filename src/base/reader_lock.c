/* SPDX-License-Identifier: Apache-2.0 */
/* The striped lock. */
#include "src/base/reader_lock.h"

#include <sched.h>
#include <time.h>

/* Who has the flag may have to wait for this processor: let others have it, at last those of lower
 * priority, too. */
enum { YIELDS = 32, NAP_NS = 20000 };

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

static bool try_to_take(atomic_bool *flag)
{
    return !atomic_exchange_explicit(flag, true, memory_order_acquire);
}

__attribute__((noinline, cold)) static void wait_for(atomic_bool *flag)
{
    unsigned tries = 0;
    do {
        if (tries++ < YIELDS)
            sched_yield();
        else
            nanosleep(&(struct timespec){.tv_nsec = NAP_NS}, NULL);
    } while (atomic_load_explicit(flag, memory_order_relaxed) || !try_to_take(flag));
}

static void take(atomic_bool *flag)
{
    if (!try_to_take(flag))
        wait_for(flag);
}

static void give_back(atomic_bool *flag)
{
    atomic_store_explicit(flag, false, memory_order_release);
}

unsigned reader_lock_enter(struct reader_lock *lock)
{
    unsigned stripe = reader_lock_stripe();
    take(&lock->stripes[stripe].is_taken);
    return stripe;
}

void reader_lock_leave(struct reader_lock *lock, unsigned stripe)
{
    give_back(&lock->stripes[stripe].is_taken);
}

/* Stripes are always taken in ascending order, so two writers cannot wait for each other. */
void reader_lock_write(struct reader_lock *lock)
{
    for (unsigned i = 0; i < READER_LOCK_STRIPES; i++)
        take(&lock->stripes[i].is_taken);
}

void reader_lock_write_done(struct reader_lock *lock)
{
    for (unsigned i = READER_LOCK_STRIPES; i-- > 0;)
        give_back(&lock->stripes[i].is_taken);
}
