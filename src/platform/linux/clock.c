/* SPDX-License-Identifier: Apache-2.0 */
/* Clocks and pauses. */
#include "src/platform/clock.h"

#include <sched.h>

enum { SECOND = 1000000000 };

static uint64_t nanoseconds_of(clockid_t clock)
{
    struct timespec now = {0};
    clock_gettime(clock, &now);
    return (uint64_t)now.tv_sec * SECOND + (uint64_t)now.tv_nsec;
}

uint64_t clock_monotonic(void)
{
    return nanoseconds_of(CLOCK_MONOTONIC);
}

uint64_t clock_process_cpu(void)
{
    return nanoseconds_of(CLOCK_PROCESS_CPUTIME_ID);
}

struct utc_time clock_utc(void)
{
    struct timespec now = {0};
    clock_gettime(CLOCK_REALTIME, &now);
    return (struct utc_time){(uint64_t)now.tv_sec, (uint32_t)now.tv_nsec};
}

void clock_sleep(uint64_t nanoseconds)
{
    const struct timespec pause = {.tv_sec = (time_t)(nanoseconds / SECOND),
                                   .tv_nsec = (long)(nanoseconds % SECOND)};
    nanosleep(&pause, NULL);
}

void clock_yield(void)
{
    sched_yield();
}
