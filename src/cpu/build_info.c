/* SPDX-License-Identifier: Apache-2.0 */
/* Parameters of builds: copies of them, and the sizes that follow from them. */
#include "cpu/build_info.h"

#include <stdlib.h>

#include "cpu/input.h"

/* ---- copies */

/* Before memory is taken for them: a count may be wild. */
static bool arrays_are_readable(struct readable_cache *cache,
                                const VkAccelerationStructureBuildGeometryInfoKHR *info,
                                const VkAccelerationStructureBuildRangeInfoKHR *ranges)
{
    size_t count = info->geometryCount;
    bool has_geometries =
        info->pGeometries
            ? readable(cache, info->pGeometries, count * sizeof(*info->pGeometries))
            : readable(cache, info->ppGeometries, count * sizeof(*info->ppGeometries));
    return has_geometries && (!ranges || readable(cache, ranges, count * sizeof(*ranges)));
}

static bool copy_arrays(struct readable_cache *cache,
                        const VkAccelerationStructureBuildRangeInfoKHR *ranges,
                        struct cpu_build_info *copy)
{
    const VkAccelerationStructureBuildGeometryInfoKHR *info = &copy->info;
    for (uint32_t i = 0; i < info->geometryCount; i++) {
        const VkAccelerationStructureGeometryKHR *from =
            info->pGeometries ? &info->pGeometries[i] : info->ppGeometries[i];
        if (!info->pGeometries && !readable(cache, from, sizeof(*from)))
            return false;
        copy->geometries[i] = *from;
        copy->geometries[i].pNext = NULL;
        if (ranges)
            copy->ranges[i] = ranges[i];
    }
    return true;
}

VkResult cpu_build_info_copy(struct readable_cache *cache,
                             const VkAccelerationStructureBuildGeometryInfoKHR *info,
                             const VkAccelerationStructureBuildRangeInfoKHR *ranges,
                             struct cpu_build_info *copy)
{
    *copy = (struct cpu_build_info){0};
    if (!readable(cache, info, sizeof(*info)))
        return VK_ERROR_VALIDATION_FAILED;
    copy->info = *info;
    copy->info.pNext = NULL;
    uint32_t count = info->geometryCount;
    if (count == 0)
        return VK_SUCCESS;
    if (!arrays_are_readable(cache, info, ranges))
        return VK_ERROR_VALIDATION_FAILED;
    copy->geometries = calloc(count, sizeof(*copy->geometries) + sizeof(*copy->ranges));
    if (!copy->geometries)
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    copy->ranges = (VkAccelerationStructureBuildRangeInfoKHR *)(copy->geometries + count);
    if (!copy_arrays(cache, ranges, copy)) {
        cpu_build_info_release(copy);
        return VK_ERROR_VALIDATION_FAILED;
    }
    copy->info.pGeometries = copy->geometries;
    copy->info.ppGeometries = NULL;
    return VK_SUCCESS;
}

void cpu_build_info_release(struct cpu_build_info *copy)
{
    free(copy->geometries);
    *copy = (struct cpu_build_info){0};
}

/* ---- sizes */

void cpu_build_sizes(const VkAccelerationStructureBuildGeometryInfoKHR *info,
                     const uint32_t *counts, struct builder_sizes *sizes)
{
    *sizes = (struct builder_sizes){0};
    struct readable_cache cache = {0};
    struct cpu_build_info build;
    if (cpu_build_info_copy(&cache, info, NULL, &build) != VK_SUCCESS)
        return;
    uint32_t count = build.info.geometryCount;
    struct cpu_input input = {0};
    struct cpu_memory nothing = {0};
    if (readable(&cache, counts, sizeof(*counts) * (size_t)count) &&
        cpu_input_open(&build, &nothing, &input) == VK_SUCCESS)
        builder_get_sizes(&input.input, counts, sizes);
    cpu_input_close(&input);
    cpu_build_info_release(&build);
}
