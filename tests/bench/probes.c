/* SPDX-License-Identifier: Apache-2.0 */
/* Stands before the C library's process_vm_readv. */
#define _GNU_SOURCE /* process_vm_readv */
#include "probes.h"

#include <sys/syscall.h>
#include <sys/uio.h>
#include <unistd.h>

static uint64_t count;

uint64_t probes_count(void)
{
    return count;
}

/* The program exports it, so the dynamic linker gives it to the layer, too. */
__attribute__((visibility("default"))) ssize_t
process_vm_readv(pid_t pid, const struct iovec *lvec, unsigned long liovcnt,
                 const struct iovec *rvec, unsigned long riovcnt, unsigned long flags)
{
    count++;
    return syscall(SYS_process_vm_readv, pid, lvec, liovcnt, rvec, riovcnt, flags);
}
