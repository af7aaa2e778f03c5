/* SPDX-License-Identifier: Apache-2.0 */
/* The benchmark's way out when it can't go on. */
#define _GNU_SOURCE /* program_invocation_short_name */
#include "fail.h"

#include <errno.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>
#include <vulkan/vk_enum_string_helper.h>

void bench_fail(const char *format, ...)
{
    fflush(stdout);
    va_list arguments;
    va_start(arguments, format);
    fprintf(stderr, "%s: ", program_invocation_short_name);
    vfprintf(stderr, format, arguments);
    fputc('\n', stderr);
    va_end(arguments);
    /* Not exit(): a driver's threads may still run, and its destructors don't expect that. */
    fflush(stderr);
    _exit(EXIT_FAILURE);
}

void bench_check(VkResult result, const char *call)
{
    if (result != VK_SUCCESS)
        bench_fail("%s failed: %s", call, string_VkResult(result));
}

void *bench_alloc(size_t count, size_t size)
{
    void *memory = calloc(count ? count : 1, size);
    if (!memory)
        bench_fail("out of memory: %zu times %zu bytes", count, size);
    return memory;
}
