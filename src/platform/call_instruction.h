/* SPDX-License-Identifier: Apache-2.0 */
/* Recognizes calls in the code of x86-64 and AArch64. */
#ifndef ASSAY_PLATFORM_CALL_INSTRUCTION_H
#define ASSAY_PLATFORM_CALL_INSTRUCTION_H

#include <stdbool.h>
#include <stdint.h>
#include <string.h>

/* Returns whether the instruction before `at` is a call; true on other processors. The code is read
 * from `begin` on. */
static inline bool follows_call(const unsigned char *begin, const unsigned char *at)
{
#if defined(__x86_64__)
    static const int sizes[] = {2, 3, 4, 6, 7}; /* of FF /2, by its addressing mode */
    if (at - begin >= 5 && at[-5] == 0xe8)
        return true;
    for (unsigned i = 0; i < sizeof(sizes) / sizeof(sizes[0]); i++)
        if (at - begin >= sizes[i] && at[-sizes[i]] == 0xff && (at[1 - sizes[i]] >> 3 & 7) == 2)
            return true;
    return false;
#elif defined(__aarch64__)
    uint32_t before;
    if (at - begin < 4)
        return false;
    memcpy(&before, at - 4, sizeof(before));
    return before >> 26 == 0x25 || (before & 0xfffffc1f) == 0xd63f0000; /* bl, blr */
#else
    return true;
#endif
}

#endif
