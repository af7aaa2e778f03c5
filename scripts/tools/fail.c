/* SPDX-License-Identifier: Apache-2.0 */
/* Ends a tool that can't go on. */
#define _GNU_SOURCE /* program_invocation_short_name */
#include "scripts/tools/fail.h"

#include <errno.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include <vulkan/vk_enum_string_helper.h>

void tool_fail(const char *format, ...)
{
    char line[1024];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(line, sizeof(line), format, arguments);
    va_end(arguments);
    /* One line, even if a library's message or a file's name has several. */
    for (char *at = line; (at = strpbrk(at, "\r\n"));)
        *at = ' ';

    fflush(stdout);
    fprintf(stderr, "%s: %s\n", program_invocation_short_name, line);
    /* Not exit(): a driver's threads may still run, and its destructors don't expect that. */
    fflush(stderr);
    _exit(EXIT_FAILURE);
}

void tool_check(VkResult result, const char *call)
{
    if (result != VK_SUCCESS)
        tool_fail("%s failed: %s", call, string_VkResult(result));
}

void *tool_alloc(size_t count, size_t size)
{
    void *memory = calloc(count ? count : 1, size);
    if (!memory)
        tool_fail("out of memory: %zu times %zu bytes", count, size);
    return memory;
}
