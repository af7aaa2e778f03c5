/* SPDX-License-Identifier: Apache-2.0 */
/* Clearing of small structures on the recording path. */
#ifndef ASSAY_BASE_CLEAR_H
#define ASSAY_BASE_CLEAR_H

#include <stddef.h>
#include <stdint.h>

/* Sets `size` bytes to 0. `size` is a constant and a multiple of 8. For memset, GCC emits a string
 * instruction if it tunes for no processor in particular; that takes longer to begin than all of
 * these stores. */
static inline __attribute__((always_inline)) void clear_words(void *object, size_t size)
{
    uint64_t __attribute__((may_alias)) *words = object;
#pragma GCC unroll 32
    for (size_t i = 0; i < size / sizeof(*words); i++) {
        words[i] = 0;
        __asm__ volatile("" : : : "memory"); /* keeps the compiler from making it a memset again */
    }
}

#endif
