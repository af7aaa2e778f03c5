/* SPDX-License-Identifier: Apache-2.0 */
/* Asks the system whether memory is accessible, without a fault.
 *
 * Linux: rt_sigprocmask with an invalid `how` has no effect, and reports a fault as an error
 * instead of a signal; under Valgrind, a futex. Copies and writes use process_vm_readv on the own
 * process. If the system forbids these calls, every pointer counts as accessible.
 * Windows: VirtualQuery, and ReadProcessMemory on the own process for copies. */
#ifndef ASSAY_PLATFORM_PROBE_H
#define ASSAY_PLATFORM_PROBE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* The smallest page size of the platforms. Larger pages are probed in parts. */
enum { PROBE_PAGE_SHIFT = 12, PROBE_PAGES = 64 };

/* Returns whether the page that ends at `end` is readable. */
bool probe_page(uintptr_t end);

/* Copies the readable bytes at the beginning of [from, from + size). `size` is at most one page.
 * Returns the number of bytes copied. */
size_t probe_copy(void *to, const void *from, size_t size);

/* Returns whether the bytes, each in another page and at most PROBE_PAGES, can be written.
 * Overwrites them with themselves, so no other thread may write there at the same time. */
bool probe_writable(char *const bytes[], unsigned count);

#endif
