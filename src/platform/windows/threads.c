/* SPDX-License-Identifier: Apache-2.0 */
/* Threads and locks. */
#include "src/platform/threads.h"

#include <windows.h>

/* ---- locks with readers: the read-write locks of winpthreads let a waiting writer block readers
 */

void shared_lock_init(struct shared_lock *lock)
{
    pthread_mutex_init(&lock->mutex, NULL);
    pthread_cond_init(&lock->released, NULL);
    lock->readers = 0;
    lock->is_writing = false;
}

void shared_lock_destroy(struct shared_lock *lock)
{
    pthread_mutex_destroy(&lock->mutex);
    pthread_cond_destroy(&lock->released);
}

void shared_lock_read(struct shared_lock *lock)
{
    pthread_mutex_lock(&lock->mutex);
    while (lock->is_writing)
        pthread_cond_wait(&lock->released, &lock->mutex);
    lock->readers++;
    pthread_mutex_unlock(&lock->mutex);
}

void shared_lock_write(struct shared_lock *lock)
{
    pthread_mutex_lock(&lock->mutex);
    while (lock->is_writing || lock->readers)
        pthread_cond_wait(&lock->released, &lock->mutex);
    lock->is_writing = true;
    pthread_mutex_unlock(&lock->mutex);
}

void shared_lock_release(struct shared_lock *lock)
{
    pthread_mutex_lock(&lock->mutex);
    if (lock->is_writing)
        lock->is_writing = false;
    else
        lock->readers--;
    pthread_cond_broadcast(&lock->released);
    pthread_mutex_unlock(&lock->mutex);
}

/* ---- the rest */

void timed_condition_init(pthread_cond_t *condition)
{
    pthread_cond_init(condition, NULL);
}

bool timed_condition_wait(pthread_cond_t *condition, pthread_mutex_t *mutex, uint32_t nanoseconds)
{
    const struct timespec time = {.tv_nsec = (long)nanoseconds};
    return pthread_cond_timedwait_relative_np(condition, mutex, &time) == 0;
}

void threads_block_signals(struct blocked_signals *blocked)
{
    blocked->unused = 0;
}

void threads_unblock_signals(const struct blocked_signals *blocked)
{
    (void)blocked;
}

bool thread_find_stack(uintptr_t *begin, uintptr_t *end)
{
    ULONG_PTR low, high;
    GetCurrentThreadStackLimits(&low, &high);
    *begin = low;
    *end = high;
    return true;
}
