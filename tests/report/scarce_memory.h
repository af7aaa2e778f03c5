/* SPDX-License-Identifier: Apache-2.0 */
/* Allocations that fail on demand: the linker sends malloc and its kin of the test program here. */
#ifndef REPORT_SCARCE_MEMORY_H
#define REPORT_SCARCE_MEMORY_H

#include <stdbool.h>

/* The condition of a loop over counts from 0 on: true until no allocation failed in the last round.
 * In the round that begins, the allocation after `count` others fails, once. Fails the test if
 * there were no three rounds. Not for tests with threads. */
bool memory_is_scarce(int count);

/* Turns that off again. Returns true if an allocation has failed. */
bool memory_fail_no_more(void);

#endif
