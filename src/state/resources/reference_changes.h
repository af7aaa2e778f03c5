/* SPDX-License-Identifier: Apache-2.0 */
/* Notes which values that instances refer to structures by have changed: a structure got the value,
 * was destroyed, or gained or lost its memory. A device with guarded builds needs this
 * (layer/snapshots/guard/). */
#ifndef ASSAY_STATE_RESOURCES_REFERENCE_CHANGES_H
#define ASSAY_STATE_RESOURCES_REFERENCE_CHANGES_H

#include "src/state/resources/resources.h"

/* A value, and what it refers to now. */
struct reference_change {
    uint64_t reference;
    uint64_t id;  /* the structure; 0: several structures, or one of VK_NV_ray_tracing */
    bool is_nv;   /* returned by vkGetAccelerationStructureHandleNV; else a device address */
    bool is_live; /* an instance may refer to it: a structure that is alive, may be a bottom-level
                     one, and is not known to lack memory */
};

/* Which values are valid without being known: all device addresses, all values of
 * VK_NV_ray_tracing. */
struct unknown_references {
    bool khr, nv;
};

/* Begins to note changes. Call before the first structure is created. */
void resources_watch_references(struct resources *resources);

/* Returns the values that changed since the last call, and forgets them. The caller frees
 * *changes. */
uint32_t resources_take_reference_changes(struct resources *resources,
                                          struct reference_change **changes,
                                          struct unknown_references *unknown);

#endif
