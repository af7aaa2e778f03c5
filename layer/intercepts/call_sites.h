/* SPDX-License-Identifier: Apache-2.0 */
/* Call sites of commands that are validated, for setting call_sites. With the setting, generated
 * entries find the caller before they call the plain ones; without it, call sites cost nothing. */
#ifndef ASSAY_LAYER_INTERCEPTS_CALL_SITES_H
#define ASSAY_LAYER_INTERCEPTS_CALL_SITES_H

#include "layer/layer.h"

/* Creates device->call_sites as the settings say. Without memory there are no call sites. */
void call_sites_enable(struct layer_device *device);

/* For an entry: its frame and its return address, see call_stack_walk_frames(). `device` may be
 * NULL for an invalid handle. Returns the site of the call in whose message callback this one is
 * made, which call_site_leave() gets. */
const struct call_site *call_site_enter(const struct layer_device *device, const void *dispatchable,
                                        const void *frame, const void *first);
void call_site_leave(const struct call_site *outer);

/* The call site of the command that this thread is in; NULL: unknown, or there is none. */
const struct call_site *call_site_of_thread(void);
/* The call site for entries of a journal; NULL if the setting is off. */
static inline const struct call_site *call_site_of_call(const struct layer_device *device)
{
    return device->call_sites ? call_site_of_thread() : NULL;
}

#endif
