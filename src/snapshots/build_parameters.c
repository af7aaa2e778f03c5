/* SPDX-License-Identifier: Apache-2.0 */
/* Copies the parameters of builds. */
#include "src/snapshots/build_parameters.h"

#include <stdlib.h>
#include <string.h>

bool geometry_takes_range(const VkAccelerationStructureGeometryKHR *geometry)
{
    return !geometry_is_dense(geometry) &&
           (int)geometry->geometryType != VK_GEOMETRY_TYPE_MICROMAP_KHR;
}

/* ---- copies */

/* Probes the arrays before memory is allocated for them, because a count may be wrong. */
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

VkResult build_parameters_allocate(struct build_parameters *build, uint32_t count)
{
    build->info.geometryCount = count;
    if (count == 0)
        return VK_SUCCESS;
    build->geometries = calloc(count, sizeof(*build->geometries) + sizeof(*build->ranges));
    if (!build->geometries)
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    build->ranges = (VkAccelerationStructureBuildRangeInfoKHR *)(build->geometries + count);
    build->info.pGeometries = build->geometries;
    return VK_SUCCESS;
}

/* Copies by memcpy, because the application's memory may be misaligned. */
static bool copy_arrays(struct readable_cache *cache,
                        const VkAccelerationStructureBuildGeometryInfoKHR *info,
                        const VkAccelerationStructureBuildRangeInfoKHR *ranges,
                        struct build_parameters *copy)
{
    for (uint32_t i = 0; i < info->geometryCount; i++) {
        const VkAccelerationStructureGeometryKHR *from;
        if (info->pGeometries) {
            from = &info->pGeometries[i];
        } else {
            memcpy(&from, &info->ppGeometries[i], sizeof(from));
            if (!readable(cache, from, sizeof(*from)))
                return false;
        }
        memcpy(&copy->geometries[i], from, sizeof(*from));
        if (ranges)
            memcpy(&copy->ranges[i], &ranges[i], sizeof(*ranges));
    }
    return true;
}

/* Dense geometry carries its own triangle count, and takes no range. */
static void count_dense_triangles(struct build_parameters *copy)
{
    for (uint32_t i = 0; copy->chained && i < copy->info.geometryCount; i++)
        if (geometry_is_dense(&copy->geometries[i]))
            copy->ranges[i] = (VkAccelerationStructureBuildRangeInfoKHR){
                .primitiveCount = copy->chained[i].dense.numTriangles};
}

/* Clears pNext. Each member of the union begins with sType and pNext. */
static void forget_chains(struct build_parameters *copy)
{
    for (uint32_t i = 0; i < copy->info.geometryCount; i++) {
        VkAccelerationStructureGeometryKHR *geometry = &copy->geometries[i];
        copy->had_chains |= geometry->pNext || geometry->geometry.triangles.pNext;
        geometry->pNext = NULL;
        geometry->geometry.triangles.pNext = NULL;
    }
}

VkResult build_parameters_copy(struct readable_cache *cache,
                               const VkAccelerationStructureBuildGeometryInfoKHR *from,
                               const VkAccelerationStructureBuildRangeInfoKHR *ranges,
                               struct build_parameters *copy)
{
    *copy = (struct build_parameters){0};
    if (!readable(cache, from, sizeof(*from)))
        return VK_ERROR_VALIDATION_FAILED;
    VkAccelerationStructureBuildGeometryInfoKHR own, *info = &own;
    memcpy(info, from, sizeof(*info));
    copy->info = *info;
    copy->info.pNext = NULL;
    copy->had_chains = info->pNext != NULL;
    if (info->geometryCount == 0)
        return VK_SUCCESS;
    if (!arrays_are_readable(cache, info, ranges))
        return VK_ERROR_VALIDATION_FAILED;
    if (build_parameters_allocate(copy, info->geometryCount) != VK_SUCCESS)
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    copy->info.ppGeometries = NULL;
    VkResult result = VK_ERROR_VALIDATION_FAILED;
    if (copy_arrays(cache, info, ranges, copy))
        result = chained_inputs_copy(cache, &copy->info, &copy->chained);
    forget_chains(copy);
    count_dense_triangles(copy);
    if (result != VK_SUCCESS)
        build_parameters_release(copy);
    return result;
}

void build_parameters_release(struct build_parameters *copy)
{
    chained_inputs_free(copy->chained, copy->info.geometryCount);
    free(copy->geometries);
    *copy = (struct build_parameters){0};
}

bool build_parameters_take_ranges(const struct build_parameters *build)
{
    for (uint32_t i = 0; i < build->info.geometryCount; i++)
        if (geometry_takes_range(&build->geometries[i]))
            return true;
    return false;
}
