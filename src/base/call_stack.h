/* SPDX-License-Identifier: Apache-2.0 */
/* The return addresses of a call, innermost first. The walks allocate no memory and take no lock,
 * except that the first walk of a thread asks the C library for the thread's stack. They leave
 * nothing behind that would keep the library from being unloaded.
 *
 * Both walks stay within the stack of the thread. If the caller runs on another stack (a coroutine,
 * an alternate stack for signals), they return the first address alone, which is always right. */
#ifndef ASSAY_BASE_CALL_STACK_H
#define ASSAY_BASE_CALL_STACK_H

#include <stdint.h>

enum { CALL_STACK_FRAMES = 16 };

struct call_stack {
    uint32_t count;
    uintptr_t addresses[CALL_STACK_FRAMES];
};

/* Walks the frame pointers, which x86-64 (rbp) and AArch64 (x29) store alike. `frame` is
 * __builtin_frame_address(0) of the function whose callers are wanted, and `first` is its
 * __builtin_return_address(0). Callers without frame pointers may yield addresses that are no
 * return addresses; module_find() recognizes most of these. */
void call_stack_walk_frames(const void *frame, const void *first, struct call_stack *stack);

/* Walks by unwinding tables. The parameters are the same. */
void call_stack_walk_tables(const void *frame, const void *first, struct call_stack *stack);

#endif
