/* SPDX-License-Identifier: Apache-2.0 */
/* Replaces the C library's syscall, process_vm_readv and clock_gettime. Under
 * Valgrind the layer probes by a futex. The program exports them, so the dynamic linker gives them
 * to the layer too.
 */
#define _GNU_SOURCE /* RTLD_NEXT, process_vm_readv */
#include "probes.h"

#include <dlfcn.h>
#include <stdarg.h>
#include <sys/syscall.h>
#include <sys/uio.h>
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
    count += sysno == SYS_rt_sigprocmask || sysno == SYS_futex;

    long a[6];
    va_list arguments;
    va_start(arguments, sysno);
    for (int i = 0; i < 6; i++)
        a[i] = va_arg(arguments, long);
    va_end(arguments);
    return next(sysno, a[0], a[1], a[2], a[3], a[4], a[5]);
}

__attribute__((visibility("default"))) ssize_t
process_vm_readv(pid_t pid, const struct iovec *local, unsigned long local_count,
                 const struct iovec *remote, unsigned long remote_count, unsigned long flags)
{
    static ssize_t (*next)(pid_t, const struct iovec *, unsigned long, const struct iovec *,
                           unsigned long, unsigned long);
    if (!next)
        next = (ssize_t(*)(pid_t, const struct iovec *, unsigned long, const struct iovec *,
                           unsigned long, unsigned long))dlsym(RTLD_NEXT, "process_vm_readv");
    count++;
    return next(pid, local, local_count, remote, remote_count, flags);
}
