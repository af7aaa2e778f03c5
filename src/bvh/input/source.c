/* SPDX-License-Identifier: Apache-2.0 */
/* Reads the primitives of a geometry and determines which are active ("Inactive Primitives and
 * Instances" of the specification). */
#include "src/bvh/input/source.h"

#include <math.h>
#include <string.h>

#include "src/bvh/input/formats.h"

uint64_t source_elements_in(uint64_t room, uint64_t size, uint64_t stride)
{
    if (room < size)
        return 0;
    return stride == 0 ? UINT64_MAX : (room - size) / stride + 1;
}

bool source_index_is_known(VkIndexType type)
{
    return type == VK_INDEX_TYPE_NONE_KHR || index_type_size(type) > 0;
}

static bool open_transform(struct source *source, const struct builder_triangles *triangles,
                           uint32_t offset)
{
    source->has_transform = triangles->transforms != NULL;
    if (!source->has_transform)
        return true;
    if (triangles->transforms_size < sizeof(source->transform) ||
        offset > triangles->transforms_size - sizeof(source->transform))
        return false;
    memcpy(&source->transform, (const uint8_t *)triangles->transforms + offset,
           sizeof(source->transform));
    return true;
}

bool source_open_indices(struct micromap_indices *indices, VkIndexType type, uint32_t base,
                         const void *data, uint64_t size, uint64_t stride, uint64_t count)
{
    uint32_t index_size = index_type_size(type);
    *indices =
        (struct micromap_indices){index_size > 0 ? data : NULL, stride, index_size, base, true};
    return index_size == 0 || count == 0 || source_elements_in(size, index_size, stride) >= count;
}

static bool open_opacity(struct source *source, const struct builder_opacity *opacity,
                         uint64_t count)
{
    if (!opacity)
        return true;
    return source_open_indices(&source->opacity, opacity->index_type, opacity->base_triangle,
                               opacity->indices, opacity->indices_size, opacity->stride, count);
}

static bool open_triangles(struct source *source, const struct builder_triangles *triangles,
                           const VkAccelerationStructureBuildRangeInfoKHR *range)
{
    source->format = vertex_format_find(triangles->vertex_format);
    source->stride = triangles->vertex_stride;
    source->index_size = index_type_size(triangles->index_type);
    uint64_t vertex_offset = 0;
    if (source->index_size > 0) {
        uint64_t needed = (uint64_t)range->primitiveCount * 3 * source->index_size;
        if (needed > 0 && (range->primitiveOffset > triangles->indices_size ||
                           needed > triangles->indices_size - range->primitiveOffset))
            return false;
        if (triangles->indices)
            source->indices = (const uint8_t *)triangles->indices + range->primitiveOffset;
    } else {
        vertex_offset = range->primitiveOffset;
    }
    if (source->count == 0)
        return true;
    uint64_t size = triangles->vertices_size;
    bool is_moving = source->has_motion && triangles->motion_vertices;
    if (is_moving && triangles->motion_vertices_size < size)
        size = triangles->motion_vertices_size;
    if (vertex_offset > size)
        return false;
    uint64_t readable =
        source_elements_in(size - vertex_offset, source->format->size, source->stride);
    /* If any vertex from the first on is readable, the product is within vertices_size. */
    uint64_t first = range->firstVertex;
    uint64_t limit = readable > first ? readable - first : 0;
    if (limit > (uint64_t)triangles->max_vertex + 1)
        limit = (uint64_t)triangles->max_vertex + 1;
    source->index_limit = limit;
    uint64_t to_first = vertex_offset + (limit > 0 ? source->stride * first : 0);
    if (triangles->vertices)
        source->vertices = (const uint8_t *)triangles->vertices + to_first;
    if (is_moving)
        source->motion_vertices = (const uint8_t *)triangles->motion_vertices + to_first;
    source->is_plain = source->index_size == 4 && !source->has_transform &&
                       source->format->format == VK_FORMAT_R32G32B32_SFLOAT;
    return true;
}

bool source_open_array(struct source *source, const void *data, uint64_t size, uint64_t element,
                       uint64_t stride, const VkAccelerationStructureBuildRangeInfoKHR *range)
{
    source->stride = stride;
    if (source->count == 0)
        return true;
    if (range->primitiveOffset > size ||
        source_elements_in(size - range->primitiveOffset, element, stride) < source->count)
        return false;
    source->data = (const uint8_t *)data + range->primitiveOffset;
    return true;
}

static bool open_dense(struct source *source, const struct builder_dense *dense)
{
    source->max_primitive = dense->max_primitive;
    return open_opacity(source, dense->opacity,
                        source->count > 0 ? (uint64_t)dense->max_primitive + 1 : 0);
}

bool source_open(struct source *source, bool has_motion, const struct builder_geometry *geometry,
                 const VkAccelerationStructureBuildRangeInfoKHR *range)
{
    uint32_t first = source->first;
    *source =
        (struct source){.first = first, .count = range->primitiveCount, .has_motion = has_motion};
    switch (geometry->type) {
    case VK_GEOMETRY_TYPE_TRIANGLES_KHR:
        return open_transform(source, &geometry->triangles, range->transformOffset) &&
               open_opacity(source, geometry->triangles.opacity, source->count) &&
               open_triangles(source, &geometry->triangles, range);
    case VK_GEOMETRY_TYPE_AABBS_KHR:
        return source_open_array(source, geometry->aabbs.data, geometry->aabbs.size,
                                 sizeof(VkAabbPositionsKHR), geometry->aabbs.stride, range);
    case VK_GEOMETRY_TYPE_SPHERES_NV:
        return source_open_spheres(source, &geometry->spheres, false, range);
    case VK_GEOMETRY_TYPE_LINEAR_SWEPT_SPHERES_NV:
        return source_open_spheres(source, &geometry->spheres, true, range);
    case VK_GEOMETRY_TYPE_DENSE_GEOMETRY_FORMAT_TRIANGLES_AMDX:
        return open_dense(source, &geometry->dense);
    case VK_GEOMETRY_TYPE_INSTANCES_KHR:
        return source_open_instances(source, &geometry->instances, range);
    default:
        return false;
    }
}

uint32_t source_read_number(const uint8_t *from, uint32_t size)
{
    uint32_t wide;
    uint16_t narrow;
    switch (size) {
    case 4:
        memcpy(&wide, from, sizeof(wide));
        return wide;
    case 2:
        memcpy(&narrow, from, sizeof(narrow));
        return narrow;
    default:
        return *from;
    }
}

static uint32_t read_index(const struct source *source, uint64_t position)
{
    return source_read_number(source->indices + position * source->index_size, source->index_size);
}

/* The special indices of a type are its four greatest values: -1 to -4. */
uint64_t source_micromap_index(const struct micromap_indices *indices, uint32_t primitive)
{
    if (!indices->indices)
        return primitive;
    uint64_t index =
        source_read_number(indices->indices + indices->stride * primitive, indices->index_size);
    uint64_t beyond = ((uint64_t)1 << 8 * indices->index_size) - index; /* 1 for -1 */
    return -beyond >= SOURCE_SPECIAL ? -beyond : index;
}

uint32_t source_opacity(const struct source *source, uint32_t primitive)
{
    uint64_t index = source_micromap_index(&source->opacity, primitive);
    if (index >= SOURCE_SPECIAL)
        return (uint32_t)index;
    index += source->opacity.base + (uint64_t)1;
    return index < OPACITY_SPECIAL ? (uint32_t)index : OPACITY_SPECIAL - 1;
}

void source_transform(const VkTransformMatrixKHR *transform, const double from[3], float to[3])
{
    for (int row = 0; row < 3; row++) {
        const float *m = transform->matrix[row];
        to[row] = (float)(m[0] * from[0] + m[1] * from[1] + m[2] * from[2] + m[3]);
    }
}

/* Tests for NaN before the transform. Removes the sign of zeros, so that bounds do not depend on
 * the order in which they are merged. */
static enum source_state read_vertex(const struct source *source, uint64_t index, float position[3])
{
    source->format->read(source->vertices + source->stride * index, position);
    enum source_state state = SOURCE_ACTIVE;
    if (source->format->has_nan) {
        if (isnan(position[0]))
            return SOURCE_INACTIVE;
        if (isnan(position[1]) || isnan(position[2]))
            state = SOURCE_UNDEFINED;
    }
    if (source->has_transform) {
        const double given[3] = {position[0], position[1], position[2]};
        source_transform(&source->transform, given, position);
    }
    for (int i = 0; i < 3; i++)
        position[i] += 0.0f;
    return state;
}

bool source_corners(const struct source *source, uint32_t primitive, uint64_t index[3])
{
    for (uint32_t i = 0; i < 3; i++) {
        uint64_t position = (uint64_t)primitive * 3 + i;
        index[i] = source->indices ? read_index(source, position) : position;
        if (index[i] >= source->index_limit)
            return false;
    }
    return true;
}

/* If triangles use few of many vertices, it is faster to read the triangles. */
enum { VERTICES_PER_TRIANGLE = 4 };

bool source_triangles_are_active(const struct source *source, uint32_t index_max)
{
    const uint64_t corners = (uint64_t)source->count * 3;
    if (!corners)
        return true;
    const uint64_t vertices = source->indices ? (uint64_t)index_max + 1 : corners;
    if (vertices > source->index_limit)
        return false;
    if (!source->format->has_nan)
        return true;
    return source->format->format == VK_FORMAT_R32G32B32_SFLOAT &&
           vertices <= (uint64_t)source->count * VERTICES_PER_TRIANGLE &&
           !positions_have_nan(source->vertices, source->stride, vertices);
}

enum source_state source_triangle(const struct source *source, uint32_t primitive,
                                  struct triangle_record *record)
{
    if (source->is_plain && source_read_plain(source, primitive, record))
        return SOURCE_ACTIVE;
    float *corners[3] = {record->a, record->b, record->c};
    uint64_t index[3];
    if (!source_corners(source, primitive, index))
        return SOURCE_OUT_OF_RANGE;
    enum source_state state = SOURCE_ACTIVE;
    for (int i = 0; i < 3; i++) {
        enum source_state vertex = read_vertex(source, index[i], corners[i]);
        if (vertex == SOURCE_INACTIVE)
            return SOURCE_INACTIVE;
        if (vertex == SOURCE_UNDEFINED)
            state = SOURCE_UNDEFINED;
    }
    return state;
}

enum source_state source_motion_triangle(const struct source *source, uint32_t primitive,
                                         struct motion_triangle_record *record)
{
    enum source_state found = source_triangle(source, primitive, &record->at[0]);
    if (found != SOURCE_ACTIVE)
        return found;
    record->at[1] = record->at[0];
    if (!source->motion_vertices)
        return SOURCE_ACTIVE;
    struct source then = *source;
    then.vertices = source->motion_vertices;
    return source_triangle(&then, primitive, &record->at[1]);
}

enum source_state source_dense(const struct source *source, uint32_t primitive,
                               struct dense_record *record)
{
    const struct dense_triangle *from = &source->dense[primitive];
    memcpy(record->triangle.a, from->a, sizeof(from->a));
    memcpy(record->triangle.b, from->b, sizeof(from->b));
    memcpy(record->triangle.c, from->c, sizeof(from->c));
    record->geometry = from->geometry;
    record->primitive = from->primitive;
    record->is_opaque = from->is_opaque;
    record->spare = 0;
    if (from->found == SOURCE_ACTIVE && from->primitive > source->max_primitive)
        return SOURCE_UNDEFINED;
    return from->found;
}

/* Prefetches only for source_read_plain(). Ignores an index that is out of range. */
void source_prefetch_vertices(const struct source *source, uint32_t primitive)
{
    if (!source->is_plain)
        return;
    uint32_t index[3];
    memcpy(index, source->indices + (uint64_t)primitive * sizeof(index), sizeof(index));
    for (int i = 0; i < 3; i++)
        if (index[i] < source->index_limit)
            __builtin_prefetch(source->vertices + source->stride * index[i]);
}

enum source_state source_aabb(const struct source *source, uint32_t primitive,
                              struct aabb_record *record)
{
    VkAabbPositionsKHR box;
    memcpy(&box, source->data + source->stride * primitive, sizeof(box));
    float all[6] = {box.minX, box.minY, box.minZ, box.maxX, box.maxY, box.maxZ};
    if (isnan(all[0]))
        return SOURCE_INACTIVE;
    for (int i = 0; i < 6; i++) {
        if (isnan(all[i]))
            return SOURCE_UNDEFINED;
        all[i] += 0.0f;
    }
    memcpy(record->lower, all, sizeof(record->lower));
    memcpy(record->upper, all + 3, sizeof(record->upper));
    return SOURCE_ACTIVE;
}
