/* SPDX-License-Identifier: Apache-2.0 */
/* Guarded copies of the instances of builds. */
#ifndef ASSAY_LAYER_SNAPSHOTS_GUARD_COPIES_H
#define ASSAY_LAYER_SNAPSHOTS_GUARD_COPIES_H

#include "layer/snapshots/recorder.h"

/* What a guarded build reads in place of the application's data. */
struct guarded_copy {
    VkDeviceAddress data;  /* instances, or pointers to them if the build has pointers */
    VkDeviceAddress range; /* of an indirect build */
    VkBuffer buffer;       /* of VK_NV_ray_tracing: instances at the offset */
    VkDeviceSize offset;
};

/* Records a copy of a build's instances that guard.comp writes. Returns false if the build has no
 * instances, or goes down unguarded. For vkCmdBuildAccelerationStructureNV, `instances` is the
 * application's buffer at that offset; else VK_NULL_HANDLE. */
bool guard_copy(struct recorder *recorder, struct recorded_build *build, VkBuffer instances,
                VkDeviceSize offset, struct guarded_copy *copy);

/* Makes the copies in the buffer of `copy` visible to the builds of the command. Called after the
 * last copy. */
void guard_end_copy(const struct recorder *recorder, const struct guarded_copy *copy);

/* Gives back the memory of a recording's copies. */
struct guard;
void guard_free_copies(const struct guard *guard, struct snapshot_chunk *copies);

#endif
