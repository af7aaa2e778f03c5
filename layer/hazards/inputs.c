/* SPDX-License-Identifier: Apache-2.0 */
/* Records the input data that builds certainly read. What an indirect build reads depends on counts
 * in device memory, so nothing of it is certain. */
#include "layer/hazards/builds.h"

#include <string.h>

#include "layer/execution/hazards/host_writes.h"
#include "layer/hazards/recording.h"
#include "observers.h"
#include "src/base/readable.h"
#include "src/check/assemble/extended.h"
#include "src/check/assemble/views.h"
#include "src/snapshots/input_find.h"
#include "src/view/extension_view.h"
#include "src/view/formats.h"

/* ---- bytes */

static void add_in_buffer(struct hazard_recording *recording, const struct hazard_use *use,
                          const struct hazard_elements *from, uint64_t begin, uint64_t end)
{
    const struct address_facts *facts = from->facts;
    uint64_t size = facts->bytes_left;
    const struct hazard_bytes bytes = {from->memory_id,
                                       facts->begin + (begin < size ? begin : size),
                                       facts->begin + (end < size ? end : size)};
    hazard_recording_add(recording, use, VK_OBJECT_TYPE_BUFFER, (uint64_t)(uintptr_t)facts->buffer,
                         &bytes);
}

/* NULL if there are none, or if the offset leads past the last address. */
static const void *host_bytes_at(const void *host, uint64_t offset)
{
    const uintptr_t begin = (uintptr_t)host;
    return host && offset <= UINTPTR_MAX - begin ? (const void *)(begin + (uintptr_t)offset) : NULL;
}

static void add_bytes(struct hazard_recording *recording, const struct hazard_use *use,
                      const struct hazard_elements *from, uint64_t begin, uint64_t end)
{
    if (end == UINT64_MAX)
        return;
    if (from->memory_id)
        add_in_buffer(recording, use, from, begin, end);
    else if (from->host)
        hazards_add_host(recording, use, host_bytes_at(from->host, begin), end - begin);
    else
        hazard_recording_add_address(recording, use, from->facts, begin, end);
}

/* Whether the host alone may write what a build of the device reads. */
static bool is_of_host(const struct hazard_elements *elements)
{
    return !elements->host && elements->facts->status == ADDRESS_IN_BUFFER &&
           buffer_is_only_read(elements->facts->usage);
}

void hazards_add_elements(struct hazard_recording *recording, const struct hazard_use *use,
                          const struct hazard_elements *elements)
{
    uint64_t size = elements->size, stride = elements->stride;
    if (!elements->count || !size)
        return;
    recording->journal->reads_host_data |= is_of_host(elements);
    uint64_t begin = elements->offset;
    uint64_t last = input_extent(begin, elements->count - 1, stride, 0);
    uint64_t end = input_extent(begin, elements->count - 1, stride, size);
    if (stride <= size || elements->count == 1) {
        add_bytes(recording, use, elements, begin, end);
        return;
    }
    add_bytes(recording, use, elements, begin, begin + size);
    add_bytes(recording, use, elements, last, end);
}

void hazards_add_indexed(struct hazard_recording *recording, const struct hazard_use *use,
                         const struct hazard_elements *elements)
{
    const struct address_facts *facts = elements->facts;
    const bool is_content = recording->device->level >= LEVEL_CONTENT;
    if (elements->host || facts->status != ADDRESS_IN_BUFFER ||
        elements->offset >= facts->bytes_left || elements->stride > UINT32_MAX ||
        (!is_content && !is_of_host(elements)))
        return;
    const uint64_t memory =
        elements->memory_id
            ? elements->memory_id
            : hazard_memory_id(recording->journal, recording->device->resources, facts->memory);
    struct hazard_entry *item =
        memory ? hazard_recording_add_entry(recording, HAZARD_INDEXED, use) : NULL;
    if (!item)
        return;
    item->object_type = VK_OBJECT_TYPE_BUFFER;
    item->object = (uint64_t)(uintptr_t)facts->buffer;
    item->count = (uint32_t)elements->stride;
    item->origin = (uint32_t)elements->size;
    item->bytes = (struct hazard_bytes){memory, facts->begin + elements->offset,
                                        facts->begin + facts->bytes_left};
    recording->journal->awaits_inputs |= is_content;
}

/* ---- geometries */

/* A geometry that is being recorded. */
struct input {
    struct hazard_recording *recording;
    const struct geometry_view *geometry;
    const VkAccelerationStructureBuildRangeInfoKHR *range;
    bool is_host;
};

static struct hazard_use use_of(const struct input *input, enum hazard_role role)
{
    return (struct hazard_use){
        .kind = input->is_host ? ACCESS_HOST_READ : ACCESS_BUILD_SHADER_READ,
        .role = role,
        .info = input->geometry->build->index,
        .geometry = input->geometry->index,
    };
}

static void add_of_size(const struct input *input, enum hazard_role role, uint32_t index_size,
                        VkDeviceOrHostAddressConstKHR address, struct hazard_elements *elements)
{
    struct hazard_use use = use_of(input, role);
    use.index_size = index_size;
    elements->host = input->is_host ? address.hostAddress : NULL;
    if (input->is_host && !elements->host)
        return;
    hazards_add_elements(input->recording, &use, elements);
}

static void add_input_bytes(const struct input *input, enum hazard_role role,
                            VkDeviceOrHostAddressConstKHR address, struct hazard_elements *elements)
{
    add_of_size(input, role, 0, address, elements);
}

/* Level content reads the data, and shaders may be what wrote them. */
static void await_data(const struct input *input, const struct address_facts *facts)
{
    struct resources *resources = input->recording->device->resources;
    if (!input->is_host && input->recording->device->level >= LEVEL_CONTENT &&
        facts->status == ADDRESS_IN_BUFFER &&
        !resources_find_memory(resources, facts->memory).is_shared)
        input->recording->journal->awaits_inputs = true;
}

/* An input of an extension's structure; nothing if the address is 0. */
static void add_other(const struct input *input, VkDeviceOrHostAddressConstKHR address,
                      struct hazard_elements *elements)
{
    struct address_facts facts = {.status = ADDRESS_UNKNOWN};
    if (!input->is_host)
        resources_look_up_address(input->recording->device->resources, address.deviceAddress,
                                  &facts);
    elements->facts = &facts;
    add_input_bytes(input, HAZARD_OTHER_INPUT, address, elements);
}

/* The facts of an address in the structures of extensions. */
static const struct address_facts *chained_facts(const struct input *input, enum input_role role)
{
    static const struct address_facts unknown;
    const struct chained_inputs *chained = input->geometry->chained;
    for (uint32_t i = 0; chained && i < chained->count; i++)
        if (chained->items[i].role == role)
            return &chained->items[i].facts;
    return &unknown;
}

/* Indices may skip any vertex, and maxVertex is an upper bound: without the indices no vertex of an
 * indexed geometry is certain, with them those of the smallest and the largest one. */
static void add_vertices_of(const struct input *input, enum hazard_role role,
                            VkDeviceOrHostAddressConstKHR address, struct hazard_elements *vertices)
{
    const struct hazard_use use = use_of(input, role);
    if (vertices->count)
        add_input_bytes(input, role, address, vertices);
    else if (!input->is_host)
        hazards_add_indexed(input->recording, &use, vertices);
}

static void add_vertices(const struct input *input,
                         const VkAccelerationStructureGeometryTrianglesDataKHR *triangles)
{
    const VkAccelerationStructureGeometryMotionTrianglesDataNV *motion =
        input->geometry->chained
            ? chain_member(
                  triangles->pNext, &input->geometry->triangles_chain,
                  VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_MOTION_TRIANGLES_DATA_NV)
            : NULL;
    bool is_indexed = triangles->indexType != VK_INDEX_TYPE_NONE_KHR;
    struct hazard_elements vertices = {
        .facts = &input->geometry->vertex,
        .offset = input_extent(is_indexed ? 0 : input->range->primitiveOffset,
                               input->range->firstVertex, triangles->vertexStride, 0),
        .count = is_indexed ? 0 : input_vertices(triangles, input->range),
        .stride = triangles->vertexStride,
        .size = format_position_size(triangles->vertexFormat),
    };
    add_vertices_of(input, HAZARD_VERTICES, triangles->vertexData, &vertices);
    await_data(input, &input->geometry->vertex);
    if (!motion)
        return;
    vertices.facts = chained_facts(input, INPUT_MOTION_VERTEX);
    add_vertices_of(input, HAZARD_OTHER_INPUT, motion->vertexData, &vertices);
}

/* ---- micromaps that triangles use
 *
 * One index for each triangle, from the first byte of the buffer on. Without micromap nothing is
 * certain. */

static void add_micromap_indices(const struct input *input, VkIndexType type,
                                 VkDeviceOrHostAddressConstKHR address, uint64_t stride)
{
    if (type != VK_INDEX_TYPE_NONE_KHR)
        add_other(input, address,
                  &(struct hazard_elements){.count = input->range->primitiveCount,
                                            .stride = stride,
                                            .size = input_index_size(type)});
}

static void add_opacity(const struct input *input, const void *chain)
{
    const struct chain_facts *facts = &input->geometry->triangles_chain;
    const VkAccelerationStructureTrianglesOpacityMicromapEXT *ext = chain_member(
        chain, facts, VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_TRIANGLES_OPACITY_MICROMAP_EXT);
    const VkAccelerationStructureTrianglesOpacityMicromapKHR *khr = chain_member(
        chain, facts, VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_TRIANGLES_OPACITY_MICROMAP_KHR);
    if (ext && ext->micromap)
        add_micromap_indices(input, ext->indexType, ext->indexBuffer, ext->indexStride);
    if (khr && khr->micromap && !input->is_host)
        add_micromap_indices(input, khr->indexType,
                             (VkDeviceOrHostAddressConstKHR){.deviceAddress = khr->indexBuffer},
                             khr->indexStride);
}

/* Which vectors, biases and scales are read depends on the indices of the triangles. */
static void add_displacement(const struct input *input, const void *chain)
{
    const VkAccelerationStructureTrianglesDisplacementMicromapNV *displacement =
        chain_member(chain, &input->geometry->triangles_chain,
                     VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_TRIANGLES_DISPLACEMENT_MICROMAP_NV);
    if (!displacement || !displacement->micromap)
        return;
    add_micromap_indices(input, displacement->indexType, displacement->indexBuffer,
                         displacement->indexStride);
    add_other(
        input, displacement->displacedMicromapPrimitiveFlags,
        &(struct hazard_elements){.count = input->range->primitiveCount,
                                  .stride = displacement->displacedMicromapPrimitiveFlagsStride,
                                  .size = 1});
}

static void add_triangles(const struct input *input)
{
    const VkAccelerationStructureGeometryTrianglesDataKHR *triangles =
        &input->geometry->geometry->geometry.triangles;
    uint64_t index_size = input_index_size(triangles->indexType);
    add_vertices(input, triangles);
    if (triangles->indexType != VK_INDEX_TYPE_NONE_KHR)
        add_of_size(input, HAZARD_INDICES, (uint32_t)index_size, triangles->indexData,
                    &(struct hazard_elements){.facts = &input->geometry->index_data,
                                              .offset = input->range->primitiveOffset,
                                              .count = (uint64_t)input->range->primitiveCount * 3,
                                              .stride = index_size,
                                              .size = index_size});
    add_input_bytes(input, HAZARD_TRANSFORM, triangles->transformData,
                    &(struct hazard_elements){.facts = &input->geometry->transform,
                                              .offset = input->range->transformOffset,
                                              .count = 1,
                                              .size = sizeof(VkTransformMatrixKHR)});
    if (input->geometry->chained) {
        add_opacity(input, triangles->pNext);
        add_displacement(input, triangles->pNext);
    }
}

/* ---- other geometries */

/* Indices may skip vertices. Where radii begin is certain only if firstVertex and primitiveOffset
 * are 0. */
static void add_spheres(const struct input *input)
{
    struct swept_spheres_view view;
    view_spheres(input->geometry, &view);
    const struct sphere_data *data = &view.data;
    const VkAccelerationStructureBuildRangeInfoKHR *range = input->range;
    const bool has_pairs =
        (int)input->geometry->geometry->geometryType == VK_GEOMETRY_TYPE_LINEAR_SWEPT_SPHERES_NV &&
        view.indexing_mode == VK_RAY_TRACING_LSS_INDEXING_MODE_LIST_NV;
    const uint64_t count = (uint64_t)range->primitiveCount << has_pairs;
    if (!data->given)
        return;
    if (data->index_type != VK_INDEX_TYPE_NONE_KHR) {
        add_other(input, data->indices,
                  &(struct hazard_elements){.offset = range->primitiveOffset,
                                            .count = count,
                                            .stride = data->index_stride,
                                            .size = input_index_size(data->index_type)});
        return;
    }
    add_other(
        input, data->vertices,
        &(struct hazard_elements){.offset = input_extent(range->primitiveOffset, range->firstVertex,
                                                         data->vertex_stride, 0),
                                  .count = count,
                                  .stride = data->vertex_stride,
                                  .size = format_position_size(data->vertex_format)});
    if (!range->firstVertex && !range->primitiveOffset)
        add_other(
            input, data->radii,
            &(struct hazard_elements){.count = count,
                                      .stride = data->radius_stride,
                                      .size = format_smallest_component(data->radius_format)});
}

static void add_boxes(const struct input *input)
{
    const VkAccelerationStructureGeometryAabbsDataKHR *aabbs =
        &input->geometry->geometry->geometry.aabbs;
    add_input_bytes(input, HAZARD_BOXES, aabbs->data,
                    &(struct hazard_elements){.facts = &input->geometry->data,
                                              .offset = input->range->primitiveOffset,
                                              .count = input->range->primitiveCount,
                                              .stride = aabbs->stride,
                                              .size = sizeof(VkAabbPositionsKHR)});
    await_data(input, &input->geometry->data);
}

/* Motion instances are 160 bytes apart. What is certainly read of one is as much as an instance
 * without motion has, behind its type and flags. */
enum { MOTION_INSTANCE_STRIDE = 160, MOTION_INSTANCE_HEADER = 8 };

/* The references of a host build are handles, in host memory, which level content reads. */
static void add_host_references(const struct input *input, const void *data)
{
    const size_t size = sizeof(VkAccelerationStructureInstanceKHR);
    const char *first = host_bytes_at(data, input->range->primitiveOffset);
    const struct hazard_use use = {
        .kind = ACCESS_HOST_READ, .role = HAZARD_REFERENCE, .info = input->geometry->build->index};
    uint64_t last = 0;
    if (!first || !readable(readable_cache_of_thread(), first, input->range->primitiveCount * size))
        return;
    for (uint32_t i = 0; i < input->range->primitiveCount; i++) {
        VkAccelerationStructureInstanceKHR instance;
        struct accel_facts facts;
        memcpy(&instance, first + i * size, size);
        if (instance.accelerationStructureReference == last)
            continue;
        last = instance.accelerationStructureReference;
        resources_look_up_accel(input->recording->device->resources,
                                (VkAccelerationStructureKHR)(uintptr_t)last, &facts);
        hazard_recording_add_accel(input->recording, &use, &facts, 1);
    }
}

static void add_instances(const struct input *input)
{
    const VkAccelerationStructureGeometryInstancesDataKHR *instances =
        &input->geometry->geometry->geometry.instances;
    struct hazard_elements elements = {.facts = &input->geometry->data,
                                       .offset = input->range->primitiveOffset,
                                       .count = input->range->primitiveCount,
                                       .stride = sizeof(VkAccelerationStructureInstanceKHR),
                                       .size = sizeof(VkAccelerationStructureInstanceKHR)};
    if (instances->arrayOfPointers) {
        elements.stride = elements.size = sizeof(VkDeviceAddress);
    } else if (input->geometry->build->info->flags &
               VK_BUILD_ACCELERATION_STRUCTURE_MOTION_BIT_NV) {
        elements.stride = MOTION_INSTANCE_STRIDE;
        elements.size += MOTION_INSTANCE_HEADER;
    }
    add_input_bytes(input, instances->arrayOfPointers ? HAZARD_INSTANCE_POINTERS : HAZARD_INSTANCES,
                    instances->data, &elements);
    if (input->is_host && input->recording->device->level >= LEVEL_CONTENT &&
        elements.size == sizeof(VkAccelerationStructureInstanceKHR))
        add_host_references(input, instances->data.hostAddress);
}

static void add_dense(const struct input *input)
{
    const VkAccelerationStructureDenseGeometryFormatTrianglesDataAMDX *dense = chain_member(
        input->geometry->geometry->pNext, &input->geometry->chain,
        VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_DENSE_GEOMETRY_FORMAT_TRIANGLES_DATA_AMDX);
    if (dense && !dense_is_empty(dense))
        add_input_bytes(input, HAZARD_OTHER_INPUT, dense->compressedData,
                        &(struct hazard_elements){.facts = chained_facts(input, INPUT_DENSE_DATA),
                                                  .count = 1,
                                                  .size = dense->dataSize});
}

void hazards_add_inputs(struct hazard_recording *recording, const struct geometry_view *geometry)
{
    const struct build_view *build = geometry->build;
    const struct input input = {
        .recording = recording,
        .geometry = geometry,
        .range = build->ranges ? &build->ranges[geometry->index] : NULL,
        .is_host = build->call->command == COMMAND_HOST,
    };
    if (geometry_is_dense(geometry->geometry) && geometry->chained) {
        add_dense(&input);
        return;
    }
    if (!input.range || !input.range->primitiveCount)
        return;
    switch ((int)geometry->geometry->geometryType) {
    case VK_GEOMETRY_TYPE_SPHERES_NV:
    case VK_GEOMETRY_TYPE_LINEAR_SWEPT_SPHERES_NV:
        if (geometry->chained)
            add_spheres(&input);
        break;
    case VK_GEOMETRY_TYPE_TRIANGLES_KHR:
        add_triangles(&input);
        break;
    case VK_GEOMETRY_TYPE_AABBS_KHR:
        add_boxes(&input);
        break;
    case VK_GEOMETRY_TYPE_INSTANCES_KHR:
        add_instances(&input);
        break;
    default:
        break;
    }
}

/* ---- what the host has overwritten */

/* Call before the host submits or waits. It does not know yet that the builds are complete, so it
 * wrote too early whatever it has written by now. */
void hazards_look_at_inputs(struct layer_device *device)
{
    host_writes_look(device->host_writes);
}

/* Call before the host sets an event. It may have written in time for batches that wait. */
void hazards_forget_inputs(struct layer_device *device)
{
    host_writes_forget(device->host_writes);
}
