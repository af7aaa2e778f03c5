/* SPDX-License-Identifier: Apache-2.0 */
/* Records what vkCmdBuildAccelerationStructureNV accesses. */
#include "layer/hazards/builds.h"
#include "src/snapshots/input_find.h"
#include "src/view/formats.h"

static void add_structures(struct hazard_recording *recording, const struct nv_call_view *view)
{
    struct hazard_use use = {.kind = ACCESS_BUILD_ACCEL_WRITE, .role = HAZARD_DST};
    hazard_recording_add_nv(recording, &use, &view->dst_facts);
    if (!view->update || view->src == view->dst)
        return;
    use.kind = ACCESS_BUILD_ACCEL_READ;
    use.role = HAZARD_SRC;
    hazard_recording_add_nv(recording, &use, &view->src_facts);
}

static void add_scratch(struct hazard_recording *recording, const struct nv_call_view *view)
{
    const struct nv_size_facts *sizes = &view->dst_facts.sizes;
    if (sizes->known)
        hazard_recording_add_buffer(recording, ACCESS_BUILD_ACCEL_WRITE, HAZARD_SCRATCH,
                                    view->scratch, view->scratch_offset,
                                    view->update ? sizes->update_scratch : sizes->build_scratch);
}

/* ---- inputs */

static void add(struct hazard_recording *recording, uint32_t geometry, enum hazard_role role,
                VkBuffer buffer, struct hazard_elements *elements)
{
    const struct hazard_use use = {
        .kind = ACCESS_BUILD_SHADER_READ, .role = role, .geometry = geometry};
    struct resources *resources = recording->device->resources;
    struct memory_bytes bytes;
    if (!resources_find_buffer_bytes(resources, buffer, &bytes))
        return;
    elements->memory_id = bytes.memory_id;
    elements->facts = &(struct address_facts){.status = ADDRESS_IN_BUFFER,
                                              .buffer = buffer,
                                              .begin = bytes.begin,
                                              .bytes_left = bytes.size};
    if (role == HAZARD_VERTICES && !elements->count)
        hazards_add_indexed(recording, &use, elements);
    else
        hazards_add_elements(recording, &use, elements);
}

/* As in add_vertices() of inputs.c: indices may skip any vertex. */
static void add_triangles(struct hazard_recording *recording, uint32_t index,
                          const VkGeometryTrianglesNV *triangles)
{
    bool is_indexed = triangles->indexType != VK_INDEX_TYPE_NONE_NV;
    uint64_t index_size = input_index_size(triangles->indexType);
    if (is_indexed ? !triangles->indexCount : !triangles->vertexCount)
        return;
    add(recording, index, HAZARD_VERTICES, triangles->vertexData,
        &(struct hazard_elements){.offset = triangles->vertexOffset,
                                  .count = is_indexed ? 0 : triangles->vertexCount,
                                  .stride = triangles->vertexStride,
                                  .size = format_position_size(triangles->vertexFormat)});
    if (is_indexed)
        add(recording, index, HAZARD_INDICES, triangles->indexData,
            &(struct hazard_elements){.offset = triangles->indexOffset,
                                      .count = triangles->indexCount,
                                      .stride = index_size,
                                      .size = index_size});
    add(recording, index, HAZARD_TRANSFORM, triangles->transformData,
        &(struct hazard_elements){.offset = triangles->transformOffset,
                                  .count = 1,
                                  .size = sizeof(VkTransformMatrixKHR)});
}

static void add_geometry(struct hazard_recording *recording, uint32_t index,
                         const VkGeometryNV *geometry)
{
    const VkGeometryAABBNV *boxes = &geometry->geometry.aabbs;
    if (geometry->geometryType == VK_GEOMETRY_TYPE_TRIANGLES_NV)
        add_triangles(recording, index, &geometry->geometry.triangles);
    else if (geometry->geometryType == VK_GEOMETRY_TYPE_AABBS_NV)
        add(recording, index, HAZARD_BOXES, boxes->aabbData,
            &(struct hazard_elements){.offset = boxes->offset,
                                      .count = boxes->numAABBs,
                                      .stride = boxes->stride,
                                      .size = sizeof(VkAabbPositionsKHR)});
}

static void add_instances(struct hazard_recording *recording, const struct nv_call_view *view)
{
    const uint64_t size = sizeof(VkAccelerationStructureInstanceKHR);
    uint32_t count = view->info->instanceCount;
    if (view->info->type != VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_NV || !count)
        return;
    add(recording, 0, HAZARD_INSTANCES, view->instance_data,
        &(struct hazard_elements){
            .offset = view->instance_offset, .count = count, .stride = size, .size = size});
    if (recording->command)
        recording->command->reads_references = true;
    recording->journal->awaits_inputs = true;
}

void hazards_add_nv_build(struct hazard_recording *recording, const struct nv_call_view *view)
{
    add_structures(recording, view);
    add_scratch(recording, view);
    if (!view->info)
        return;
    add_instances(recording, view);
    for (uint32_t i = 0; i < view->geometry_count; i++)
        add_geometry(recording, i, &view->geometries[i]);
}
