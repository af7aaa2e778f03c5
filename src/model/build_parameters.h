/* SPDX-License-Identifier: Apache-2.0 */
/* A copy of the parameters of one build, which outlives the call. */
#ifndef ASSAY_MODEL_BUILD_PARAMETERS_H
#define ASSAY_MODEL_BUILD_PARAMETERS_H

#include <vulkan/vulkan_core.h>

#include "src/base/readable.h"
#include "src/model/chained_input.h"
#include "src/model/geometry.h"
#include "src/model/inputs.h"

/* pNext of info, geometries and their data is NULL; `chained` has the contents of the chains.
 * ppGeometries is resolved to pGeometries. */
struct build_parameters {
    VkAccelerationStructureBuildGeometryInfoKHR info;
    bool had_chains;                                  /* the application gave any pNext */
    VkAccelerationStructureGeometryKHR *geometries;   /* info.pGeometries; owned */
    VkAccelerationStructureBuildRangeInfoKHR *ranges; /* one per geometry; in the same block */
    struct chained_input *chained; /* one per geometry; owned; NULL: no chained input */
};

/* Whether any geometry takes a range, and a size query a primitive count. */
bool build_parameters_take_ranges(const struct build_parameters *build);

/* Returns VK_ERROR_VALIDATION_FAILED if a parameter can't be read. If `ranges` is NULL, the ranges
 * are zeros that the caller fills in. */
VkResult build_parameters_copy(struct readable_cache *cache,
                               const VkAccelerationStructureBuildGeometryInfoKHR *info,
                               const VkAccelerationStructureBuildRangeInfoKHR *ranges,
                               struct build_parameters *copy);
void build_parameters_release(struct build_parameters *copy);

/* Allocates `count` geometries and ranges, in parameters that have none. */
VkResult build_parameters_allocate(struct build_parameters *build, uint32_t count);

/* ---- Translates parameters of VK_NV_ray_tracing to the equivalent parameters of
 * VK_KHR_acceleration_structure. */

/* VK_NV_ray_tracing names data by buffer and offset. */
struct nv_place {
    VkBuffer buffer;
    VkDeviceSize offset;
};

/* The places of a geometry's inputs, by their roles. Zeros if the geometry lacks the input. */
enum { NV_PLACES = INPUT_LAST_PLAIN + 1 };
void nv_places_of(const VkGeometryNV *geometry, struct nv_place places[NV_PLACES]);

/* The data that the parameters read. `find` returns a number that stands for a place, instead of a
 * device address; it is not 0, because 0 stands for no address. NULL: 1 stands for each place. */
struct nv_data {
    uint64_t (*find)(void *context, VkBuffer buffer, VkDeviceSize offset);
    void *context;
    struct nv_place instances; /* of a top-level structure */
};

/* `data` may be NULL if only sizes are needed. Fails as build_parameters_copy() does. */
VkResult nv_info_copy(struct readable_cache *cache, const VkAccelerationStructureInfoNV *info,
                      const struct nv_data *data, struct build_parameters *copy);

/* ---- Translates parameters of VK_EXT_opacity_micromap to the equivalent parameters of
 * VK_KHR_acceleration_structure: a micromap is a structure with a type of its own. */

/* Fails as build_parameters_copy() does. */
VkResult micromap_info_copy(struct readable_cache *cache, const VkMicromapBuildInfoEXT *info,
                            struct build_parameters *copy);

#endif
