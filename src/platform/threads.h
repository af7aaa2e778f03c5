/* SPDX-License-Identifier: Apache-2.0 */
/* Threads and locks: the POSIX functions for mutexes, conditions and threads, which MinGW-w64 has
 * on Windows (winpthreads), and what the two systems do differently. */
#ifndef ASSAY_PLATFORM_THREADS_H
#define ASSAY_PLATFORM_THREADS_H

#include <pthread.h>
#include <stdbool.h>
#include <stdint.h>

#ifndef _WIN32
#include <signal.h>
#endif

/* ---- locks with readers */

/* A lock that a thread may take for reading again while it holds it for reading: a waiting writer
 * does not block readers. */
struct shared_lock {
#ifdef _WIN32
    pthread_mutex_t mutex;
    pthread_cond_t released;
    uint32_t readers;
    bool is_writing;
#else
    pthread_rwlock_t lock; /* glibc's and musl's default is of that kind */
#endif
};

void shared_lock_init(struct shared_lock *lock);
void shared_lock_destroy(struct shared_lock *lock);
void shared_lock_read(struct shared_lock *lock);
void shared_lock_write(struct shared_lock *lock);
void shared_lock_release(struct shared_lock *lock); /* after either */

/* ---- conditions with a time limit */

void timed_condition_init(pthread_cond_t *condition);
/* Waits for a time of less than a second, in nanoseconds, on a condition that
 * timed_condition_init() has initialized. Returns false if it has passed. */
bool timed_condition_wait(pthread_cond_t *condition, pthread_mutex_t *mutex, uint32_t nanoseconds);

/* ---- signals */

/* Threads that are created between these two calls inherit that all signals are blocked, so that
 * the application's handlers never run on them. Windows has no such signals. */
struct blocked_signals {
#ifdef _WIN32
    int unused;
#else
    sigset_t before;
#endif
};
void threads_block_signals(struct blocked_signals *blocked);
void threads_unblock_signals(const struct blocked_signals *blocked);

/* ---- stacks */

/* Finds the bounds of the calling thread's stack. Returns false if they are not known. */
bool thread_find_stack(uintptr_t *begin, uintptr_t *end);

/* Whether functions store frame records: the caller's, and the return address behind it. */
#ifdef _WIN32
enum { THREADS_HAVE_FRAME_RECORDS = false };
#else
enum { THREADS_HAVE_FRAME_RECORDS = true };
#endif

#endif
