/* SPDX-License-Identifier: Apache-2.0 */
/* What it costs to ask the system whether pages can be read, by each call that answers that: the
 * figures of docs/costs.md. */
#define _GNU_SOURCE /* process_vm_readv, syscall, MAP_ANONYMOUS */
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/syscall.h>
#include <sys/uio.h>
#include <unistd.h>

#include "scripts/tools/measure.h"

enum { PAGE = 4096, PAGES_MAX = 64, TIMES = 20000, SAMPLES = 15, SIGNALS_SIZE = 8 };

static char *pages;

static void by_sigprocmask(size_t count)
{
    for (size_t i = 0; i < count; i++)
        syscall(SYS_rt_sigprocmask, -1, pages + (i + 1) * PAGE - SIGNALS_SIZE, NULL, SIGNALS_SIZE);
}

static void by_process_vm_readv(size_t count)
{
    char bytes[PAGES_MAX];
    struct iovec local = {bytes, count}, remote[PAGES_MAX];
    for (size_t i = 0; i < count; i++)
        remote[i] = (struct iovec){pages + i * PAGE, 1};
    process_vm_readv(getpid(), &local, 1, remote, count, 0);
}

/* It says only that a page is mapped, not that it can be read. */
static void by_mincore(size_t count)
{
    unsigned char is_resident[PAGES_MAX];
    mincore(pages, count * PAGE, is_resident);
}

static void by_nothing(size_t count)
{
    syscall(SYS_getppid);
}

/* The median, in nanoseconds. */
static double measure(void (*probe)(size_t count), size_t count)
{
    const int times = TIMES / (int)count;
    double samples[SAMPLES];
    for (int s = 0; s < SAMPLES; s++) {
        const double begin = read_clock(CLOCK_MONOTONIC);
        for (int i = 0; i < times; i++)
            probe(count);
        samples[s] = (read_clock(CLOCK_MONOTONIC) - begin) / times;
    }
    return quantile(samples, SAMPLES, 0.5);
}

int main(void)
{
    static const struct {
        const char *name;
        void (*probe)(size_t count);
    } probes[] = {
        {"getppid (an empty call)", by_nothing},
        {"rt_sigprocmask", by_sigprocmask},
        {"process_vm_readv", by_process_vm_readv},
        {"mincore", by_mincore},
    };
    static const size_t counts[] = {1, 4, 16, 64};
    pages = mmap(NULL, (size_t)PAGES_MAX * PAGE, PROT_READ | PROT_WRITE,
                 MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (pages == MAP_FAILED)
        return EXIT_FAILURE;
    memset(pages, 1, (size_t)PAGES_MAX * PAGE);
    printf("%-26s%10s%10s%10s%10s\n", "ns for pages:", "1", "4", "16", "64");
    for (size_t p = 0; p < sizeof(probes) / sizeof(probes[0]); p++) {
        printf("%-26s", probes[p].name);
        for (size_t c = 0; c < sizeof(counts) / sizeof(counts[0]); c++)
            printf("%10.0f", measure(probes[p].probe, counts[c]));
        printf("\n");
    }
    return EXIT_SUCCESS;
}
