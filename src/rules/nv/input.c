/* SPDX-License-Identifier: Apache-2.0 */
/* Rules about the buffers of one VkGeometryNV. The facts of a buffer that isn't given, or that the
 * geometry doesn't use, are all unknown. */
#include "src/model/formats.h"
#include "src/model/geometry.h"
#include "src/rules/nv/objects.h"
#include "src/rules/predicates.h"

#define TRIANGLES "geometry.triangles."
#define BOXES "geometry.aabbs."

static bool is_in_buffer(const struct buffer_facts *facts, struct finding *finding,
                         const char *field, VkDeviceSize offset)
{
    return facts->alive != YES || offset < facts->size ||
           violated(finding, field, "{} is not less than the size of {} ({})", number(offset),
                    nv_buffer(facts->handle), count_of(facts->size, "byte"));
}

bool nv_vertex_data_is_a_valid_buffer(const struct nv_geometry_view *nv_geometry,
                                      struct finding *finding)
{
    return nv_is_a_buffer(&nv_geometry->vertex, finding, TRIANGLES "vertexData");
}

bool nv_vertex_offset_is_in_the_buffer(const struct nv_geometry_view *nv_geometry,
                                       struct finding *finding)
{
    const VkGeometryTrianglesNV *triangles = nv_geometry->triangles;
    return !triangles || nv_geometry_is_empty(nv_geometry) ||
           is_in_buffer(&nv_geometry->vertex, finding, TRIANGLES "vertexOffset",
                        triangles->vertexOffset);
}

bool nv_index_data_is_null_or_a_valid_buffer(const struct nv_geometry_view *nv_geometry,
                                             struct finding *finding)
{
    return nv_is_a_buffer(&nv_geometry->index_data, finding, TRIANGLES "indexData");
}

bool nv_index_offset_is_in_the_buffer(const struct nv_geometry_view *nv_geometry,
                                      struct finding *finding)
{
    const VkGeometryTrianglesNV *triangles = nv_geometry->triangles;
    return !triangles || nv_geometry_is_empty(nv_geometry) ||
           is_in_buffer(&nv_geometry->index_data, finding, TRIANGLES "indexOffset",
                        triangles->indexOffset);
}

bool nv_transform_data_is_a_valid_buffer(const struct nv_geometry_view *nv_geometry,
                                         struct finding *finding)
{
    return nv_is_a_buffer(&nv_geometry->transform, finding, TRIANGLES "transformData");
}

bool nv_transform_offset_is_in_the_buffer(const struct nv_geometry_view *nv_geometry,
                                          struct finding *finding)
{
    const VkGeometryTrianglesNV *triangles = nv_geometry->triangles;
    return !triangles || nv_geometry_is_empty(nv_geometry) ||
           is_in_buffer(&nv_geometry->transform, finding, TRIANGLES "transformOffset",
                        triangles->transformOffset);
}

/* All buffers belong to one device, this or another: another rule covers the command's own
 * handles. */
bool nv_triangles_buffers_share_the_device(const struct nv_geometry_view *nv_geometry,
                                           struct finding *finding)
{
    const struct {
        const char *field;
        const struct buffer_facts *facts;
    } buffers[] = {{TRIANGLES "vertexData", &nv_geometry->vertex},
                   {TRIANGLES "indexData", &nv_geometry->index_data},
                   {TRIANGLES "transformData", &nv_geometry->transform}};
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            if (buffers[i].facts->of_another_device && buffers[j].facts->alive == YES)
                return violated(
                    finding, buffers[i].field, "{} was created from another VkDevice than {}",
                    nv_buffer(buffers[i].facts->handle), nv_buffer(buffers[j].facts->handle));
    return true;
}

bool nv_aabb_data_is_a_valid_buffer(const struct nv_geometry_view *nv_geometry,
                                    struct finding *finding)
{
    return nv_is_a_buffer(&nv_geometry->boxes, finding, BOXES "aabbData");
}

bool nv_aabb_offset_is_in_the_buffer(const struct nv_geometry_view *nv_geometry,
                                     struct finding *finding)
{
    const VkGeometryAABBNV *aabbs = nv_geometry->aabbs;
    return !aabbs || nv_geometry_is_empty(nv_geometry) ||
           is_in_buffer(&nv_geometry->boxes, finding, BOXES "offset", aabbs->offset);
}

/* ---- the end of buffers */

/* Returns whether `count` elements lie in the buffer. Other rules are about an offset behind its
 * end, and about strides that do not fit in 32 bits. */
static bool is_read_within(const struct buffer_facts *facts, struct finding *finding,
                           const char *field, VkDeviceSize offset, uint64_t count, uint64_t stride,
                           uint64_t size)
{
    if (facts->alive != YES || offset >= facts->size || !count || !size || stride > UINT32_MAX)
        return true;
    const uint64_t bytes = (count - 1) * stride + size;
    return bytes <= facts->size - offset ||
           violated(finding, field, "{} makes the build read {} of {}, {} past its end",
                    number(offset), count_of(bytes, "byte"), nv_buffer(facts->handle),
                    count_of(bytes - (facts->size - offset), "byte"));
}

/* Vertices are read by index, or all of them; a triangle that lacks vertices is not read. */
static bool triangles_are_read_within(const struct nv_geometry_view *nv_geometry,
                                      struct finding *finding)
{
    const VkGeometryTrianglesNV *triangles = nv_geometry->triangles;
    const uint32_t index_size = index_type_size(triangles->indexType);
    const bool has_indices = triangles->indexType != VK_INDEX_TYPE_NONE_NV;
    const uint32_t count = has_indices ? 0 : triangles->vertexCount - triangles->vertexCount % 3;
    if ((has_indices ? triangles->indexCount : count) / 3 >
        nv_geometry->call->call->device->nv_limits.maxTriangleCount)
        return true; /* other rules are about the count */
    return is_read_within(&nv_geometry->index_data, finding, TRIANGLES "indexOffset",
                          triangles->indexOffset, triangles->indexCount - triangles->indexCount % 3,
                          index_size, index_size) &&
           is_read_within(&nv_geometry->vertex, finding, TRIANGLES "vertexOffset",
                          triangles->vertexOffset, count, triangles->vertexStride,
                          format_position_size(triangles->vertexFormat)) &&
           is_read_within(&nv_geometry->transform, finding, TRIANGLES "transformOffset",
                          triangles->transformOffset, 1, 0, sizeof(VkTransformMatrixNV));
}

bool nv_geometry_is_read_within_its_buffers(const struct nv_geometry_view *nv_geometry,
                                            struct finding *finding)
{
    const VkGeometryAABBNV *aabbs = nv_geometry->aabbs;
    if (nv_geometry_is_empty(nv_geometry))
        return true;
    if (nv_geometry->triangles)
        return triangles_are_read_within(nv_geometry, finding);
    return !aabbs || is_read_within(&nv_geometry->boxes, finding, BOXES "offset", aabbs->offset,
                                    aabbs->numAABBs, aabbs->stride, sizeof(VkAabbPositionsNV));
}

bool nv_instances_are_read_within_their_buffer(const struct nv_call_view *nv_call,
                                               struct finding *finding)
{
    const VkAccelerationStructureInfoNV *info = nv_call->info;
    return !info || info->type != VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_NV ||
           info->instanceCount > nv_call->call->device->nv_limits.maxInstanceCount ||
           is_read_within(&nv_call->instance_facts, finding, "instanceOffset",
                          nv_call->instance_offset, info->instanceCount,
                          sizeof(VkAccelerationStructureInstanceNV),
                          sizeof(VkAccelerationStructureInstanceNV));
}
