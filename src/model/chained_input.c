/* SPDX-License-Identifier: Apache-2.0 */
/* Reads the chains of geometries. Most geometries have no chain. */
#include "src/model/chained_input.h"

#include <stdlib.h>
#include <string.h>

#include "src/model/geometry.h"

/* Longer chains are considered cyclic or corrupt. */
enum { CHAIN_MAX = 64 };

/* Copies the first structure of a type. All of its `size` bytes must be readable; it may be
 * misaligned. The copy's sType is 0 if the chain lacks the structure. Returns false if it can't be
 * read. */
static bool find_in_chain(struct readable_cache *cache, const void *chain, VkStructureType type,
                          size_t size, void *found)
{
    VkBaseInStructure base;
    memset(found, 0, size);
    for (int i = 0; chain && i < CHAIN_MAX; chain = base.pNext, i++) {
        if (!readable(cache, chain, sizeof(base)))
            return false;
        memcpy(&base, chain, sizeof(base));
        if (base.sType != type)
            continue;
        if (!readable(cache, chain, size))
            return false;
        memcpy(found, chain, size);
        return true;
    }
    return !chain;
}

/* ---- one function for each kind of chained structure; each returns true if it is absent */

static bool copy_motion(struct readable_cache *cache,
                        const VkAccelerationStructureGeometryKHR *geometry,
                        struct chained_input *copy)
{
    VkAccelerationStructureGeometryMotionTrianglesDataNV motion;
    if (!find_in_chain(cache, geometry->geometry.triangles.pNext,
                       VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_MOTION_TRIANGLES_DATA_NV,
                       sizeof(motion), &motion))
        return false;
    if (motion.sType)
        copy->motion_vertices = motion.vertexData;
    return true;
}

static bool copy_opacity(struct readable_cache *cache, const void *chain,
                         struct chained_input *copy)
{
    VkAccelerationStructureTrianglesOpacityMicromapEXT ext;
    VkAccelerationStructureTrianglesOpacityMicromapKHR khr;
    if (!find_in_chain(cache, chain,
                       VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_TRIANGLES_OPACITY_MICROMAP_EXT,
                       sizeof(ext), &ext) ||
        !find_in_chain(cache, chain,
                       VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_TRIANGLES_OPACITY_MICROMAP_KHR,
                       sizeof(khr), &khr))
        return false;
    copy->has_opacity = ext.sType || khr.sType;
#define MEMBERS(s)                                                                                 \
    .sType = (s).sType, .indexType = (s).indexType, .indexStride = (s).indexStride,                \
    .baseTriangle = (s).baseTriangle, .micromap = (VkMicromapEXT)(s).micromap
    if (khr.sType)
        copy->opacity = (VkAccelerationStructureTrianglesOpacityMicromapEXT){
            MEMBERS(khr), .indexBuffer.deviceAddress = khr.indexBuffer};
    else if (ext.sType)
        copy->opacity = (VkAccelerationStructureTrianglesOpacityMicromapEXT){
            MEMBERS(ext), .indexBuffer = ext.indexBuffer};
#undef MEMBERS
    return true;
}

VkAccelerationStructureGeometryLinearSweptSpheresDataNV
spheres_as_swept(const VkAccelerationStructureGeometrySpheresDataNV *spheres)
{
    return (VkAccelerationStructureGeometryLinearSweptSpheresDataNV){
        .sType = spheres->sType,
        .vertexFormat = spheres->vertexFormat,
        .vertexData = spheres->vertexData,
        .vertexStride = spheres->vertexStride,
        .radiusFormat = spheres->radiusFormat,
        .radiusData = spheres->radiusData,
        .radiusStride = spheres->radiusStride,
        .indexType = spheres->indexType,
        .indexData = spheres->indexData,
        .indexStride = spheres->indexStride,
    };
}

static bool copy_spheres(struct readable_cache *cache, const void *chain,
                         struct chained_input *copy)
{
    VkAccelerationStructureGeometrySpheresDataNV s;
    if (!find_in_chain(cache, chain,
                       VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_SPHERES_DATA_NV, sizeof(s),
                       &s))
        return false;
    if (s.sType)
        copy->spheres = spheres_as_swept(&s);
    return true;
}

static bool copy_swept_spheres(struct readable_cache *cache, const void *chain,
                               struct chained_input *copy)
{
    VkAccelerationStructureGeometryLinearSweptSpheresDataNV s;
    if (!find_in_chain(
            cache, chain,
            VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_LINEAR_SWEPT_SPHERES_DATA_NV,
            sizeof(s), &s))
        return false;
    if (s.sType)
        copy->spheres = s;
    copy->spheres.pNext = NULL;
    return true;
}

static bool copy_dense(struct readable_cache *cache, const void *chain, struct chained_input *copy)
{
    VkAccelerationStructureDenseGeometryFormatTrianglesDataAMDX s;
    if (!find_in_chain(
            cache, chain,
            VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_DENSE_GEOMETRY_FORMAT_TRIANGLES_DATA_AMDX,
            sizeof(s), &s))
        return false;
    if (!s.sType)
        return true;
    copy->dense = s;
    copy->dense.pNext = NULL;
    return copy_opacity(cache, s.pNext, copy);
}

/* ---- micromaps */

_Static_assert(sizeof(VkMicromapUsageEXT) == sizeof(VkMicromapUsageKHR), "laid out alike");

VkResult micromap_usages_copy(struct readable_cache *cache, uint32_t count, const void *usages,
                              const void *pointers, struct micromap_parameters *copy)
{
    const size_t size = sizeof(*copy->usages);
    if (!count)
        return VK_SUCCESS;
    if (usages ? !readable(cache, usages, size * count)
               : !readable(cache, pointers, sizeof(void *) * (size_t)count))
        return VK_ERROR_VALIDATION_FAILED;
    copy->usages = malloc(size * count);
    if (!copy->usages)
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    copy->usage_count = count;
    for (uint32_t i = 0; i < count; i++) {
        const void *usage = usages ? (const char *)usages + size * i : NULL;
        if (!usages)
            memcpy(&usage, (const char *)pointers + sizeof(usage) * i, sizeof(usage));
        if (!usages && !readable(cache, usage, size))
            return VK_ERROR_VALIDATION_FAILED;
        memcpy(&copy->usages[i], usage, size);
    }
    return VK_SUCCESS;
}

static VkResult copy_micromap(struct readable_cache *cache, const void *chain,
                              struct chained_input *copy)
{
    VkAccelerationStructureGeometryMicromapDataKHR s;
    if (!find_in_chain(cache, chain,
                       VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_MICROMAP_DATA_KHR,
                       sizeof(s), &s))
        return VK_ERROR_VALIDATION_FAILED;
    if (!s.sType)
        return VK_SUCCESS;
    copy->micromap = (struct micromap_parameters){
        .type = VK_MICROMAP_TYPE_OPACITY_MICROMAP_EXT,
        .is_khr = true,
        .data.deviceAddress = s.data,
        .triangles.deviceAddress = s.triangleArray,
        .stride = s.triangleArrayStride,
    };
    return micromap_usages_copy(cache, s.usageCountsCount, s.pUsageCounts, s.ppUsageCounts,
                                &copy->micromap);
}

static bool copy_displacement(struct readable_cache *cache, const void *chain,
                              struct chained_input *copy)
{
    VkAccelerationStructureTrianglesDisplacementMicromapNV s;
    if (!find_in_chain(cache, chain,
                       VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_TRIANGLES_DISPLACEMENT_MICROMAP_NV,
                       sizeof(s), &s))
        return false;
    copy->has_displacement = s.sType;
    copy->displacement = s;
    copy->displacement.pNext = NULL;
    return true;
}

/* The usages are still the application's. */
static VkResult copy_displacement_usages(struct readable_cache *cache, struct chained_input *copy)
{
    VkAccelerationStructureTrianglesDisplacementMicromapNV *s = &copy->displacement;
    const VkResult result = micromap_usages_copy(cache, s->usageCountsCount, s->pUsageCounts,
                                                 s->ppUsageCounts, &copy->micromap);
    s->pUsageCounts = NULL;
    s->ppUsageCounts = NULL;
    return result;
}

/* ---- geometries */

static bool has_any(const VkAccelerationStructureGeometryKHR *geometry)
{
    switch ((int)geometry->geometryType) {
    case VK_GEOMETRY_TYPE_TRIANGLES_KHR:
        return geometry->geometry.triangles.pNext;
    case VK_GEOMETRY_TYPE_SPHERES_NV:
    case VK_GEOMETRY_TYPE_LINEAR_SWEPT_SPHERES_NV:
    case VK_GEOMETRY_TYPE_DENSE_GEOMETRY_FORMAT_TRIANGLES_AMDX:
    case VK_GEOMETRY_TYPE_MICROMAP_KHR:
        return geometry->pNext;
    default:
        return false;
    }
}

bool chained_input_read(struct readable_cache *cache, VkBuildAccelerationStructureFlagsKHR flags,
                        const VkAccelerationStructureGeometryKHR *geometry,
                        struct chained_input *chained)
{
    const void *triangles = geometry->geometry.triangles.pNext;
    const bool has_motion = flags & VK_BUILD_ACCELERATION_STRUCTURE_MOTION_BIT_NV;
    switch ((int)geometry->geometryType) {
    case VK_GEOMETRY_TYPE_TRIANGLES_KHR:
        return (!has_motion || copy_motion(cache, geometry, chained)) &&
               copy_opacity(cache, triangles, chained) &&
               copy_displacement(cache, triangles, chained);
    case VK_GEOMETRY_TYPE_SPHERES_NV:
        return copy_spheres(cache, geometry->pNext, chained);
    case VK_GEOMETRY_TYPE_LINEAR_SWEPT_SPHERES_NV:
        return copy_swept_spheres(cache, geometry->pNext, chained);
    case VK_GEOMETRY_TYPE_DENSE_GEOMETRY_FORMAT_TRIANGLES_AMDX:
        return copy_dense(cache, geometry->pNext, chained);
    default:
        return true;
    }
}

VkResult chained_input_copy(struct readable_cache *cache,
                            VkBuildAccelerationStructureFlagsKHR flags,
                            const VkAccelerationStructureGeometryKHR *geometry,
                            struct chained_input *copy)
{
    if (!chained_input_read(cache, flags, geometry, copy))
        return VK_ERROR_VALIDATION_FAILED;
    if (type_is_micromap(geometry->geometryType))
        return copy_micromap(cache, geometry->pNext, copy);
    return copy->has_displacement ? copy_displacement_usages(cache, copy) : VK_SUCCESS;
}

VkResult chained_inputs_copy(struct readable_cache *cache,
                             const VkAccelerationStructureBuildGeometryInfoKHR *info,
                             struct chained_input **chained)
{
    VkResult result = VK_SUCCESS;
    *chained = NULL;
    for (uint32_t i = 0; i < info->geometryCount && result == VK_SUCCESS; i++) {
        if (!has_any(&info->pGeometries[i]))
            continue;
        if (!*chained)
            *chained = calloc(info->geometryCount, sizeof(**chained));
        result = *chained
                     ? chained_input_copy(cache, info->flags, &info->pGeometries[i], &(*chained)[i])
                     : VK_ERROR_OUT_OF_HOST_MEMORY;
    }
    if (result == VK_SUCCESS)
        return result;
    chained_inputs_free(*chained, info->geometryCount);
    *chained = NULL;
    return result;
}

void chained_inputs_free(struct chained_input *chained, uint32_t count)
{
    for (uint32_t i = 0; chained && i < count; i++)
        free(chained[i].micromap.usages);
    free(chained);
}

uint64_t micromap_parameters_count(const struct micromap_parameters *micromap)
{
    uint64_t count = 0;
    for (uint32_t i = 0; i < micromap->usage_count; i++)
        count += micromap->usages[i].count;
    return count;
}

uint64_t micromap_parameters_extent(const struct micromap_parameters *micromap)
{
    const uint64_t count = micromap_parameters_count(micromap);
    uint64_t extent;
    if (!count || __builtin_mul_overflow(count - 1, micromap->stride, &extent) ||
        __builtin_add_overflow(extent, sizeof(VkMicromapTriangleEXT), &extent))
        return 0;
    return extent;
}
