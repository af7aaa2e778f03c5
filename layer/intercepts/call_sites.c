/* SPDX-License-Identifier: Apache-2.0 */
/* Finds the call sites of commands that are validated.
 *
 * A finding at the call takes the call site from the thread. A finding at submission or completion
 * takes it from the journal, whose entries have taken it from the thread. */
#include "layer/intercepts/call_sites.h"

#include <string.h>

#include "src/state/commands/call_sites.h"

/* Noinline, so that the thread-local variable is located once per call. */
__attribute__((noinline)) static const struct call_site **site_of_thread(void)
{
    static _Thread_local const struct call_site *of_thread;
    return &of_thread;
}

const struct call_site *call_site_of_thread(void)
{
    return *site_of_thread();
}

void call_sites_enable(struct layer_device *device)
{
    switch (reporter_settings(device->instance->reporter)->call_sites) {
    case CALL_SITES_OFF:
        break;
    case CALL_SITES_FRAMES:
        device->call_sites = call_sites_create(CALL_STACK_BY_FRAMES);
        break;
    case CALL_SITES_FULL:
        device->call_sites = call_sites_create(CALL_STACK_BY_TABLES);
        break;
    }
}

/* ---- one call */

static const struct call_site *find_site(const struct layer_device *device, const void *frame,
                                         const void *first)
{
    struct call_stack stack;
    if (!device || !device->call_sites)
        return NULL;
    if (call_sites_kind(device->call_sites) == CALL_STACK_BY_FRAMES)
        call_stack_walk_frames(frame, first, &stack);
    else
        call_stack_walk_tables(frame, first, &stack);
    return call_sites_find(device->call_sites, &stack);
}

const struct call_site *call_site_enter(const struct layer_device *device, const void *dispatchable,
                                        const void *frame, const void *first)
{
    const struct call_site **of_thread = site_of_thread(), *outer = *of_thread;
    /* An invalid handle is reported on another device. */
    *of_thread =
        find_site(device ? device : layer_find_reporting_device(dispatchable), frame, first);
    return outer;
}

void call_site_leave(const struct call_site *outer)
{
    *site_of_thread() = outer;
}
