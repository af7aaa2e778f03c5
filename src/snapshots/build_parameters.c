/* SPDX-License-Identifier: Apache-2.0 */
/* Parameters of builds: copies of them, and the sizes that follow from them. */
#include "snapshots/build_parameters.h"

#include <stdlib.h>

#include "snapshots/build_input.h"

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

static bool copy_arrays(struct readable_cache *cache,
                        const VkAccelerationStructureBuildGeometryInfoKHR *info,
                        const VkAccelerationStructureBuildRangeInfoKHR *ranges,
                        struct build_parameters *copy)
{
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

/* Chains longer than this are cyclic, or nobody's. */
enum { CHAIN_MAX = 64 };

/* NULL: the chain has none. False where it can't be read. */
static bool find_motion(struct readable_cache *cache, const void *chain,
                        const VkAccelerationStructureGeometryMotionTrianglesDataNV **motion)
{
    const VkBaseInStructure *s = chain;
    *motion = NULL;
    for (int i = 0; s && i < CHAIN_MAX; s = s->pNext, i++) {
        if (!readable(cache, s, sizeof(*s)))
            return false;
        if (s->sType != VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_MOTION_TRIANGLES_DATA_NV)
            continue;
        *motion = (const void *)s;
        return readable(cache, *motion, sizeof(**motion));
    }
    return !s;
}

static VkResult copy_motion(struct readable_cache *cache, struct build_parameters *copy)
{
    if (!(copy->info.flags & VK_BUILD_ACCELERATION_STRUCTURE_MOTION_BIT_NV))
        return VK_SUCCESS;
    for (uint32_t i = 0; i < copy->info.geometryCount; i++) {
        const VkAccelerationStructureGeometryMotionTrianglesDataNV *motion;
        if (copy->geometries[i].geometryType != VK_GEOMETRY_TYPE_TRIANGLES_KHR)
            continue;
        if (!find_motion(cache, copy->geometries[i].geometry.triangles.pNext, &motion))
            return VK_ERROR_VALIDATION_FAILED;
        if (!motion)
            continue;
        if (!copy->motion_vertices)
            copy->motion_vertices =
                calloc(copy->info.geometryCount, sizeof(*copy->motion_vertices));
        if (!copy->motion_vertices)
            return VK_ERROR_OUT_OF_HOST_MEMORY;
        copy->motion_vertices[i] = motion->vertexData;
    }
    return VK_SUCCESS;
}

VkResult build_parameters_copy(struct readable_cache *cache,
                               const VkAccelerationStructureBuildGeometryInfoKHR *info,
                               const VkAccelerationStructureBuildRangeInfoKHR *ranges,
                               struct build_parameters *copy)
{
    *copy = (struct build_parameters){0};
    if (!readable(cache, info, sizeof(*info)))
        return VK_ERROR_VALIDATION_FAILED;
    copy->info = *info;
    copy->info.pNext = NULL;
    if (info->geometryCount == 0)
        return VK_SUCCESS;
    if (!arrays_are_readable(cache, info, ranges))
        return VK_ERROR_VALIDATION_FAILED;
    if (build_parameters_allocate(copy, info->geometryCount) != VK_SUCCESS)
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    copy->info.ppGeometries = NULL;
    VkResult result = VK_ERROR_VALIDATION_FAILED;
    if (copy_arrays(cache, info, ranges, copy))
        result = copy_motion(cache, copy);
    if (result != VK_SUCCESS)
        build_parameters_release(copy);
    return result;
}

void build_parameters_release(struct build_parameters *copy)
{
    free(copy->geometries);
    free(copy->motion_vertices);
    *copy = (struct build_parameters){0};
}

/* ---- sizes */

static uint64_t find_nothing(void *context, uint64_t address, uint64_t size, const void **bytes)
{
    (void)context;
    (void)address;
    (void)size;
    *bytes = NULL;
    return 0;
}

VkResult build_parameters_sizes(const struct build_parameters *build, const uint32_t *counts,
                                struct builder_sizes *sizes)
{
    const struct input_memory nothing = {find_nothing, NULL};
    struct build_input input;
    *sizes = (struct builder_sizes){0};
    VkResult result = build_input_open(build, &nothing, &input);
    if (result == VK_SUCCESS)
        builder_get_sizes(&input.input, counts, sizes);
    build_input_close(&input);
    return result;
}

void cpu_build_sizes(const VkAccelerationStructureBuildGeometryInfoKHR *info,
                     const uint32_t *counts, struct builder_sizes *sizes)
{
    *sizes = (struct builder_sizes){0};
    struct readable_cache cache = {0};
    struct build_parameters build;
    if (build_parameters_copy(&cache, info, NULL, &build) != VK_SUCCESS)
        return;
    if (readable(&cache, counts, sizeof(*counts) * (size_t)build.info.geometryCount))
        build_parameters_sizes(&build, counts, sizes);
    build_parameters_release(&build);
}
