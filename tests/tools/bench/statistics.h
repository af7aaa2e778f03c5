/* SPDX-License-Identifier: Apache-2.0 */
/* Medians of samples. */
#ifndef BENCH_STATISTICS_H
#define BENCH_STATISTICS_H

#include <stdint.h>

/* The value below which a share of the values lies, 0.5 for the median; sorts them. count > 0. */
double quantile(double *values, uint32_t count, double share);

#endif
