/* SPDX-License-Identifier: Apache-2.0 */
/* Translates VkAccelerationStructureInfoNV to the parameters of a build. */
#include "src/snapshots/nv_info.h"

#include <string.h>

#include "src/state/builds/built.h"

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
