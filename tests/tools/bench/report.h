/* SPDX-License-Identifier: Apache-2.0 */
/* The two tables, the same figures as CSV, and the bars that they are held to. */
#ifndef BENCH_REPORT_H
#define BENCH_REPORT_H

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

struct report {
    FILE *csv; /* or NULL */
    bool time_bars, memory_bars;
    double reference; /* the overhead at the size that growth is told against; 0 until measured */
    uint32_t bars, missed;
};

/* One measurement of one case. `spread` is half the interquartile range of the differences of
 * samples taken in turn. */
struct row {
    const char *driver, *buffers, *order;
    uint32_t builds_per_call;
    double without, with, spread; /* nanoseconds, or bytes, a build */
};

void report_open(struct report *report, const char *csv_path);

/* The rows of a series, which differ in their sizes, smallest first. */
void report_time_head(uint32_t samples);
void report_time_series(struct report *report);
void report_time(struct report *report, const struct row *row);

void report_memory_head(uint32_t builds);
void report_memory(struct report *report, const struct row *row);

/* Prints how many bars were met. Returns whether all were. */
bool report_close(struct report *report);

#endif
