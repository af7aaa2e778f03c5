/* SPDX-License-Identifier: Apache-2.0 */
/* Records what host commands access, and mapped memory behind host addresses. */
#ifndef ASSAY_LAYER_HAZARDS_HOST_H
#define ASSAY_LAYER_HAZARDS_HOST_H

#include "layer/hazards/recording.h"
#include "layer/intercepts/host_work.h"

/* Begins the journal of a host command, which the next host_work_begin() of this thread takes over.
 * Returns false if nothing is to be recorded. */
bool hazards_start_host(struct hazard_recording *recording, struct layer_device *device,
                        const char *name);

/* Adds accesses to the host memory behind a pointer, as far as it is mapped device memory. */
void hazards_add_host(struct hazard_recording *recording, const struct hazard_use *use,
                      const void *pointer, uint64_t size);

#endif
