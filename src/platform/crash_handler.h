/* SPDX-License-Identifier: Apache-2.0 */
/* Reports that the process crashes. Linux: SIGSEGV, SIGBUS, SIGFPE and SIGABRT. Windows: exceptions
 * that nothing handles, but not abort(). */
#ifndef ASSAY_PLATFORM_CRASH_HANDLER_H
#define ASSAY_PLATFORM_CRASH_HANDLER_H

#include <stdbool.h>
#include <stdint.h>

/* What the process received. */
struct crash_event {
    const char *name; /* such as SIGSEGV */
    bool has_address;
    bool is_of_instruction; /* the address is the instruction's, not that of the memory */
    uint64_t address;
};

struct crash_hooks {
    /* Called in the thread that crashes, once in a process: neither allocates nor locks. */
    void (*report)(const struct crash_event *event);
    /* Called in a thread of its own when `report` calls crash_handler_validate(). Returns false if
     * it fails. */
    bool (*validate)(void);
};

/* The caller calls these one at a time. A handler that the application has installed meanwhile
 * stays when crash_handler_uninstall() is called; the layer's library then stays in memory, because
 * that handler may call the layer's. */
void crash_handler_install(const struct crash_hooks *hooks);
void crash_handler_uninstall(void);

/* Returns whether the process is a child of the one that installed the handlers. A child has the
 * handlers of its parent, but not its thread. */
bool crash_handler_is_of_parent(void);
/* Forgets the parent's report and thread. */
void crash_handler_leave_parent(void);

/* Calls `validate` in its thread and waits for some seconds. Returns false if it failed, or did not
 * return in time: the thread may need a lock that the crash left taken. */
bool crash_handler_validate(void);

/* Waits until no handler reports. */
void crash_handler_wait(void);

#endif
