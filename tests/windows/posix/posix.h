/* SPDX-License-Identifier: Apache-2.0 */
/* What the tests use of POSIX and MinGW-w64 lacks. CMake includes this file first in each source of
 * the tests. Only as much as the tests need: mmap() gives memory, and maps no file. */
#ifndef ASSAY_TESTS_WINDOWS_POSIX_H
#define ASSAY_TESTS_WINDOWS_POSIX_H

#include <direct.h>
#include <malloc.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

/* Conditions of winpthreads know one clock. */
#undef CLOCK_MONOTONIC
#define CLOCK_MONOTONIC CLOCK_REALTIME

#define SIGBUS SIGSEGV
#define SIGTRAP SIGABRT
#define _SC_PAGESIZE 1
#define MFD_CLOEXEC 0

#define malloc_usable_size(block) _msize(block)
#define mkdir(path, mode) _mkdir(path)
#define program_invocation_short_name (__argv[0])

char *mkdtemp(char *name);
int setenv(const char *name, const char *value, int overwrite);
int unsetenv(const char *name);
long sysconf(int name);
int memfd_create(const char *name, unsigned flags);
void *aligned_alloc(size_t alignment, size_t size);
void *__real_malloc(size_t size);
void *__real_calloc(size_t count, size_t size);
void *__real_realloc(void *old, size_t size);
void *__real_aligned_alloc(size_t alignment, size_t size);
char *__real_strdup(const char *text);
void __real_free(void *block);

#endif
