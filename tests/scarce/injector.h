/* SPDX-License-Identifier: Apache-2.0 */
/* Allocations of one library in this process: counted, tracked until they are freed, and made to
 * fail. The test program's malloc and its kin stand in for the C library's, and know who calls by
 * the return address. Not for programs in which the library allocates on several threads. */
#ifndef SCARCE_INJECTOR_H
#define SCARCE_INJECTOR_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Loads the library, for good, and watches it from now on. False, with dlerror set, if it can't. */
bool injector_watch(const char *path);

/* Its n-th allocation from now on fails, once; 0: none does. Counts from the start again. */
void injector_fail_at(unsigned n);

/* From now on stacks[n - 1] is set to a hash of the return addresses of the n-th allocation's
 * callers within the library, if n is at most `most`. NULL ends this. */
void injector_record_stacks(uint64_t *stacks, unsigned most);

/* Where in the library the failing allocation was asked for; 0: nowhere yet. Such places are
 * offsets to hand to addr2line. */
size_t injector_failed(void);

/* How many of its blocks are allocated now, and where the oldest of them was. */
size_t injector_live(void);
size_t injector_oldest(void);

#endif
