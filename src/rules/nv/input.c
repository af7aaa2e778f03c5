/* SPDX-License-Identifier: Apache-2.0 */
/* Rules about the buffers of one VkGeometryNV. The facts of a buffer that isn't given, or that the
 * geometry doesn't use, are all unknown. */
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
