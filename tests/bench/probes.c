/* SPDX-License-Identifier: Apache-2.0 */
/* Replaces the C library's syscall and clock_gettime. The program exports both, so the dynamic
 * linker gives them to the layer, too. */
#define _GNU_SOURCE /* RTLD_NEXT */
#include "probes.h"

#include <dlfcn.h>
#include <stdarg.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

static uint64_t count;
static time_t coarse_seconds; /* 0: the clock is the system's */

uint64_t probes_count(void)
{
    return count;
}

void probes_advance_clock(void)
{
    coarse_seconds++;
}

__attribute__((visibility("default"))) int clock_gettime(clockid_t clock, struct timespec *now)
{
    static int (*next)(clockid_t, struct timespec *);
    if (coarse_seconds && clock == CLOCK_MONOTONIC_COARSE) {
        *now = (struct timespec){.tv_sec = coarse_seconds};
        return 0;
    }
    if (!next)
        next = (int (*)(clockid_t, struct timespec *))dlsym(RTLD_NEXT, "clock_gettime");
    return next(clock, now);
}

__attribute__((visibility("default"))) long syscall(long sysno, ...)
{
    static long (*next)(long, ...);
    if (!next)
        next = (long (*)(long, ...))dlsym(RTLD_NEXT, "syscall");
    count += sysno == SYS_rt_sigprocmask;

    long a[6];
    va_list arguments;
    va_start(arguments, sysno);
    for (int i = 0; i < 6; i++)
        a[i] = va_arg(arguments, long);
    va_end(arguments);
    return next(sysno, a[0], a[1], a[2], a[3], a[4], a[5]);
}
