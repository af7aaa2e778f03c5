/* SPDX-License-Identifier: Apache-2.0 */
/* Counts the system calls by which the layer asks whether memory can be read: they cost more than
 * the rest of a check, and a count of instructions doesn't see them. */
#ifndef BENCH_PROBES_H
#define BENCH_PROBES_H

#include <stdint.h>

/* Since the process began. */
uint64_t probes_count(void);

/* The layer forgets which memory is readable when CLOCK_MONOTONIC_COARSE advances. From the first
 * call on that clock stands still and advances by these calls only, so that the number of probes
 * doesn't depend on how fast the machine is. */
void probes_advance_clock(void);

#endif
