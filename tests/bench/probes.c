/* SPDX-License-Identifier: Apache-2.0 */
/* Stands before the C library's syscall. */
#define _GNU_SOURCE /* RTLD_NEXT */
#include "probes.h"

#include <dlfcn.h>
#include <stdarg.h>
#include <sys/syscall.h>
#include <unistd.h>

static uint64_t count;

uint64_t probes_count(void)
{
    return count;
}

/* The program exports it, so the dynamic linker gives it to the layer, too. */
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
