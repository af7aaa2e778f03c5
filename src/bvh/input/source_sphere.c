/* SPDX-License-Identifier: Apache-2.0 */
/* Reads spheres and linear swept spheres (VK_NV_ray_tracing_linear_swept_spheres). */
#include <math.h>
#include <string.h>

#include "src/bvh/input/formats.h"
#include "src/bvh/input/source.h"

bool sphere_formats_are_known(const struct builder_spheres *spheres)
{
    return vertex_format_find(spheres->vertex_format) &&
           radius_format_size(spheres->radius_format) && source_index_is_known(spheres->index_type);
}

/* Returns the number of readable elements of `size` bytes, from an offset and a first element
 * on. */
static uint64_t readable(uint64_t room, uint64_t offset, uint64_t size, uint64_t stride,
                         uint64_t first)
{
    uint64_t count = offset <= room ? source_elements_in(room - offset, size, stride) : 0;
    return count > first ? count - first : 0;
}

uint64_t sphere_element_count(const struct builder_spheres *spheres, bool is_swept, uint32_t count)
{
    bool is_shared = spheres->index_type != VK_INDEX_TYPE_NONE_KHR &&
                     spheres->indexing_mode == VK_RAY_TRACING_LSS_INDEXING_MODE_SUCCESSIVE_NV;
    return is_swept && !is_shared ? 2ull * count : count;
}

uint64_t sphere_vertex_count(const struct builder_spheres *spheres, bool is_swept,
                             const VkAccelerationStructureBuildRangeInfoKHR *range)
{
    uint64_t count = sphere_element_count(spheres, is_swept, range->primitiveCount);
    uint32_t size = index_type_size(spheres->index_type), last = 0;
    if (size == 0 || count == 0)
        return count;
    if (readable(spheres->indices_size, range->primitiveOffset, size, spheres->index_stride, 0) <
        count)
        return 0;
    const uint8_t *first = (const uint8_t *)spheres->indices + range->primitiveOffset;
    for (uint64_t i = 0; i < count; i++) {
        uint32_t index = source_read_number(first + i * spheres->index_stride, size);
        last = index > last ? index : last;
    }
    bool has_next =
        is_swept && spheres->indexing_mode == VK_RAY_TRACING_LSS_INDEXING_MODE_SUCCESSIVE_NV;
    return (uint64_t)last + 1 + has_next;
}

bool source_open_spheres(struct source *source, const struct builder_spheres *spheres,
                         bool is_swept, const VkAccelerationStructureBuildRangeInfoKHR *range)
{
    uint64_t offset = range->primitiveOffset, first = range->firstVertex;
    struct sphere_source *own = &source->spheres;
    source->format = vertex_format_find(spheres->vertex_format);
    source->stride = spheres->vertex_stride;
    source->index_size = index_type_size(spheres->index_type);
    own->is_half = spheres->radius_format == VK_FORMAT_R16_SFLOAT;
    own->radius_stride = spheres->radius_stride;
    own->index_stride = spheres->index_stride;
    own->is_successive = spheres->indexing_mode == VK_RAY_TRACING_LSS_INDEXING_MODE_SUCCESSIVE_NV;
    own->has_caps = spheres->end_caps_mode == VK_RAY_TRACING_LSS_PRIMITIVE_END_CAPS_MODE_CHAINED_NV;
    if (source->count == 0)
        return true;
    if (source->index_size > 0) {
        uint64_t needed = sphere_element_count(spheres, is_swept, source->count);
        if (readable(spheres->indices_size, offset, source->index_size, own->index_stride, 0) <
            needed)
            return false;
        source->indices = (const uint8_t *)spheres->indices + offset;
        offset = 0;
    }
    uint64_t vertices =
        readable(spheres->vertices_size, offset, source->format->size, source->stride, first);
    uint64_t radii =
        readable(spheres->radii_size, offset, radius_format_size(spheres->radius_format),
                 own->radius_stride, first);
    source->index_limit = vertices < radii ? vertices : radii;
    if (source->index_limit == 0)
        return true; /* nothing will be read, and the products below could wrap */
    source->vertices = (const uint8_t *)spheres->vertices + offset + source->stride * first;
    own->radii = (const uint8_t *)spheres->radii + offset + own->radius_stride * first;
    return true;
}

static uint32_t sphere_index(const struct source *source, uint64_t position)
{
    return source_read_number(source->indices + position * source->spheres.index_stride,
                              source->index_size);
}

/* A NaN in any component makes the sphere inactive. The behaviour of a negative radius is
 * undefined. */
static enum source_state read_sphere(const struct source *source, uint64_t index, float center[3],
                                     float *radius)
{
    if (index >= source->index_limit)
        return SOURCE_OUT_OF_RANGE;
    const uint8_t *from = source->spheres.radii + source->spheres.radius_stride * index;
    uint16_t half;
    source->format->read(source->vertices + source->stride * index, center);
    if (source->spheres.is_half) {
        memcpy(&half, from, sizeof(half));
        *radius = float_from_half(half);
    } else {
        memcpy(radius, from, sizeof(*radius));
    }
    *radius += 0.0f;
    for (int i = 0; i < 3; i++)
        center[i] += 0.0f;
    if (isnan(center[0]) || isnan(center[1]) || isnan(center[2]) || isnan(*radius))
        return SOURCE_INACTIVE;
    return *radius < 0 ? SOURCE_UNDEFINED : SOURCE_ACTIVE;
}

enum source_state source_sphere(const struct source *source, uint32_t primitive,
                                struct sphere_record *record)
{
    uint64_t index = source->indices ? sphere_index(source, primitive) : primitive;
    *record = (struct sphere_record){.geometry = 0};
    return read_sphere(source, index, record->center, &record->radius);
}

static void swept_ends(const struct source *source, uint32_t primitive, uint64_t ends[2])
{
    uint64_t position = (uint64_t)primitive * 2;
    if (!source->indices) {
        ends[0] = position;
        ends[1] = position + 1;
    } else if (source->spheres.is_successive) {
        ends[0] = sphere_index(source, primitive);
        ends[1] = ends[0] + 1;
    } else {
        ends[0] = sphere_index(source, position);
        ends[1] = sphere_index(source, position + 1);
    }
}

/* "VkRayTracingLssPrimitiveEndCapsModeNV": the first primitive of a chain has both caps, the others
 * only the trailing cap. A primitive continues the chain if it begins at the end of its
 * predecessor. */
static uint32_t swept_caps(const struct source *source, uint32_t primitive, const uint64_t ends[2])
{
    uint64_t before[2];
    if (!source->spheres.has_caps)
        return 0;
    if (primitive == 0 || !source->indices)
        return SWEPT_CAP_FIRST | SWEPT_CAP_LAST;
    swept_ends(source, primitive - 1, before);
    return before[1] == ends[0] ? SWEPT_CAP_LAST : SWEPT_CAP_FIRST | SWEPT_CAP_LAST;
}

enum source_state source_swept(const struct source *source, uint32_t primitive,
                               struct swept_record *record)
{
    uint64_t ends[2];
    *record = (struct swept_record){.geometry = 0};
    swept_ends(source, primitive, ends);
    record->caps = swept_caps(source, primitive, ends);
    enum source_state first = read_sphere(source, ends[0], record->a, &record->radius[0]);
    enum source_state last = read_sphere(source, ends[1], record->b, &record->radius[1]);
    if (first == SOURCE_OUT_OF_RANGE || last == SOURCE_OUT_OF_RANGE)
        return SOURCE_OUT_OF_RANGE;
    if (first == SOURCE_INACTIVE || last == SOURCE_INACTIVE)
        return SOURCE_INACTIVE;
    return last == SOURCE_ACTIVE ? first : last;
}
