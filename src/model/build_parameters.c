/* SPDX-License-Identifier: Apache-2.0 */
/* Copies the parameters of builds, also those of VK_NV_ray_tracing and VK_EXT_opacity_micromap. */
#include "src/model/build_parameters.h"

#include <stdlib.h>
#include <string.h>

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

void nv_places_of(const VkGeometryNV *geometry, struct nv_place places[NV_PLACES])
{
    const VkGeometryTrianglesNV *triangles = &geometry->geometry.triangles;
    const VkGeometryAABBNV *aabbs = &geometry->geometry.aabbs;
    memset(places, 0, NV_PLACES * sizeof(*places));
    if (type_is_aabbs(geometry->geometryType))
        places[INPUT_AABBS] = (struct nv_place){aabbs->aabbData, aabbs->offset};
    if (!type_is_triangles(geometry->geometryType))
        return;
    places[INPUT_VERTEX] = (struct nv_place){triangles->vertexData, triangles->vertexOffset};
    if (triangles->indexType != VK_INDEX_TYPE_NONE_NV)
        places[INPUT_INDEX] = (struct nv_place){triangles->indexData, triangles->indexOffset};
    places[INPUT_MATRIX] = (struct nv_place){triangles->transformData, triangles->transformOffset};
}

static void set_address(VkAccelerationStructureGeometryKHR *geometry, enum input_role role,
                        const struct nv_data *data, const struct nv_place *place)
{
    if (data && place->buffer)
        input_place(geometry, NULL, role)->deviceAddress =
            data->find ? data->find(data->context, place->buffer, place->offset) : 1;
}

/* A geometry without vertices has no triangles, whatever its index count. */
static uint32_t count_triangles(const VkGeometryTrianglesNV *triangles)
{
    bool is_indexed = triangles->indexType != VK_INDEX_TYPE_NONE_NV && triangles->vertexCount;
    return (is_indexed ? triangles->indexCount : triangles->vertexCount) / 3;
}

static void translate_geometry(const VkGeometryNV *from, const struct nv_data *data,
                               VkAccelerationStructureGeometryKHR *to, uint32_t *count)
{
    const VkGeometryTrianglesNV *triangles = &from->geometry.triangles;
    struct nv_place places[NV_PLACES];
    to->sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_KHR;
    to->geometryType = from->geometryType;
    to->flags = from->flags;
    if (type_is_triangles(from->geometryType)) {
        *count = count_triangles(triangles);
        to->geometry.triangles = (VkAccelerationStructureGeometryTrianglesDataKHR){
            .sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_TRIANGLES_DATA_KHR,
            .vertexFormat = triangles->vertexFormat,
            .vertexStride = triangles->vertexStride,
            .maxVertex = triangles->vertexCount ? triangles->vertexCount - 1 : 0,
            .indexType = triangles->indexType,
        };
    } else if (type_is_aabbs(from->geometryType)) {
        *count = from->geometry.aabbs.numAABBs;
        to->geometry.aabbs = (VkAccelerationStructureGeometryAabbsDataKHR){
            .sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_AABBS_DATA_KHR,
            .stride = from->geometry.aabbs.stride,
        };
    } else { /* instances are not allowed here: the builder rejects them */
        *count = 0;
        to->geometryType = VK_GEOMETRY_TYPE_MAX_ENUM_KHR;
    }
    nv_places_of(from, places);
    for (enum input_role role = 0; role <= INPUT_LAST_PLAIN; role++)
        set_address(to, role, data, &places[role]);
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
        set_address(&copy->geometries[0], INPUT_INSTANCES, data, &data->instances);
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
