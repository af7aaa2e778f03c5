/* SPDX-License-Identifier: Apache-2.0 */
/* Counts the system calls by which the layer asks whether memory can be read: they cost more than
 * the rest of a check, and a count of instructions doesn't see them. */
#ifndef BENCH_PROBES_H
#define BENCH_PROBES_H

#include <stdint.h>

/* Since the process began. */
uint64_t probes_count(void);

#endif
