/* SPDX-License-Identifier: Apache-2.0 */
/* Intercepts that find the call site first, for setting call_sites. Without the setting, the
 * application's calls go to the plain intercepts, so call sites cost nothing. */
#ifndef ASSAY_LAYER_INTERCEPTS_CALL_SITES_H
#define ASSAY_LAYER_INTERCEPTS_CALL_SITES_H

#include "layer/layer.h"

/* Creates device->call_sites as the settings say. Without memory there are no call sites. */
void call_sites_enable(struct layer_device *device);

/* The call site of the build command that this thread is in; NULL: unknown, or there is none. */
const struct call_site *call_site_of_thread(void);
/* The call site for entries of a journal; NULL if the setting is off. */
static inline const struct call_site *call_site_of_call(const struct layer_device *device)
{
    return device->call_sites ? call_site_of_thread() : NULL;
}

#endif
