/* SPDX-License-Identifier: Apache-2.0 */
/* Probes memory through system calls. */
#define _GNU_SOURCE /* process_vm_readv, syscall */
#include "src/platform/probe.h"

#include <errno.h>
#include <linux/futex.h>
#include <stdatomic.h>
#include <string.h>
#include <sys/syscall.h>
#include <sys/uio.h>
#include <time.h>
#include <unistd.h>

enum { INVALID_HOW = -1, SIGNALS_SIZE = 8 };
enum { VALGRIND_IS_RUNNING = 0x1001, VALGRIND_DISABLE_ERRORS = 0x1801 };

static const uintptr_t page_size = (uintptr_t)1 << PROBE_PAGE_SHIFT;

/* ---- under Valgrind */

/* Executes a client request of Valgrind, and returns its answer. A processor executes it without
 * effect. (valgrind.h has the same for more processors; the layer builds without that header.) */
static uintptr_t request_of_valgrind(uintptr_t number, intptr_t argument)
{
    volatile uintptr_t request[6] = {number, (uintptr_t)argument}, answer = 0;
#if defined(__x86_64__)
    __asm__ volatile(
        "rolq $3, %%rdi\n\trolq $13, %%rdi\n\t"
        "rolq $61, %%rdi\n\trolq $51, %%rdi\n\t"
        "xchgq %%rbx, %%rbx"
        : "=d"(answer)
        : "a"(&request[0]), "0"(answer)
        : "cc", "memory");
#elif defined(__aarch64__)
    register volatile uintptr_t *to __asm__("x4") = &request[0];
    register uintptr_t from __asm__("x3") = 0;
    __asm__ volatile(
        "ror x12, x12, #3\n\tror x12, x12, #13\n\t"
        "ror x12, x12, #51\n\tror x12, x12, #61\n\t"
        "orr x10, x10, x10"
        : "+r"(from)
        : "r"(to)
        : "cc", "memory");
    answer = from;
#endif
    return request[0] == number ? answer : 0;
}

static bool runs_on_valgrind(void)
{
    enum { UNTESTED, NO_VALGRIND, VALGRIND };
    static atomic_int known; /* starts as UNTESTED */
    int answer = atomic_load_explicit(&known, memory_order_relaxed);
    if (answer == UNTESTED) {
        answer = request_of_valgrind(VALGRIND_IS_RUNNING, 0) ? VALGRIND : NO_VALGRIND;
        atomic_store_explicit(&known, answer, memory_order_relaxed);
    }
    return answer == VALGRIND;
}

/* Between these two calls Valgrind reports nothing about this thread: it would report each address
 * that is not accessible before the kernel does. */
static void begin_probe(void)
{
    if (runs_on_valgrind())
        request_of_valgrind(VALGRIND_DISABLE_ERRORS, 1);
}

static void end_probe(void)
{
    if (runs_on_valgrind())
        request_of_valgrind(VALGRIND_DISABLE_ERRORS, -1);
}

/* Valgrind executes rt_sigprocmask itself, and warns about the invalid `how`. The kernel reads the
 * word of a futex, compares it, and in no case waits for longer than the timeout, which is 0. */
static bool is_readable_on_valgrind(uintptr_t end)
{
    static const struct timespec timeout;
    begin_probe();
    bool is_readable =
        syscall(SYS_futex, end - sizeof(uint32_t), FUTEX_WAIT_PRIVATE, 0, &timeout, NULL, 0) == 0 ||
        errno != EFAULT;
    end_probe();
    return is_readable;
}

/* ---- probes */

/* The kernel first copies a signal set from the last bytes of the page, and only then rejects
 * `how`. No other call that reads memory is as cheap: process_vm_readv costs five times as much.
 * The call also reads device memory. */
static bool is_readable_by_sigprocmask(uintptr_t end)
{
    return syscall(SYS_rt_sigprocmask, INVALID_HOW, end - SIGNALS_SIZE, NULL, SIGNALS_SIZE) == 0 ||
           errno != EFAULT;
}

bool probe_page(uintptr_t end)
{
    return runs_on_valgrind() ? is_readable_on_valgrind(end) : is_readable_by_sigprocmask(end);
}

size_t probe_copy(void *to, const void *from, size_t size)
{
    /* process_vm_readv transfers whole elements only. The first element ends at the page
     * boundary. */
    size_t first = page_size - ((uintptr_t)from & (page_size - 1));
    if (first > size)
        first = size;
    struct iovec local = {.iov_base = to, .iov_len = size};
    struct iovec remote[] = {
        {.iov_base = (void *)(uintptr_t)from, .iov_len = first},
        {.iov_base = (void *)((uintptr_t)from + first), .iov_len = size - first},
    };
    begin_probe();
    ssize_t count = process_vm_readv(getpid(), &local, 1, remote, 2, 0);
    const int error = errno;
    end_probe();
    if (count >= 0)
        return (size_t)count;
    /* A sandbox or an emulator lacks the call. */
    if (error == EFAULT || !probe_page(((uintptr_t)from & ~(page_size - 1)) + page_size))
        return 0;
    memcpy(to, from, first);
    return first;
}

/* Adds 0 to the aligned word around `byte`, which the kernel does atomically. No thread waits on
 * `unused`. */
static bool is_writable_by_futex(char *byte)
{
    int unused = 0;
    char *word = byte - (uintptr_t)byte % sizeof(int);
    return syscall(SYS_futex, &unused, FUTEX_WAKE_OP | FUTEX_PRIVATE_FLAG, 0, NULL, word,
                   FUTEX_OP(FUTEX_OP_ADD, 0, FUTEX_OP_CMP_LT, 0)) >= 0 ||
           errno != EFAULT;
}

/* The kernel also faults on the local side of the copy, and reports that as an error. */
bool probe_writable(char *const bytes[], unsigned count)
{
    struct iovec pages[PROBE_PAGES];
    for (unsigned i = 0; i < count; i++)
        pages[i] = (struct iovec){.iov_base = bytes[i], .iov_len = 1};
    begin_probe();
    ssize_t copied = process_vm_readv(getpid(), pages, count, pages, count, 0);
    bool is_writable = copied == (ssize_t)count;
    if (copied < 0 && errno != EFAULT) { /* a sandbox or an emulator lacks the call */
        is_writable = true;
        for (unsigned i = 0; i < count && is_writable; i++)
            is_writable = is_writable_by_futex(bytes[i]);
    }
    end_probe();
    return is_writable;
}
