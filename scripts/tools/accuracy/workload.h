/* SPDX-License-Identifier: Apache-2.0 */
/* Scenes as applications build them, in a world with the layer or without. */
#ifndef ASSAY_TOOLS_ACCURACY_WORKLOAD_H
#define ASSAY_TOOLS_ACCURACY_WORKLOAD_H

#include "tests/rules/scene/scene.h"

enum workload_kind {
    WORKLOAD_MESH,      /* one BLAS, of 70,000 triangles: as large as the bunny */
    WORKLOAD_SMALL,     /* 1,000 BLAS of 12 triangles in one call */
    WORKLOAD_INSTANCES, /* one TLAS of 100,000 instances */
    WORKLOAD_KINDS,
};

extern const char *const workload_names[WORKLOAD_KINDS];

struct workload {
    struct scene *scene; /* the caller's; owns all objects but the structures */
    uint32_t count;      /* of builds, all in one call */
    VkAccelerationStructureBuildGeometryInfoKHR *infos;
    VkAccelerationStructureGeometryKHR *geometries;
    VkAccelerationStructureBuildRangeInfoKHR *ranges;
    const VkAccelerationStructureBuildRangeInfoKHR **range_pointers;
    uint32_t family;
    VkCommandBuffer command_buffer;
};

/* By the command of the scene, the device's or the host's. `is_quick`: a hundredth of the size. */
void workload_open(struct workload *workload, struct scene *scene, enum workload_kind kind,
                   bool is_quick);
void workload_close(struct workload *workload);

/* Records the call, submits it and waits; or calls the host's command. */
void workload_run(const struct workload *workload);

#endif
