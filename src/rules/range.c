/* SPDX-License-Identifier: Apache-2.0 */
/* Rules about build ranges. */
#include "src/model/formats.h"
#include "src/model/geometry.h"
#include "src/rules/predicates.h"
#include "src/rules/shared.h"

/* Returns the triangles of a range. Returns NULL if its offsets are unknown or its geometry has
 * another type. */
static const VkAccelerationStructureGeometryTrianglesDataKHR *
triangles_of(const struct range_view *range)
{
    return range->range ? triangles_in(range->geometry->geometry) : NULL;
}

/* The id is of the indirect command only. */
static bool names_invalid_range(struct finding *finding)
{
    return also_violates(finding, RULE_indirect_build_ranges_are_valid);
}

bool index_offset_is_aligned(const struct range_view *range, struct finding *finding)
{
    const VkAccelerationStructureGeometryTrianglesDataKHR *triangles = triangles_of(range);
    uint32_t size = triangles ? index_type_size(triangles->indexType) : 0;
    return !size || range->range->primitiveOffset % size == 0 ||
           violated(finding, "primitiveOffset", "{} is not a multiple of the index size ({})",
                    number(range->range->primitiveOffset), number(size)) ||
           names_invalid_range(finding);
}

bool vertex_offset_is_aligned(const struct range_view *range, struct finding *finding)
{
    const VkAccelerationStructureGeometryTrianglesDataKHR *triangles = triangles_of(range);
    if (!triangles || triangles->indexType != VK_INDEX_TYPE_NONE_KHR)
        return true;
    uint32_t alignment = format_alignment(triangles->vertexFormat);
    return !alignment || range->range->primitiveOffset % alignment == 0 ||
           violated(finding, "primitiveOffset",
                    "{} is not a multiple of the component size of vertexFormat ({})",
                    number(range->range->primitiveOffset), number(alignment)) ||
           names_invalid_range(finding);
}

static bool offset_is_multiple(struct finding *finding, const char *field, uint32_t offset,
                               uint32_t alignment)
{
    return offset % alignment == 0 ||
           violated(finding, field, "{} is not a multiple of {}", number(offset),
                    number(alignment)) ||
           names_invalid_range(finding);
}

/* The valid usage applies even if the geometry has no transform data, which leaves transformOffset
 * unused. */
bool transform_offset_is_aligned(const struct range_view *range, struct finding *finding)
{
    return !triangles_of(range) ||
           offset_is_multiple(finding, "transformOffset", range->range->transformOffset, 16);
}

bool aabb_offset_is_aligned(const struct range_view *range, struct finding *finding)
{
    return !range->range || !aabbs_in(range->geometry->geometry) ||
           offset_is_multiple(finding, "primitiveOffset", range->range->primitiveOffset, 8);
}

bool instance_offset_is_aligned(const struct range_view *range, struct finding *finding)
{
    return !range->range || !instances_in(range->geometry->geometry) ||
           offset_is_multiple(finding, "primitiveOffset", range->range->primitiveOffset, 16);
}

/* A range without primitives uses no vertex. */
bool unindexed_vertices_are_within_max_vertex(const struct range_view *range,
                                              struct finding *finding)
{
    const VkAccelerationStructureGeometryTrianglesDataKHR *triangles = triangles_of(range);
    if (!triangles || triangles->indexType != VK_INDEX_TYPE_NONE_KHR ||
        !range->range->primitiveCount)
        return true;
    uint64_t last =
        (uint64_t)range->range->firstVertex + (uint64_t)range->range->primitiveCount * 3 - 1;
    return last <= triangles->maxVertex ||
           violated(finding, "primitiveCount",
                    "{} with firstVertex {} uses vertex {}, which exceeds maxVertex ({})",
                    number(range->range->primitiveCount), number(range->range->firstVertex),
                    number(last), number(triangles->maxVertex)) ||
           names_invalid_range(finding) ||
           ((uint64_t)range->range->primitiveCount * 3 > (uint64_t)triangles->maxVertex + 1 &&
            also_violates(finding, RULE_consumed_vertices_are_within_max_vertex));
}

/* ---- the end of buffers */

/* Other rules are about such counts. */
__attribute__((cold)) static bool has_wrong_count(const struct range_view *range)
{
    const VkAccelerationStructureGeometryTrianglesDataKHR *triangles = triangles_of(range);
    return range->primitive_count >
               range->geometry->build->call->device->limits.maxPrimitiveCount ||
           !instance_count_is_within_limit(range, NULL) ||
           (triangles && range->range->firstVertex > triangles->maxVertex) ||
           !unindexed_vertices_are_within_max_vertex(range, NULL);
}

/* If there are indices, they say which vertices are read: the one with firstVertex, or later ones.
 * Other rules are about strides that do not fit in 32 bits. */
static bool is_within_buffer(const struct range_view *range, const struct address_facts *facts,
                             const struct geometry_input *input, struct finding *finding)
{
    if (facts->status != ADDRESS_IN_BUFFER || input->stride > UINT32_MAX)
        return true;
    const uint64_t count = input->is_chosen ? 1 : input->count,
                   end = input_extent(input->offset, count - 1, input->stride, input->size);
    return end <= facts->bytes_left || range->continued_inputs & 1U << input->role ||
           has_wrong_count(range) ||
           violated(finding, "primitiveCount",
                    "{} makes the build read up to {} behind {} {}, {} past the end of {}",
                    number(range->primitive_count), count_of(end, "byte"),
                    phrase(input_field(input->role)), hex(facts->address),
                    count_of(end - facts->bytes_left, "byte"),
                    object(VK_OBJECT_TYPE_BUFFER, handle_number(facts->buffer)));
}

enum { VERTEX_SIZE_MAX = 32 }; /* bytes, of any format */

/* Whether there is room for the largest indices and vertices: most often so, and seen in two thirds
 * of the instructions. */
static inline bool
triangles_have_room(const struct range_view *range,
                    const VkAccelerationStructureGeometryTrianglesDataKHR *triangles)
{
    const VkAccelerationStructureBuildRangeInfoKHR *given = range->range;
    const bool has_indices = triangles->indexType != VK_INDEX_TYPE_NONE_KHR;
    const uint64_t corners = (uint64_t)given->primitiveCount * 3,
                   indices = given->primitiveOffset + corners * sizeof(uint32_t),
                   vertices = given->firstVertex * triangles->vertexStride + VERTEX_SIZE_MAX;
    return has_indices && !input_address(range->geometry->geometry, INPUT_MATRIX) &&
           indices <= range->geometry->index_data.bytes_left &&
           vertices <= range->geometry->vertex.bytes_left;
}

__attribute__((noinline)) static bool all_are_within_buffers(const struct range_view *range,
                                                             struct finding *finding)
{
    struct geometry_input inputs[GEOMETRY_INPUTS];
    const uint32_t count =
        inputs_of_geometry(0, range->geometry->geometry, NULL, range->range, inputs);
    for (uint32_t i = 0; i < count; i++)
        if (!is_within_buffer(range, input_facts(range->geometry, inputs[i].role), &inputs[i],
                              finding))
            return false;
    return true;
}

/* No sentence of the specification says so, but what lies behind a buffer may be unmapped.
 * Instances may have more bytes, with motion. */
bool inputs_are_read_within_their_buffers(const struct range_view *range, struct finding *finding)
{
    const VkAccelerationStructureGeometryKHR *geometry = range->geometry->geometry;
    if (!range->range || !range->range->primitiveCount)
        return true;
    const VkAccelerationStructureGeometryTrianglesDataKHR *triangles = triangles_in(geometry);
    if (triangles ? triangles_have_room(range, triangles)
                  : !aabbs_in(geometry) && !instances_in(geometry))
        return true;
    return all_are_within_buffers(range, finding);
}

bool instance_count_is_within_limit(const struct range_view *range, struct finding *finding)
{
    uint64_t limit = range->geometry->build->call->device->limits.maxInstanceCount;
    if (!type_is_instances(range->geometry->geometry->geometryType))
        return true;
    return range->primitive_count <= limit ||
           violated(finding, range->range ? "primitiveCount" : "",
                    "{} exceeds maxInstanceCount ({})", number(range->primitive_count),
                    number(limit));
}

/* The build ranges that the indirect command reads from a buffer. A build range is invalid if it
 * violates one of the rules above. Their messages name the id. */

bool indirect_build_ranges_are_valid(const struct indirect_range_view *indirect_range,
                                     struct finding *finding)
{
    const struct range_view range = {.geometry = indirect_range->geometry,
                                     .range = indirect_range->range,
                                     .primitive_count = indirect_range->range->primitiveCount};
#define HOLDS(name) (name(&range, finding) || is_reported_with(finding, RULE_##name))
    return HOLDS(index_offset_is_aligned) && HOLDS(vertex_offset_is_aligned) &&
           HOLDS(transform_offset_is_aligned) && HOLDS(aabb_offset_is_aligned) &&
           HOLDS(instance_offset_is_aligned) && HOLDS(unindexed_vertices_are_within_max_vertex);
#undef HOLDS
}

bool indirect_primitive_count_is_within_maximum(const struct indirect_range_view *indirect_range,
                                                struct finding *finding)
{
    uint32_t count = indirect_range->range->primitiveCount;
    return count <= indirect_range->max_primitive_count ||
           violated(finding, "",
                    "is {}, less than primitiveCount ({}) of the build range that was read",
                    number(indirect_range->max_primitive_count), number(count));
}
