/* SPDX-License-Identifier: Apache-2.0 */
/* Clocks, and medians of samples. */
#include "scripts/tools/measure.h"

#include <malloc.h>
#include <stdlib.h>

double read_clock(clockid_t clock)
{
    struct timespec now;
    clock_gettime(clock, &now);
    return (double)now.tv_sec * 1e9 + (double)now.tv_nsec;
}

double thread_time(void)
{
    return read_clock(CLOCK_THREAD_CPUTIME_ID);
}

double bytes_allocated(void)
{
    const struct mallinfo2 info = mallinfo2();
    return (double)info.uordblks + (double)info.hblkhd;
}

static int compare(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

double quantile(double *values, uint32_t count, double share)
{
    qsort(values, count, sizeof(*values), compare);
    double position = share * (count - 1);
    uint32_t below = (uint32_t)position;
    uint32_t above = below + 1 < count ? below + 1 : below;
    return values[below] + (position - below) * (values[above] - values[below]);
}
