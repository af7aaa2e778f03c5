/* SPDX-License-Identifier: Apache-2.0 */
/* Copies of what extensions chain to the geometries of a build. */
#ifndef ASSAY_MODEL_CHAINED_INPUT_H
#define ASSAY_MODEL_CHAINED_INPUT_H

#include <stdbool.h>
#include <vulkan/vulkan.h>
#include <vulkan/vulkan_beta.h>

#include "src/base/readable.h"

/* Parameters from VkAccelerationStructureGeometryMicromapDataKHR or VkMicromapBuildInfoEXT. */
struct micromap_parameters {
    VkMicromapTypeEXT type;
    uint32_t usage_count;
    VkMicromapUsageEXT *usages; /* owned */
    bool is_khr;                /* the addresses are of the device, in builds of the host, too */
    VkDeviceOrHostAddressConstKHR data, triangles;
    uint64_t stride;
};

/* Returns the sum of the usage counts, and the size in bytes of as many triangles with their
 * stride; 0 if it overflows. */
uint64_t micromap_parameters_count(const struct micromap_parameters *micromap);
uint64_t micromap_parameters_extent(const struct micromap_parameters *micromap);

/* The chained input of one geometry. pNext and usages are NULL everywhere. Members are zero if the
 * chain lacks their structure. */
struct chained_input {
    VkDeviceOrHostAddressConstKHR motion_vertices;                   /* 0: no motion */
    VkAccelerationStructureGeometryLinearSweptSpheresDataNV spheres; /* linear swept or not */
    VkAccelerationStructureDenseGeometryFormatTrianglesDataAMDX dense;
    bool has_opacity;
    VkAccelerationStructureTrianglesOpacityMicromapEXT opacity; /* of -EXT or -KHR */
    struct micromap_parameters micromap;                        /* triangles have only its usages */
    bool has_displacement;
    VkAccelerationStructureTrianglesDisplacementMicromapNV displacement;
};

/* Returns spheres as linear swept ones, which have all of their members, without a chain. */
VkAccelerationStructureGeometryLinearSweptSpheresDataNV
spheres_as_swept(const VkAccelerationStructureGeometrySpheresDataNV *spheres);

/* Reads the chain of one geometry of a build with these flags into zeros. Usages of micromaps
 * remain the application's and those of a micromap's own build are left out. Returns false if the
 * chain can't be read. */
bool chained_input_read(struct readable_cache *cache, VkBuildAccelerationStructureFlagsKHR flags,
                        const VkAccelerationStructureGeometryKHR *geometry,
                        struct chained_input *chained);

/* Also copies the usages and the parameters of a micromap's own build. The caller frees
 * micromap.usages, also after a failure. */
VkResult chained_input_copy(struct readable_cache *cache,
                            VkBuildAccelerationStructureFlagsKHR flags,
                            const VkAccelerationStructureGeometryKHR *geometry,
                            struct chained_input *chained);

/* Allocates one for each geometry of `info`, whose geometries are in pGeometries and readable; NULL
 * if no geometry has any. Returns VK_ERROR_VALIDATION_FAILED if a chain can't be read. */
VkResult chained_inputs_copy(struct readable_cache *cache,
                             const VkAccelerationStructureBuildGeometryInfoKHR *info,
                             struct chained_input **chained);
void chained_inputs_free(struct chained_input *chained, uint32_t count); /* accepts NULL */

/* Copies the usages of a micromap, of -EXT or -KHR, from an array or an array of pointers. After a
 * failure the caller frees what was copied, too. */
VkResult micromap_usages_copy(struct readable_cache *cache, uint32_t count, const void *usages,
                              const void *pointers, struct micromap_parameters *copy);

#endif
