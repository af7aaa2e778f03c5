/* SPDX-License-Identifier: Apache-2.0 */
/* Probes memory through system calls. */
#define _GNU_SOURCE /* mincore, process_vm_readv, syscall */
#include "src/base/readable.h"
#include "src/base/recording_path.h"

#include <errno.h>
#include <stdatomic.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/syscall.h>
#include <sys/uio.h>
#include <time.h>
#include <unistd.h>

enum { INVALID_HOW = -1, SIGNALS_SIZE = 8, VALGRIND_IS_RUNNING = 0x1001 };

static const uintptr_t page_size = (uintptr_t)1 << READABLE_PAGE_SHIFT;

/* Executes Valgrind's client request. Valgrind answers it; a processor executes it without effect.
 * (valgrind.h has the same for more processors; the layer builds without that header.) */
static bool valgrind_answers(void)
{
    volatile uintptr_t request[6] = {VALGRIND_IS_RUNNING}, answer = 0;
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
    return request[0] == VALGRIND_IS_RUNNING && answer != 0;
}

static bool runs_on_valgrind(void)
{
    enum { UNTESTED, NO_VALGRIND, VALGRIND };
    static atomic_int known; /* starts as UNTESTED */
    int answer = atomic_load_explicit(&known, memory_order_relaxed);
    if (answer == UNTESTED) {
        answer = valgrind_answers() ? VALGRIND : NO_VALGRIND;
        atomic_store_explicit(&known, answer, memory_order_relaxed);
    }
    return answer == VALGRIND;
}

/* The kernel first copies a signal set from the last bytes of the page, and only then rejects
 * `how`. No other call that reads memory is as cheap: process_vm_readv costs five times as much.
 * The call also reads device memory. */
static bool is_readable_by_sigprocmask(uintptr_t end)
{
    return syscall(SYS_rt_sigprocmask, INVALID_HOW, end - SIGNALS_SIZE, NULL, SIGNALS_SIZE) == 0 ||
           errno != EFAULT;
}

/* Valgrind executes rt_sigprocmask itself and warns about the invalid `how`. It forwards
 * process_vm_readv, which cannot read device memory. If process_vm_readv fails on mapped memory,
 * the probe falls back to rt_sigprocmask despite the warning. */
static bool is_readable_on_valgrind(uintptr_t end)
{
    char byte;
    unsigned char is_resident;
    if (readable_copy(&byte, (const void *)(end - 1), 1) == 1)
        return true;
    bool is_mapped = mincore((void *)(end - page_size), 1, &is_resident) == 0 || errno != ENOMEM;
    return is_mapped && is_readable_by_sigprocmask(end);
}

static bool is_readable_page(uintptr_t end)
{
    return runs_on_valgrind() ? is_readable_on_valgrind(end) : is_readable_by_sigprocmask(end);
}

/* Returns the end of the cached range that contains `address`, or 0. */
static uintptr_t known_end(const struct readable_cache *cache, uintptr_t address)
{
    for (unsigned i = 0; i < cache->count; i++)
        if (cache->ranges[i].begin <= address && address < cache->ranges[i].end)
            return cache->ranges[i].end;
    return 0;
}

/* Adds a page and merges it with the ranges that are adjacent to it. */
static void add_page(struct readable_cache *cache, uintptr_t begin, uintptr_t end)
{
    unsigned kept = 0;
    for (unsigned i = 0; i < cache->count; i++) {
        if (cache->ranges[i].end == begin)
            begin = cache->ranges[i].begin;
        else if (cache->ranges[i].begin == end)
            end = cache->ranges[i].end;
        else
            cache->ranges[kept++] = cache->ranges[i];
    }
    unsigned range = kept;
    if (kept == READABLE_RANGES) {
        range = cache->oldest;
        cache->oldest = (range + 1) % READABLE_RANGES;
    } else {
        cache->count = kept + 1;
    }
    cache->ranges[range].begin = begin;
    cache->ranges[range].end = end;
}

/* Probes the page of `address`. Returns the end of the readable page, or 0. */
static uintptr_t find_end(struct readable_cache *cache, uintptr_t address)
{
    uintptr_t page = address & ~(page_size - 1);
    if (!is_readable_page(page + page_size))
        return 0;
    add_page(cache, page, page + page_size);
    return page + page_size;
}

void readable_forget(struct readable_cache *cache)
{
    cache->count = 0;
    memset(cache->recent, 0, sizeof(cache->recent));
}

struct cache_of_thread {
    struct timespec filled;
    struct readable_cache cache;
};

/* Noinline, so that the thread-local variable is located once per call: a library loaded by dlopen
 * locates each access through a function call. */
ON_RECORDING_PATH __attribute__((noinline)) static struct cache_of_thread *cache_of_thread(void)
{
    static _Thread_local struct cache_of_thread of_thread;
    return &of_thread;
}

ON_RECORDING_PATH struct readable_cache *readable_cache_of_thread(void)
{
    struct cache_of_thread *own = cache_of_thread();
    struct timespec now;
    /* This clock advances with the system timer; reading it takes no system call. */
    clock_gettime(CLOCK_MONOTONIC_COARSE, &now);
    if (now.tv_nsec != own->filled.tv_nsec || now.tv_sec != own->filled.tv_sec) {
        own->filled = now;
        readable_forget(&own->cache);
    }
    return &own->cache;
}

ON_RECORDING_PATH size_t readable_extent(struct readable_cache *cache, const void *pointer,
                                         size_t size)
{
    uintptr_t begin = (uintptr_t)pointer;
    if (!size || !begin)
        return 0;
    uintptr_t last = size - 1 <= UINTPTR_MAX - begin ? begin + (size - 1) : UINTPTR_MAX;
    uintptr_t at = begin;
    while (at <= last) {
        uintptr_t end = known_end(cache, at);
        if (!end)
            end = find_end(cache, at);
        if (!end)
            return at - begin;
        at = end;
    }
    cache->recent[begin / page_size % READABLE_RECENT] = begin | (page_size - 1);
    return size;
}

size_t readable_copy(void *to, const void *from, size_t size)
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
    ssize_t count = process_vm_readv(getpid(), &local, 1, remote, 2, 0);
    if (count >= 0)
        return (size_t)count;
    if (errno == EFAULT)
        return 0;
    memcpy(to, from, first);
    return first;
}
