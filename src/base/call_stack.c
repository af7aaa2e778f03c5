/* SPDX-License-Identifier: Apache-2.0 */
/* Walks the stack of the calling thread. */
#include "src/base/call_stack.h"

#include <stdbool.h>
#include <unwind.h>

#include "src/platform/threads.h"

/* What a function with a frame pointer stores at the address in it. */
struct frame_record {
    const struct frame_record *caller;
    uintptr_t return_address;
};

/* The ABIs of both processors align the stack like this when a function is called. */
enum { FRAME_ALIGNMENT = 16 };

/* Equal bounds: not known, so that no address is within. */
struct stack_bounds {
    uintptr_t begin, end;
    bool is_found; /* or failed to be */
};

__attribute__((cold, noinline)) static void find_bounds(struct stack_bounds *bounds)
{
    bounds->is_found = true;
    thread_find_stack(&bounds->begin, &bounds->end);
}

/* Noinline, so that the thread-local variable is located once per call. */
__attribute__((noinline)) static const struct stack_bounds *bounds_of_thread(void)
{
    static _Thread_local struct stack_bounds of_thread;
    if (!of_thread.is_found)
        find_bounds(&of_thread);
    return &of_thread;
}

static bool is_within(const struct stack_bounds *bounds, uintptr_t address)
{
    return bounds->begin <= address && address < bounds->end;
}

/* Code for 64-bit ARM may sign return addresses. The instruction removes a signature, and does
 * nothing on processors without signatures. */
static uintptr_t without_signature(uintptr_t address)
{
#ifdef __aarch64__
    register uintptr_t x30 __asm__("x30") = address;
    __asm__("hint #7 // xpaclri" : "+r"(x30));
    return x30;
#else
    return address;
#endif
}

static void start(struct call_stack *stack, const void *first)
{
    stack->count = 1;
    stack->addresses[0] = without_signature((uintptr_t)first);
}

/* ---- by frame pointers */

/* From `frame` to the end of its stack, all memory is in use and readable. A register that holds no
 * frame pointer may lead anywhere in there, so the sanitizers must not watch what is read. */
__attribute__((no_sanitize("address", "thread"))) void
call_stack_walk_frames(const void *frame, const void *first, struct call_stack *stack)
{
    const struct stack_bounds *bounds = bounds_of_thread();
    const struct frame_record *record = frame;
    start(stack, first);
    if (!THREADS_HAVE_FRAME_RECORDS) {
        call_stack_walk_tables(frame, first, stack);
        return;
    }
    if (!is_within(bounds, (uintptr_t)frame))
        return;
    while (stack->count < CALL_STACK_FRAMES) {
        const struct frame_record *caller = record->caller;
        if (caller <= record || (uintptr_t)caller % FRAME_ALIGNMENT != 0 ||
            (uintptr_t)caller > bounds->end - sizeof(*caller) || !caller->return_address)
            return;
        stack->addresses[stack->count++] = without_signature(caller->return_address);
        record = caller;
    }
}

/* ---- by tables */

/* Frames of this file, and of the function whose callers are wanted. */
enum { OWN_FRAMES = 8 };

struct table_walk {
    struct call_stack *stack;
    uint32_t own_frames;
    bool has_begun;
};

static _Unwind_Reason_Code add_frame(struct _Unwind_Context *context, void *user)
{
    struct table_walk *walk = user;
    struct call_stack *stack = walk->stack;
    uintptr_t address = without_signature(_Unwind_GetIP(context));
    if (!walk->has_begun) {
        walk->has_begun = address == stack->addresses[0];
        return walk->has_begun || walk->own_frames++ < OWN_FRAMES ? _URC_NO_REASON
                                                                  : _URC_END_OF_STACK;
    }
    if (stack->count == CALL_STACK_FRAMES || !address)
        return _URC_END_OF_STACK;
    stack->addresses[stack->count++] = address;
    return _URC_NO_REASON;
}

/* The unwinder of libgcc, which is linked statically, finds tables by _dl_find_object(), which
 * takes no lock. It keeps its state on the stack. backtrace() would load libgcc_s.so at its first
 * use, and libunwind would be one more library. */
void call_stack_walk_tables(const void *frame, const void *first, struct call_stack *stack)
{
    struct table_walk walk = {.stack = stack};
    start(stack, first);
    if (is_within(bounds_of_thread(), (uintptr_t)frame))
        _Unwind_Backtrace(add_frame, &walk);
}
