/* SPDX-License-Identifier: Apache-2.0 */
/* The demo's way out when it can't go on. */
#ifndef DEMO_FAIL_H
#define DEMO_FAIL_H

#include <stddef.h>

/* Print one line on stderr and end the process with a non-zero status. */
_Noreturn void demo_fail(const char *format, ...) __attribute__((format(printf, 1, 2)));

/* Memory that is zeroed and always there: running out of it is one of the ways out. */
void *demo_alloc(size_t count, size_t size);

#endif
