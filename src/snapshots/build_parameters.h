/* SPDX-License-Identifier: Apache-2.0 */
/* The parameters of one build, copied, so that they can be used after the call. */
#ifndef ASSAY_SNAPSHOTS_BUILD_PARAMETERS_H
#define ASSAY_SNAPSHOTS_BUILD_PARAMETERS_H

#include <vulkan/vulkan_core.h>

#include "src/base/readable.h"
#include "src/bvh/bvh.h"
#include "src/snapshots/chained_input.h"
#include "src/state/builds/build_info.h"

/* pNext of info, geometries and their data is NULL, for what chains say is in members of its own;
 * ppGeometries is resolved to pGeometries. */
struct build_parameters {
    VkAccelerationStructureBuildGeometryInfoKHR info;
    bool had_chains;                                  /* any pNext was given */
    VkAccelerationStructureGeometryKHR *geometries;   /* info.pGeometries; owned */
    VkAccelerationStructureBuildRangeInfoKHR *ranges; /* one a geometry; in the same block */
    struct chained_input *chained; /* one a geometry; owned; NULL: no geometry has any */
};

/* Whether any geometry takes a range, and sizes a count. */
bool build_parameters_take_ranges(const struct build_parameters *build);

/* Those that don't say themselves how much they have. */
bool geometry_takes_range(const VkAccelerationStructureGeometryKHR *geometry);

/* VK_ERROR_VALIDATION_FAILED where a parameter can't be read. `ranges` may be NULL: zeros, for the
 * caller to fill in. */
VkResult build_parameters_copy(struct readable_cache *cache,
                               const VkAccelerationStructureBuildGeometryInfoKHR *info,
                               const VkAccelerationStructureBuildRangeInfoKHR *ranges,
                               struct build_parameters *copy);
void build_parameters_release(struct build_parameters *copy);

/* Room for that many geometries and their ranges, in parameters that have none. */
VkResult build_parameters_allocate(struct build_parameters *build, uint32_t count);

#endif
