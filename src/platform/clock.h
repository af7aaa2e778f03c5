/* SPDX-License-Identifier: Apache-2.0 */
/* Clocks and pauses. */
#ifndef ASSAY_PLATFORM_CLOCK_H
#define ASSAY_PLATFORM_CLOCK_H

#include <stdint.h>

#ifndef _WIN32
#include <time.h>
#endif

/* Returns a value that changes whenever the system timer ticks (every 1 to 16 ms). Reading it takes
 * no system call. */
#ifdef _WIN32
uint64_t clock_tick(void);
#else
static inline uint64_t clock_tick(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC_COARSE, &now);
    return (uint64_t)now.tv_sec << 30 | (uint64_t)now.tv_nsec; /* less than 2^30 */
}
#endif

/* Returns nanoseconds since some time before the process began. */
uint64_t clock_monotonic(void);

/* Returns the nanoseconds of processor time that all threads of the process have used. */
uint64_t clock_process_cpu(void);

/* The time since 1970-01-01, UTC. A signal handler may read it. */
struct utc_time {
    uint64_t seconds;
    uint32_t nanoseconds;
};
struct utc_time clock_utc(void);

/* Pauses the thread for at least this time. Windows rounds up to whole milliseconds. */
void clock_sleep(uint64_t nanoseconds);
/* Lets other threads run. */
void clock_yield(void);

#endif
