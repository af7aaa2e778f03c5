/* SPDX-License-Identifier: Apache-2.0 */
/* The return addresses of a call, innermost first. The walks allocate no memory and take no lock,
 * except that the first walk of a thread asks the C library for the thread's stack. They leave
 * nothing behind that would keep the library from being unloaded.
 *
 * Both walks stay within the stack of the thread. If the caller runs on another stack (a coroutine,
 * an alternate stack for signals), they return the first address alone, which is always right. */
#ifndef ASSAY_STATE_COMMANDS_CALL_SITES_H
#define ASSAY_STATE_COMMANDS_CALL_SITES_H

#include <stdbool.h>
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

/* ---- The call sites of one device: from where the application calls build commands. Equal stacks
 * share one call site, which lives as long as the table. Thread-safe: looking up a known stack
 * takes no lock. */

struct call_sites;

struct call_frame {
    const char *module; /* the path of its file; NULL: unknown */
    uint64_t offset;    /* of the return address, see struct module_place; or the address itself */
};

static inline const char *call_frame_module(const struct call_frame *frame)
{
    return frame->module ? frame->module : "unknown module";
}

/* The frames of the application, innermost first; at least one. */
struct call_site {
    uint32_t count;
    struct call_frame frames[CALL_STACK_FRAMES];
};

/* How stacks are walked. Frames found by frame pointers are kept as far as they look right. */
enum call_stack_kind { CALL_STACK_BY_FRAMES, CALL_STACK_BY_TABLES };

/* Returns NULL if memory runs out. */
struct call_sites *call_sites_create(enum call_stack_kind kind);
/* Accepts NULL. */
void call_sites_destroy(struct call_sites *sites);

/* The kind of stacks that the table is for. */
enum call_stack_kind call_sites_kind(const struct call_sites *sites);

/* Returns the call site of a stack. Returns NULL if memory runs out, or the table is full. */
const struct call_site *call_sites_find(struct call_sites *sites, const struct call_stack *stack);

/* The number of different stacks. */
uint32_t call_sites_count(struct call_sites *sites);

#endif
