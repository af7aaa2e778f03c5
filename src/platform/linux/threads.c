/* SPDX-License-Identifier: Apache-2.0 */
/* Threads and locks. */
#define _GNU_SOURCE /* pthread_getattr_np */
#include "src/platform/threads.h"

#include <stddef.h>
#include <time.h>

enum { SECOND = 1000000000 };

void shared_lock_init(struct shared_lock *lock)
{
    pthread_rwlock_init(&lock->lock, NULL);
}

void shared_lock_destroy(struct shared_lock *lock)
{
    pthread_rwlock_destroy(&lock->lock);
}

void shared_lock_read(struct shared_lock *lock)
{
    pthread_rwlock_rdlock(&lock->lock);
}

void shared_lock_write(struct shared_lock *lock)
{
    pthread_rwlock_wrlock(&lock->lock);
}

void shared_lock_release(struct shared_lock *lock)
{
    pthread_rwlock_unlock(&lock->lock);
}

void timed_condition_init(pthread_cond_t *condition)
{
    pthread_condattr_t clock;
    pthread_condattr_init(&clock);
    pthread_condattr_setclock(&clock, CLOCK_MONOTONIC);
    pthread_cond_init(condition, &clock);
    pthread_condattr_destroy(&clock);
}

bool timed_condition_wait(pthread_cond_t *condition, pthread_mutex_t *mutex, uint32_t nanoseconds)
{
    struct timespec end;
    clock_gettime(CLOCK_MONOTONIC, &end);
    end.tv_nsec += nanoseconds;
    end.tv_sec += end.tv_nsec / SECOND;
    end.tv_nsec %= SECOND;
    return pthread_cond_timedwait(condition, mutex, &end) == 0;
}

void threads_block_signals(struct blocked_signals *blocked)
{
    sigset_t all;
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &blocked->before);
}

void threads_unblock_signals(const struct blocked_signals *blocked)
{
    pthread_sigmask(SIG_SETMASK, &blocked->before, NULL);
}

bool thread_find_stack(uintptr_t *begin, uintptr_t *end)
{
    pthread_attr_t attributes;
    void *lowest;
    size_t size;
    if (pthread_getattr_np(pthread_self(), &attributes) != 0)
        return false;
    bool is_found = pthread_attr_getstack(&attributes, &lowest, &size) == 0;
    if (is_found) {
        *begin = (uintptr_t)lowest;
        *end = *begin + size;
    }
    pthread_attr_destroy(&attributes);
    return is_found;
}
