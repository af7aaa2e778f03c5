/* SPDX-License-Identifier: Apache-2.0 */
/* The demo's way out when it can't go on. */
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "fail.h"

void demo_fail(const char *format, ...)
{
    char line[1024];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(line, sizeof(line), format, arguments);
    va_end(arguments);
    /* One line, whatever a library's message or a file's name has in it. */
    for (char *at = line; (at = strpbrk(at, "\r\n"));)
        *at = ' ';

    fflush(stdout);
    fprintf(stderr, "assay_demo: %s\n", line);

    /* Not exit(): a driver's threads may still run, and its destructors don't expect that. */
    fflush(stderr);
    _exit(EXIT_FAILURE);
}

void *demo_alloc(size_t count, size_t size)
{
    void *memory = calloc(count ? count : 1, size);
    if (!memory)
        demo_fail("out of memory: %zu times %zu bytes", count, size);
    return memory;
}
