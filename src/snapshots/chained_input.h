/* SPDX-License-Identifier: Apache-2.0 */
/* What extensions chain to the geometries of a build, copied. */
#ifndef ASSAY_SNAPSHOTS_CHAINED_INPUT_H
#define ASSAY_SNAPSHOTS_CHAINED_INPUT_H

#include <stdbool.h>
#include <vulkan/vulkan.h>
#include <vulkan/vulkan_beta.h>

#include "src/base/readable.h"

/* VkAccelerationStructureGeometryMicromapDataKHR or VkMicromapBuildInfoEXT. */
struct micromap_parameters {
    VkMicromapTypeEXT type;
    uint32_t usage_count;
    VkMicromapUsageEXT *usages; /* owned */
    VkDeviceOrHostAddressConstKHR data, triangles;
    uint64_t stride;
};

/* Of one geometry. pNext and usages are NULL everywhere; zeros for what its chain hasn't got. */
struct chained_input {
    VkDeviceOrHostAddressConstKHR motion_vertices;                   /* 0: it doesn't move */
    VkAccelerationStructureGeometryLinearSweptSpheresDataNV spheres; /* swept or not */
    VkAccelerationStructureDenseGeometryFormatTrianglesDataAMDX dense;
    bool has_opacity;
    VkAccelerationStructureTrianglesOpacityMicromapEXT opacity; /* its micromap a ...-KHR's, too */
    struct micromap_parameters micromap;                        /* of triangles only usages, of: */
    bool has_displacement;
    VkAccelerationStructureTrianglesDisplacementMicromapNV displacement;
};

/* One a geometry of `info`, whose geometries are in pGeometries and can be read; NULL where none
 * has any. VK_ERROR_VALIDATION_FAILED where a chain can't be read. */
VkResult chained_inputs_copy(struct readable_cache *cache,
                             const VkAccelerationStructureBuildGeometryInfoKHR *info,
                             struct chained_input **chained);
void chained_inputs_free(struct chained_input *chained, uint32_t count); /* NULL: nothing */

/* The usages of a micromap, of -EXT or -KHR, in an array or behind an array of pointers. What is
 * copied when it fails is the caller's to free, too. */
VkResult micromap_usages_copy(struct readable_cache *cache, uint32_t count, const void *usages,
                              const void *pointers, struct micromap_parameters *copy);

#endif
