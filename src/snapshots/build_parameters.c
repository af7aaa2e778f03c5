/* SPDX-License-Identifier: Apache-2.0 */
/* Copies the parameters of builds, also those of VK_NV_ray_tracing and VK_EXT_opacity_micromap. */
#include "src/snapshots/build_parameters.h"

#include <stdlib.h>
#include <string.h>

#include "src/state/builds/built.h"

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
        if (type_is_dense(copy->geometries[i].geometryType))
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
        if (type_takes_range(build->geometries[i].geometryType))
            return true;
    return false;
}

/* ---- VK_NV_ray_tracing */

static VkDeviceOrHostAddressConstKHR address(const struct nv_data *data, VkBuffer buffer,
                                             VkDeviceSize offset)
{
    uint64_t found = data && buffer ? data->find(data->context, buffer, offset) : 0;
    return (VkDeviceOrHostAddressConstKHR){.deviceAddress = found};
}

static void translate_triangles(const VkGeometryTrianglesNV *from, const struct nv_data *data,
                                VkAccelerationStructureGeometryTrianglesDataKHR *to)
{
    to->sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_TRIANGLES_DATA_KHR;
    to->vertexFormat = from->vertexFormat;
    to->vertexData = address(data, from->vertexData, from->vertexOffset);
    to->vertexStride = from->vertexStride;
    to->maxVertex = from->vertexCount ? from->vertexCount - 1 : 0;
    to->indexType = from->indexType;
    if (from->indexType != VK_INDEX_TYPE_NONE_NV)
        to->indexData = address(data, from->indexData, from->indexOffset);
    to->transformData = address(data, from->transformData, from->transformOffset);
}

static void translate_geometry(const VkGeometryNV *from, const struct nv_data *data,
                               VkAccelerationStructureGeometryKHR *to, uint32_t *count)
{
    const VkGeometryAABBNV *aabbs = &from->geometry.aabbs;
    to->sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_KHR;
    to->geometryType = from->geometryType;
    to->flags = from->flags;
    *count = nv_primitive_count(from);
    switch (from->geometryType) {
    case VK_GEOMETRY_TYPE_TRIANGLES_NV:
        translate_triangles(&from->geometry.triangles, data, &to->geometry.triangles);
        break;
    case VK_GEOMETRY_TYPE_AABBS_NV:
        to->geometry.aabbs.sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_AABBS_DATA_KHR;
        to->geometry.aabbs.data = address(data, aabbs->aabbData, aabbs->offset);
        to->geometry.aabbs.stride = aabbs->stride;
        break;
    default: /* instances are not allowed here: the builder rejects them */
        *count = 0;
        to->geometryType = VK_GEOMETRY_TYPE_MAX_ENUM_KHR;
    }
}

static VkResult copy_geometries(struct readable_cache *cache,
                                const VkAccelerationStructureInfoNV *info,
                                const struct nv_data *data, struct build_parameters *copy)
{
    const size_t count = info->geometryCount;
    if (!readable(cache, info->pGeometries, count * sizeof(*info->pGeometries)))
        return VK_ERROR_VALIDATION_FAILED;
    VkResult result = build_parameters_allocate(copy, info->geometryCount);
    for (size_t i = 0; result == VK_SUCCESS && i < count; i++) {
        VkGeometryNV geometry; /* the array may be misaligned */
        memcpy(&geometry, &info->pGeometries[i], sizeof(geometry));
        translate_geometry(&geometry, data, &copy->geometries[i], &copy->ranges[i].primitiveCount);
    }
    return result;
}

static VkResult copy_instances(const VkAccelerationStructureInfoNV *info,
                               const struct nv_data *data, struct build_parameters *copy)
{
    VkResult result = build_parameters_allocate(copy, 1);
    if (result != VK_SUCCESS)
        return result;
    copy->geometries[0].sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_KHR;
    copy->geometries[0].geometryType = VK_GEOMETRY_TYPE_INSTANCES_KHR;
    copy->geometries[0].geometry.instances.sType =
        VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_INSTANCES_DATA_KHR;
    if (data)
        copy->geometries[0].geometry.instances.data =
            address(data, data->instances, data->instance_offset);
    copy->ranges[0].primitiveCount = info->instanceCount;
    return VK_SUCCESS;
}

VkResult nv_info_copy(struct readable_cache *cache, const VkAccelerationStructureInfoNV *from,
                      const struct nv_data *data, struct build_parameters *copy)
{
    *copy = (struct build_parameters){0};
    if (!readable(cache, from, sizeof(*from)))
        return VK_ERROR_VALIDATION_FAILED;
    VkAccelerationStructureInfoNV own, *info = &own;
    memcpy(info, from, sizeof(*info));
    copy->info.type = info->type;
    copy->info.flags = info->flags;
    return info->type == VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_NV
               ? copy_instances(info, data, copy)
               : copy_geometries(cache, info, data, copy);
}

/* ---- VK_EXT_opacity_micromap */

static VkResult copy_input(struct readable_cache *cache, const VkMicromapBuildInfoEXT *info,
                           struct build_parameters *copy)
{
    copy->chained = calloc(1, sizeof(*copy->chained));
    if (!copy->chained)
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    copy->geometries[0].geometryType = VK_GEOMETRY_TYPE_MICROMAP_KHR;
    copy->chained[0].micromap = (struct micromap_parameters){
        .type = info->type,
        .data = info->data,
        .triangles = info->triangleArray,
        .stride = info->triangleArrayStride,
    };
    return micromap_usages_copy(cache, info->usageCountsCount, info->pUsageCounts,
                                info->ppUsageCounts, &copy->chained[0].micromap);
}

VkResult micromap_info_copy(struct readable_cache *cache, const VkMicromapBuildInfoEXT *from,
                            struct build_parameters *copy)
{
    *copy = (struct build_parameters){0}; /* info.mode: BUILD */
    if (!readable(cache, from, sizeof(*from)))
        return VK_ERROR_VALIDATION_FAILED;
    VkMicromapBuildInfoEXT own, *info = &own;
    memcpy(info, from, sizeof(*info));
    copy->had_chains = true; /* the members alone do not describe the build */
    copy->info.type = VK_ACCELERATION_STRUCTURE_TYPE_OPACITY_MICROMAP_KHR;
    copy->info.dstAccelerationStructure = (VkAccelerationStructureKHR)info->dstMicromap;
    copy->info.scratchData = info->scratchData;
    VkResult result = build_parameters_allocate(copy, 1);
    if (result == VK_SUCCESS)
        result = copy_input(cache, info, copy);
    if (result != VK_SUCCESS)
        build_parameters_release(copy);
    return result;
}
