/* SPDX-License-Identifier: Apache-2.0 */
/* Guarded copies of the instances of builds. */
#ifndef ASSAY_LAYER_SNAPSHOTS_GUARD_COPIES_H
#define ASSAY_LAYER_SNAPSHOTS_GUARD_COPIES_H

#include "layer/snapshots/recorder.h"

/* What a guarded build reads in place of the application's data. */
struct guarded_copy {
    VkDeviceAddress data; /* instances, or pointers to them if the build has pointers; operations */
    VkDeviceAddress range; /* of an indirect build; the number of operations */
    VkBuffer buffer;       /* of VK_NV_ray_tracing: instances at the offset */
    VkDeviceSize offset;
};

/* Gives back the memory of a recording's copies. */
struct guard;
void guard_free_copies(const struct guard *guard, struct snapshot_chunk *copies);

/* ---- The parameters with which guarded builds go down: the application's, except that instances
 * are read from guarded copies. The application's structures stay as they are. */

/* The guarded builds of one call. Zero-initialized is empty. */
struct guard_call {
    struct guarded_build {
        uint32_t info; /* index in pInfos */
        struct guarded_copy copy;
    } * builds;
    uint32_t count, capacity;
    void *parameters;   /* owned */
    VkBuffer instances; /* of vkCmdBuildAccelerationStructureNV */
    VkDeviceSize offset;
};

/* Guards a build of the call if possible: of a top-level or a partitioned structure. `call` may be
 * NULL. */
void guard_call_add(struct guard_call *call, struct recorder *recorder,
                    struct recorded_build *build);
/* Called after the last build. */
void guard_call_end(struct guard_call *call, const struct recorder *recorder);

/* Replace the arrays by ones that live until guard_call_release(). */
void guard_call_direct(struct guard_call *call, uint32_t count,
                       const VkAccelerationStructureBuildGeometryInfoKHR **infos,
                       const VkAccelerationStructureBuildRangeInfoKHR *const **ranges);
void guard_call_indirect(struct guard_call *call, uint32_t count,
                         const VkAccelerationStructureBuildGeometryInfoKHR **infos,
                         const VkDeviceAddress **addresses);
void guard_call_release(struct guard_call *call);

#endif
