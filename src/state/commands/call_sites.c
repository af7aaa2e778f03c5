/* SPDX-License-Identifier: Apache-2.0 */
/* The table of call sites, and the walk over the stack that finds one. A stack's modules are found
 * when it is added, because a library may be unloaded before a finding is reported. */
#include "src/state/commands/call_sites.h"

#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>
#include <unwind.h>

#include "src/platform/modules.h"
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

static void start_stack(struct call_stack *stack, const void *first)
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
    start_stack(stack, first);
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
    start_stack(stack, first);
    if (is_within(bounds_of_thread(), (uintptr_t)frame))
        _Unwind_Backtrace(add_frame, &walk);
}

/* ---- The table of call sites. A stack's modules are found when it is added, because a library may
 * be unloaded before a finding is reported. */

enum { SLOT_BITS = 15, SLOTS = 1 << SLOT_BITS, SITES_MAX = SLOTS / 2 };

struct site_record {
    uint64_t hash;
    struct call_stack stack;
    struct call_site site;
};

struct module_name {
    struct module_name *next;
    char path[];
};

struct call_sites {
    enum call_stack_kind kind;
    pthread_mutex_t lock; /* of writers; guards the members below */
    struct module_name *modules;
    struct module_place place; /* too large for a stack of the application */
    atomic_uint count;
    /* Open addressing: a record is in the first free slot from its hash on, and stays. */
    struct site_record *_Atomic slots[SLOTS];
};

struct call_sites *call_sites_create(enum call_stack_kind kind)
{
    struct call_sites *sites = calloc(1, sizeof(*sites));
    if (!sites)
        return NULL;
    sites->kind = kind;
    pthread_mutex_init(&sites->lock, NULL);
    return sites;
}

void call_sites_destroy(struct call_sites *sites)
{
    if (!sites)
        return;
    for (unsigned i = 0; i < SLOTS; i++)
        free(atomic_load_explicit(&sites->slots[i], memory_order_relaxed));
    while (sites->modules) {
        struct module_name *module = sites->modules;
        sites->modules = module->next;
        free(module);
    }
    pthread_mutex_destroy(&sites->lock);
    free(sites);
}

enum call_stack_kind call_sites_kind(const struct call_sites *sites)
{
    return sites->kind;
}

uint32_t call_sites_count(struct call_sites *sites)
{
    return atomic_load(&sites->count);
}

/* ---- frames; the lock is held */

/* Returns NULL if memory runs out. */
static const char *keep_path(struct call_sites *sites, const char *path)
{
    for (const struct module_name *module = sites->modules; module; module = module->next)
        if (strcmp(module->path, path) == 0)
            return module->path;
    size_t size = strlen(path) + 1;
    struct module_name *module = malloc(sizeof(*module) + size);
    if (!module)
        return NULL;
    memcpy(module->path, path, size);
    module->next = sites->modules;
    sites->modules = module;
    return module->path;
}

/* What is known of the frames of a stack. */
struct frames {
    struct call_site all;
    bool is_vulkan[CALL_STACK_FRAMES];
};

/* Returns false if memory runs out.
 *
 * The first address is always right. An address behind it that follows no call is no return
 * address: the register that led there held no frame pointer. Such an address, and what follows, is
 * dropped, and so are addresses outside all modules at the end. */
static bool find_frames(struct call_sites *sites, const struct call_stack *stack,
                        struct frames *frames)
{
    bool may_be_wrong = sites->kind == CALL_STACK_BY_FRAMES;
    uint32_t known = may_be_wrong ? 1 : stack->count;
    for (uint32_t i = 0; i < stack->count; i++) {
        struct call_frame *frame = &frames->all.frames[i];
        *frame = (struct call_frame){NULL, stack->addresses[i]};
        frames->is_vulkan[i] = false;
        if (!module_find(stack->addresses[i], &sites->place))
            continue;
        if (i && may_be_wrong && !sites->place.follows_call)
            break;
        frame->module = keep_path(sites, sites->place.path);
        frame->offset = sites->place.offset;
        frames->is_vulkan[i] = sites->place.is_vulkan;
        if (!frame->module)
            return false;
        if (may_be_wrong)
            known = i + 1;
    }
    frames->all.count = known;
    return true;
}

/* Leaves out the frames of the loader and of layers, unless there are no others. */
static void keep_frames_of_application(const struct frames *frames, struct call_site *site)
{
    site->count = 0;
    for (uint32_t i = 0; i < frames->all.count; i++)
        if (!frames->is_vulkan[i])
            site->frames[site->count++] = frames->all.frames[i];
    if (!site->count)
        *site = frames->all;
}

/* ---- the table */

static uint64_t hash_of(const struct call_stack *stack)
{
    uint64_t hash = stack->count;
    for (uint32_t i = 0; i < stack->count; i++) {
        hash = (hash ^ stack->addresses[i]) * 0x9e3779b97f4a7c15u;
        hash ^= hash >> 32;
    }
    return hash;
}

static bool is_equal(const struct site_record *record, uint64_t hash,
                     const struct call_stack *stack)
{
    return record->hash == hash && record->stack.count == stack->count &&
           memcmp(record->stack.addresses, stack->addresses,
                  stack->count * sizeof(stack->addresses[0])) == 0;
}

/* Returns the record, or NULL; then `slot` is where it belongs. */
static const struct site_record *look_up_site(struct call_sites *sites, uint64_t hash,
                                              const struct call_stack *stack, uint32_t *slot)
{
    for (*slot = (uint32_t)(hash >> (64 - SLOT_BITS));; *slot = (*slot + 1) % SLOTS) {
        const struct site_record *record =
            atomic_load_explicit(&sites->slots[*slot], memory_order_acquire);
        if (!record || is_equal(record, hash, stack))
            return record;
    }
}

/* Returns NULL if memory runs out. */
static struct site_record *make_record(struct call_sites *sites, uint64_t hash,
                                       const struct call_stack *stack)
{
    struct frames frames;
    if (!find_frames(sites, stack, &frames))
        return NULL;
    struct site_record *record = malloc(sizeof(*record));
    if (!record)
        return NULL;
    record->hash = hash;
    record->stack = *stack;
    keep_frames_of_application(&frames, &record->site);
    return record;
}

__attribute__((cold, noinline)) static const struct site_record *
add(struct call_sites *sites, uint64_t hash, const struct call_stack *stack)
{
    uint32_t slot;
    pthread_mutex_lock(&sites->lock);
    const struct site_record *found = look_up_site(sites, hash, stack, &slot);
    if (!found && sites->count < SITES_MAX) {
        struct site_record *record = make_record(sites, hash, stack);
        found = record;
        if (record) {
            atomic_store_explicit(&sites->slots[slot], record, memory_order_release);
            sites->count++;
        }
    }
    pthread_mutex_unlock(&sites->lock);
    return found;
}

const struct call_site *call_sites_find(struct call_sites *sites, const struct call_stack *stack)
{
    uint32_t slot;
    uint64_t hash = hash_of(stack);
    const struct site_record *found = look_up_site(sites, hash, stack, &slot);
    if (!found)
        found = add(sites, hash, stack);
    return found ? &found->site : NULL;
}
