/* SPDX-License-Identifier: Apache-2.0 */
/* The benchmark's way out when it can't go on. */
#ifndef BENCH_FAIL_H
#define BENCH_FAIL_H

#include <stddef.h>
#include <stdnoreturn.h>
#include <vulkan/vulkan_core.h>

/* Ends the process with one line on stderr. */
noreturn void bench_fail(const char *format, ...) __attribute__((format(printf, 1, 2)));

/* The same unless the result is VK_SUCCESS. */
void bench_check(VkResult result, const char *call);

/* Zeroed, never NULL. */
void *bench_alloc(size_t count, size_t size);

#endif
