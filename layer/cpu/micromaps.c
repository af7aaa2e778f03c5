/* SPDX-License-Identifier: Apache-2.0 */
/* Backend cpu: micromaps of VK_EXT_opacity_micromap. A micromap is a structure with a
 * type of its own. It lies in the table of structures, and is built and copied like a structure. */
#include <stdlib.h>

#include "layer/cpu/overlay.h"
#include "layer/snapshots/recorder.h"
#include "observers.h"
#include "src/base/readable.h"
#include "src/cpu/host.h"
#include "src/model/build_parameters.h"
#include "src/snapshots/build_input.h"
#include "src/state/facts.h"

/* Builds of both types use the same builder. */
void cpu_get_micromap_sizes(const VkMicromapBuildInfoEXT *info, VkMicromapBuildSizesInfoEXT *out)
{
    struct readable_cache cache = {0};
    struct build_parameters build;
    struct builder_sizes sizes = {0};
    if (micromap_info_copy(&cache, info, &build) == VK_SUCCESS) {
        build_parameters_sizes(&build, NULL, &sizes);
        build_parameters_release(&build);
    }
    out->micromapSize = sizes.structure;
    out->buildScratchSize = 0;
    out->discardable = VK_FALSE; /* rays read the micromaps to which structures refer */
}

/* ---- copies, as those of structures */

VkResult cpu_copy_micromap_on_host(struct cpu_device *backend, VkDeferredOperationKHR operation,
                                   const VkCopyMicromapInfoEXT *info)
{
    return cpu_host_copy(backend, (uint64_t)operation,
                         &(VkCopyAccelerationStructureInfoKHR){
                             .sType = VK_STRUCTURE_TYPE_COPY_ACCELERATION_STRUCTURE_INFO_KHR,
                             .src = (VkAccelerationStructureKHR)info->src,
                             .dst = (VkAccelerationStructureKHR)info->dst,
                             .mode = copy_mode_of_micromap(info->mode),
                         });
}

VkResult cpu_write_micromap_on_host(struct cpu_device *backend, VkDeferredOperationKHR operation,
                                    const VkCopyMicromapToMemoryInfoEXT *info)
{
    return cpu_host_serialize(
        backend, (uint64_t)operation,
        &(VkCopyAccelerationStructureToMemoryInfoKHR){
            .sType = VK_STRUCTURE_TYPE_COPY_ACCELERATION_STRUCTURE_TO_MEMORY_INFO_KHR,
            .src = (VkAccelerationStructureKHR)info->src,
            .dst = info->dst,
            .mode = copy_mode_of_micromap(info->mode),
        });
}

VkResult cpu_read_micromap_on_host(struct cpu_device *backend, VkDeferredOperationKHR operation,
                                   const VkCopyMemoryToMicromapInfoEXT *info)
{
    return cpu_host_deserialize(
        backend, (uint64_t)operation,
        &(VkCopyMemoryToAccelerationStructureInfoKHR){
            .sType = VK_STRUCTURE_TYPE_COPY_MEMORY_TO_ACCELERATION_STRUCTURE_INFO_KHR,
            .src = info->src,
            .dst = (VkAccelerationStructureKHR)info->dst,
            .mode = copy_mode_of_micromap(info->mode),
        });
}

/* ---- in command buffers */

static struct recorded_build *copy_parameters(struct recorder *recorder,
                                              const VkMicromapBuildInfoEXT *info)
{
    struct recorded_build *build = calloc(1, sizeof(*build));
    VkResult result = VK_ERROR_OUT_OF_HOST_MEMORY;
    if (build)
        result = micromap_info_copy(readable_cache_of_thread(), info, &build->parameters);
    if (result == VK_SUCCESS)
        return build;
    if (result == VK_ERROR_OUT_OF_HOST_MEMORY)
        recorder_fail(recorder);
    free(build);
    return NULL;
}

void cpu_build_micromaps(VkCommandBuffer commands, uint32_t count,
                         const VkMicromapBuildInfoEXT *infos)
{
    struct recorder recorder;
    if (!recorder_begin(&recorder, commands))
        return;
    for (uint32_t i = 0; i < count; i++) {
        struct recorded_build *build = copy_parameters(&recorder, &infos[i]);
        if (!build)
            continue;
        build->place = recorded_place_of_micromap(i);
        recorder_add_build(&recorder, build);
    }
    recorder_end(&recorder);
}

void cpu_copy_micromap(VkCommandBuffer commands, const VkCopyMicromapInfoEXT *info)
{
    cpu_copy_structure(commands, (uint64_t)info->dst, (uint64_t)info->src,
                       copy_mode_of_micromap(info->mode));
}
