/* SPDX-License-Identifier: Apache-2.0 */
/* Clocks, and medians of samples. */
#ifndef TOOLS_MEASURE_H
#define TOOLS_MEASURE_H

#include <stdint.h>
#include <time.h>

double read_clock(clockid_t clock); /* nanoseconds */
double thread_time(void);           /* CPU time that this thread has used, nanoseconds */
double bytes_allocated(void);       /* by malloc and the like */

/* The value below which a share of the values lies, 0.5 for the median; sorts them. count > 0. */
double quantile(double *values, uint32_t count, double share);

#endif
