/* SPDX-License-Identifier: Apache-2.0 */
/* Memory of whole pages. */
#ifndef ASSAY_TESTS_WINDOWS_MMAN_H
#define ASSAY_TESTS_WINDOWS_MMAN_H

#include <stddef.h>

enum { PROT_NONE, PROT_READ, PROT_WRITE };
enum { MAP_PRIVATE, MAP_ANONYMOUS = 0, MAP_NORESERVE = 0 };
#define MAP_FAILED ((void *)-1)

void *mmap(void *at, size_t size, int protection, int flags, int file, long offset);
int mprotect(void *pages, size_t size, int protection);
int munmap(void *pages, size_t size);

#endif
