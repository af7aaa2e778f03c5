/* SPDX-License-Identifier: Apache-2.0 */
/* Reads input data in place, once from begin to end. */
#include "src/check/content/content.h"

#include <stdlib.h>
#include <string.h>
#define XXH_INLINE_ALL
#include <xxhash.h>

#include "src/base/recording_path.h"
#include "src/bvh/input/formats.h"
#include "src/check/content/micromap.h"
#include "src/check/walk/rows.h"
#include "src/model/formats.h"
#include "src/model/geometry.h"
#include "src/rules/shared.h"

uint64_t content_find_some(const struct content *content, VkDeviceOrHostAddressConstKHR address,
                           uint64_t offset, uint64_t count, uint64_t stride, uint64_t size,
                           const void **bytes)
{
    const struct input_memory *memory = content->memory;
    const uint64_t begin = input_extent(address.deviceAddress, 1, offset, 0),
                   extent = count ? input_extent(0, count - 1, stride, size) : 0;
    *bytes = NULL;
    if (!address.deviceAddress || !count || begin == UINT64_MAX || extent == UINT64_MAX)
        return 0;
    return memory->find(memory->context, begin, extent, bytes);
}

const uint8_t *content_find(const struct content *content, VkDeviceOrHostAddressConstKHR address,
                            uint64_t offset, uint64_t count, uint64_t stride, uint64_t size)
{
    const void *bytes;
    const uint64_t found = content_find_some(content, address, offset, count, stride, size, &bytes);
    return found && found == input_extent(0, count - 1, stride, size) ? bytes : NULL;
}

const struct geometry_input *content_input(const struct content *content, enum input_role role)
{
    return input_of_role(content->inputs, content->input_count, role);
}

const uint8_t *content_find_input(const struct content *content, const struct geometry_input *input)
{
    return input ? content_find(content, input->address, input->offset, input->count, input->stride,
                                input->most)
                 : NULL;
}

uint64_t content_find_some_input(const struct content *content, const struct geometry_input *input,
                                 const void **bytes)
{
    *bytes = NULL;
    return input ? content_find_some(content, input->address, input->offset, input->count,
                                     input->stride, input->most, bytes)
                 : 0;
}

/* Instances of VK_NV_ray_tracing are a parameter of the command, not a geometry. */
static struct location location_of(const struct geometry_view *geometry)
{
    bool is_parameter =
        geometry->build->call->command == COMMAND_NV && instances_in(geometry->geometry);
    return walk_location(geometry, is_parameter ? SUBJECT_PARAMETER : SUBJECT_GEOMETRY);
}

#define EVALUATE_ELEMENT(name, level, view, location, element, number)                             \
    if (content->walk->active[RULE_##name] && !name(view, &finding))                               \
        content_found(content, RULE_##name, location, &finding, element, number);
#define WALK_ELEMENT(subject, location, element, number)                                           \
    void content_walk_##subject(struct content *content, const struct subject##_view *subject)     \
    {                                                                                              \
        struct finding finding;                                                                    \
        ROWS_OF_##subject(EVALUATE_ELEMENT, subject, location, element, number)                    \
    }
#define WALK_GEOMETRY(subject, element, number)                                                    \
    WALK_ELEMENT(subject, walk_location(subject->geometry, SUBJECT_GEOMETRY), element, number)

WALK_ELEMENT(indices, walk_location(indices->geometry, SUBJECT_RANGE), "more geometry", 0)
WALK_ELEMENT(transform, location_of(transform->geometry), "more instance", transform->instance)
WALK_ELEMENT(instance, location_of(instance->geometry), "more instance", instance->index)
WALK_ELEMENT(nv_instance, location_of(nv_instance->geometry), "more instance", nv_instance->index)
WALK_ELEMENT(reference, location_of(reference->geometry), "more instance", reference->instance)
WALK_GEOMETRY(motion_instance, "more instance", motion_instance->index)
WALK_GEOMETRY(instance_pointer, "more pointer", instance_pointer->index)
WALK_GEOMETRY(box, "more primitive", box->primitive)
WALK_GEOMETRY(radius, "more primitive", radius->primitive)
WALK_GEOMETRY(opacity_index, "more primitive", opacity_index->primitive)
WALK_GEOMETRY(micromap_triangle, "more triangle", micromap_triangle->index)

/* ---- triangles */

uint32_t content_read_index(const uint8_t *indices, uint32_t size, uint64_t position)
{
    uint32_t index = 0;
    uint16_t narrow;
    switch (size) {
    case sizeof(uint32_t):
        memcpy(&index, indices + position * sizeof(index), sizeof(index));
        return index;
    case sizeof(uint16_t):
        memcpy(&narrow, indices + position * sizeof(narrow), sizeof(narrow));
        return narrow;
    default:
        return indices[position];
    }
}

/* The number of vertices that count_vertices() can distinguish: larger indices are not counted. */
#define COUNTED_MAX (UINT32_C(1) << 27)

/* Returns the number of different vertices used, or `enough` if there are at least as many. */
static uint64_t count_vertices(const uint8_t *indices, uint32_t size, uint64_t count,
                               uint64_t enough)
{
    uint8_t *seen = calloc(COUNTED_MAX / 8, 1);
    uint64_t found = 0;
    for (uint64_t i = 0; seen && i < count && found < enough; i++) {
        uint32_t index = content_read_index(indices, size, i);
        uint8_t bit = (uint8_t)(1 << index % 8);
        if (index >= COUNTED_MAX || (seen[index / 8] & bit))
            continue;
        seen[index / 8] |= bit;
        found++;
    }
    free(seen);
    return found;
}

/* Finds the indices of triangles and the largest one. An update mostly has the indices of its
 * source, whose largest one is known. */
static void find_indices(struct content *content,
                         const VkAccelerationStructureGeometryTrianglesDataKHR *triangles)
{
    struct content_indices *indices = &content->indices;
    indices->size = index_type_size(triangles->indexType);
    indices->count = (uint64_t)content->range->range->primitiveCount * 3;
    indices->bytes = content_find_input(content, content_input(content, INPUT_INDEX));
    if (!indices->bytes)
        return;
    const struct geometry_inputs *source =
        build_inputs_of(content->walk->source_inputs, content->range->geometry->index);
    struct kept_indices *kept = source ? source->indices : NULL;
    bool is_same = kept && kept->size == indices->count * indices->size &&
                   memcmp(kept->bytes, indices->bytes, kept->size) == 0;
    indices->same = is_same ? kept : NULL;
    indices->max = is_same ? kept->max : indices_max(indices->bytes, indices->size, indices->count);
}

static uint32_t smallest_index(const struct content_indices *indices)
{
    uint32_t smallest = indices->max;
    for (uint64_t i = 0; i < indices->count && smallest; i++) {
        uint32_t index = content_read_index(indices->bytes, indices->size, i);
        smallest = index < smallest ? index : smallest;
    }
    return smallest;
}

uint64_t content_hash(const struct content_elements *elements, uint64_t hash)
{
    return XXH3_64bits_withSeed(elements->bytes, elements->size, hash);
}

/* Reports elements that the build has read, with their hash. */
static void report_elements(const struct content *content, const struct geometry_input *input,
                            uint64_t hash)
{
    const struct check_context *context = content->walk->context;
    const struct geometry_view *geometry = content->range->geometry;
    const struct elements_read read = {.address = input->address.deviceAddress + input->offset,
                                       .count = input->count,
                                       .stride = input->stride,
                                       .size = input->size,
                                       .hash = hash};
    if (geometry->build->call->command != COMMAND_NV)
        context->hooks->on_read(context->user, geometry->build->index, geometry->index, &read);
}

static void hash_and_report_elements(const struct content *content,
                                     const struct geometry_input *input)
{
    const struct check_context *context = content->walk->context;
    const uint8_t *bytes = context->hooks->on_read ? content_find_input(content, input) : NULL;
    const bool is_packed = input->stride == input->size;
    struct content_elements part = {bytes, is_packed ? input->count * input->size : input->size};
    uint64_t hash = 0;
    if (!bytes)
        return;
    for (uint64_t i = 0; i < (is_packed ? 1 : input->count); i++, part.bytes += input->stride)
        hash = content_hash(&part, hash);
    report_elements(content, input, hash);
}

/* Without indices all vertices are read; with them at least those of the smallest and the largest
 * one. */
static void report_vertices(const struct content *content, uint32_t smallest)
{
    const struct geometry_input *given = content_input(content, INPUT_VERTEX);
    if (!given || !given->size || given->offset == UINT64_MAX)
        return;
    struct geometry_input vertices = *given;
    if (given->is_chosen) {
        vertices.offset += smallest * given->stride;
        vertices.stride *= content->indices.max - smallest;
        vertices.count = 2;
    }
    hash_and_report_elements(content, &vertices);
}

/* Reports the smallest and the largest index, and vertices. */
static void report_triangles(const struct content *content)
{
    const struct check_context *context = content->walk->context;
    const struct content_indices *indices = &content->indices;
    const struct geometry_view *geometry = content->range->geometry;
    uint32_t smallest = 0;
    if (!context->hooks->on_index_range || (indices->size && !indices->bytes))
        return;
    if (indices->size) {
        smallest = smallest_index(indices);
        context->hooks->on_index_range(context->user, geometry->build->index, geometry->index,
                                       smallest, indices->max);
    }
    report_vertices(content, smallest);
}

/* More vertices than exist can be used only if an index exceeds maxVertex. */
static void view_indices(const struct content_indices *indices, struct indices_view *view)
{
    uint32_t first = view->range->firstVertex, max = view->max_vertex;
    uint64_t limit = first <= max ? (uint64_t)max - first + 1 : 0;
    if (indices->max < limit)
        return;
    for (uint64_t i = 0; i < indices->count; i++) {
        uint32_t index = content_read_index(indices->bytes, indices->size, i);
        if (index < limit)
            continue;
        view->is_beyond = true;
        view->primitive = (uint32_t)(i / 3);
        view->index = index;
        break;
    }
    if (view->is_beyond && indices->count > (uint64_t)max + 1)
        view->consumed =
            count_vertices(indices->bytes, indices->size, indices->count, (uint64_t)max + 2);
}

/* Compares the vertex of the largest index with the end of the buffer as it is now: unknown if any
 * object was destroyed since the build was submitted. */
static void find_past_end(const struct content *content, struct indices_view *view)
{
    const struct check_context *context = content->walk->context;
    const struct geometry_input *vertices = content_input(content, INPUT_VERTEX);
    struct address_facts begin, last;
    view->max = content->indices.max;
    if (!vertices || !vertices->size || vertices->stride > UINT32_MAX ||
        context->destroy_count != resources_destroy_count(context->resources))
        return;
    const uint64_t address = vertices->address.deviceAddress,
                   read =
                       input_extent(vertices->offset, view->max, vertices->stride, vertices->size),
                   end = input_extent(address, 1, read, 0);
    if (read == UINT64_MAX || end == UINT64_MAX)
        return;
    resources_look_up_address(context->resources, address, &begin);
    resources_look_up_address(context->resources, end - 1, &last);
    if (begin.status != ADDRESS_IN_BUFFER || begin.is_sparse || last.status != ADDRESS_NOWHERE)
        return;
    /* inputs_are_read_within_their_buffers() is about the vertex of firstVertex. */
    if (view->geometry->build->call->command == COMMAND_DEVICE &&
        vertices->offset + vertices->size > begin.bytes_left)
        return;
    view->buffer = begin.buffer;
    view->past_end = end - (begin.address + begin.bytes_left);
}

/* Not for VK_NV_ray_tracing: its geometries have no build ranges, which these rules are about. */
static void check_indices(struct content *content,
                          const VkAccelerationStructureGeometryTrianglesDataKHR *triangles)
{
    const VkAccelerationStructureBuildRangeInfoKHR *range = content->range->range;
    struct indices_view view = {
        .geometry = content->range->geometry, .range = range, .max_vertex = triangles->maxVertex};
    if (content->indices.bytes)
        view_indices(&content->indices, &view);
    else if (content->indices.size)
        return;
    else if (triangles->indexType == VK_INDEX_TYPE_NONE_KHR)
        view.consumed = content->indices.count;
    if (content->indices.bytes && content->range->geometry->build->call->command != COMMAND_HOST)
        find_past_end(content, &view);
    content_walk_indices(content, &view);
}

static void read_transform(struct content *content)
{
    struct transform_view view = {.geometry = content->range->geometry};
    const uint8_t *matrix = content_find_input(content, content_input(content, INPUT_MATRIX));
    if (!matrix)
        return;
    memcpy(&view.matrix, matrix, sizeof(view.matrix));
    content_walk_transform(content, &view);
}

/* ---- AABBs */

static void read_boxes(struct content *content)
{
    struct box_view view = {.geometry = content->range->geometry};
    const struct geometry_input *boxes = content_input(content, INPUT_AABBS);
    const uint8_t *first = content_find_input(content, boxes);
    if (!first)
        return;
    hash_and_report_elements(content, boxes);
    for (; view.primitive < boxes->count; view.primitive++) {
        memcpy(&view.positions, first + view.primitive * boxes->stride, sizeof(view.positions));
        content_walk_box(content, &view);
    }
}

/* ---- geometries */

static void begin_instances(struct content *content)
{
    for (struct build_reader *reader = content->walk->readers; reader; reader = reader->next)
        if (reader->on_instances)
            reader->on_instances(reader, content);
}

void content_check_geometry(struct walk *walk, const struct range_view *range,
                            const struct input_memory *memory, const struct chained_input *chained)
{
    const VkAccelerationStructureGeometryKHR *geometry = range->geometry->geometry;
    const VkAccelerationStructureGeometryTrianglesDataKHR *triangles = triangles_in(geometry);
    const VkAccelerationStructureGeometryAabbsDataKHR *aabbs = aabbs_in(geometry);
    const VkAccelerationStructureGeometryInstancesDataKHR *instances = instances_in(geometry);
    struct content content = {.walk = walk, .range = range, .memory = memory, .chained = chained};
    content.input_count = inputs_of_geometry(range->geometry->build->info->flags, geometry, chained,
                                             range->range, content.inputs);
    content_retain_count(&content);
    if (triangles) {
        find_indices(&content, triangles);
        report_triangles(&content);
        if (range->geometry->build->call->command != COMMAND_NV)
            check_indices(&content, triangles);
        read_transform(&content);
    }
    if (aabbs)
        read_boxes(&content);
    if (triangles || aabbs)
        content_retain_inputs(&content);
    if (range->geometry->build->call->device->extension.linear_swept_spheres_nv)
        content_read_radii(&content);
    if (instances) {
        begin_instances(&content);
        content_read_instances(&content);
    }
    if (content.hash)
        report_elements(&content, content_input(&content, INPUT_INSTANCES), content.hash);
    for (struct build_reader *reader = walk->readers; reader; reader = reader->next)
        if (reader->on_geometry)
            reader->on_geometry(reader, &content);
    content_report(&content);
}

/* Addresses are host pointers. If probing is disabled, all memory counts as readable; the limit
 * then keeps a wrong stride from causing hours of reading. */
#define EXTENT_MAX (SIZE_MAX >> 24)

static uint64_t find_in_host_memory(void *context, uint64_t address, uint64_t size,
                                    const void **bytes)
{
    *bytes = (const void *)(uintptr_t)address; // NOLINT(performance-no-int-to-ptr)
    return size < EXTENT_MAX ? readable_extent(context, *bytes, (size_t)size) : 0;
}

OFF_RECORDING_PATH void check_host_inputs(struct walk *walk, const struct range_view *range)
{
    const struct input_memory memory = {.find = find_in_host_memory,
                                        .context = walk->context->readable};
    /* Findings about data don't affect the size query. */
    uint32_t findings = walk->findings;
    struct chained_input chained = {0};
    const bool has_chain =
        range->geometry->chained &&
        chained_input_read(walk->context->readable, range->geometry->build->info->flags,
                           range->geometry->geometry, &chained);
    if (range->range)
        content_check_geometry(walk, range, &memory, has_chain ? &chained : NULL);
    if (type_is_micromap(range->geometry->geometry->geometryType))
        check_host_micromap(walk, range->geometry);
    walk->findings = findings;
}
