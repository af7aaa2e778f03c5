/* SPDX-License-Identifier: Apache-2.0 */
/* Rules about the data of triangles and AABBs, and about transforms. */
#include <math.h>

#include "src/bvh/bvh.h"
#include "src/model/formats.h"
#include "src/model/geometry.h"
#include "src/rules/predicates.h"
#include "src/rules/shared.h"

/* ---- vertices */

static uint64_t vertex_count(const struct indices_view *indices)
{
    return (uint64_t)indices->max_vertex + 1;
}

/* Draws may have primitive restart, builds do not. */
static const char *restart_note(const struct indices_view *indices)
{
    const VkAccelerationStructureGeometryTrianglesDataKHR *triangles =
        triangles_in(indices->geometry->geometry);
    const uint32_t bits = 8 * index_type_size(triangles->indexType);
    const bool is_restart = bits && indices->index == UINT32_MAX >> (32 - bits);
    return is_restart ? " (primitive restart, which builds do not have)" : "";
}

bool indices_are_within_max_vertex(const struct indices_view *indices, struct finding *finding)
{
    uint32_t first = indices->range->firstVertex;
    return !indices->is_beyond ||
           violated(finding, "firstVertex",
                    "{} plus index {}{} of primitive {} is vertex {}, which exceeds maxVertex ({})",
                    number(first), number(indices->index), phrase(restart_note(indices)),
                    number(indices->primitive), number((uint64_t)first + indices->index),
                    number(indices->max_vertex)) ||
           (indices->consumed > vertex_count(indices) &&
            also_violates(finding, RULE_consumed_vertices_are_within_max_vertex));
}

/* If the index exceeds maxVertex, other rules report it. */
bool indexed_vertices_are_within_their_buffer(const struct indices_view *indices,
                                              struct finding *finding)
{
    return !indices->past_end || indices->is_beyond ||
           violated(finding, "firstVertex",
                    "{} plus the largest index ({}) makes the build read a vertex that ends {} "
                    "past the end of {}",
                    number(indices->range->firstVertex), number(indices->max),
                    count_of(indices->past_end, "byte"),
                    object(VK_OBJECT_TYPE_BUFFER, handle_number(indices->buffer)));
}

/* A build range that consumes more vertices than maxVertex allows also exceeds maxVertex, by an
 * index or without indices. That message names this id. */
bool consumed_vertices_are_within_max_vertex(const struct indices_view *indices,
                                             struct finding *finding)
{
    uint64_t given = vertex_count(indices);
    return indices->consumed <= given ||
           violated(finding, "primitiveCount",
                    "{} consumes at least {}, more than maxVertex + 1 ({})",
                    number(indices->range->primitiveCount), count_of(indices->consumed, "vertex"),
                    number(given)) ||
           is_reported_with(finding, indices->is_beyond
                                         ? RULE_indices_are_within_max_vertex
                                         : RULE_unindexed_vertices_are_within_max_vertex);
}

/* ---- AABBs. If minX is NaN, the AABB is inactive and its other values are ignored. Any other NaN
 * violates the comparison. */

static bool is_at_most(const struct box_view *box, struct finding *finding, const char *says,
                       float min, float max)
{
    return min <= max || isnan(box->positions.minX) ||
           violated(finding, content_field(box->geometry, INPUT_AABBS), says,
                    number(box->primitive), real(min), real(max));
}

#define LEADS_TO(min, max)                                                                         \
    "leads to primitive {}, whose " min " {} is not less than or equal to " max " ({})"

bool aabb_min_x_is_at_most_max_x(const struct box_view *box, struct finding *finding)
{
    return is_at_most(box, finding, LEADS_TO("minX", "maxX"), box->positions.minX,
                      box->positions.maxX);
}

bool aabb_min_y_is_at_most_max_y(const struct box_view *box, struct finding *finding)
{
    return is_at_most(box, finding, LEADS_TO("minY", "maxY"), box->positions.minY,
                      box->positions.maxY);
}

bool aabb_min_z_is_at_most_max_z(const struct box_view *box, struct finding *finding)
{
    return is_at_most(box, finding, LEADS_TO("minZ", "maxZ"), box->positions.minZ,
                      box->positions.maxZ);
}

/* ---- transforms */

static bool is_finite(const VkTransformMatrixKHR *matrix)
{
    for (int row = 0; row < 3; row++)
        for (int column = 0; column < 3; column++)
            if (!isfinite(matrix->matrix[row][column]))
                return false;
    return true;
}

bool transform_matrix_is_invertible(const struct transform_view *transform, struct finding *finding)
{
    if (builder_determinant_sign(&transform->matrix) != 0)
        return true;
    struct value why = phrase(is_finite(&transform->matrix) ? "have determinant 0"
                                                            : "have an element that is not finite");
    if (transform->is_of_instance)
        return violated(
            finding, content_field(transform->geometry, INPUT_INSTANCES),
            "leads to instance {}, whose transform is not invertible: its first three columns {}",
            number(transform->instance), why);
    return violated(finding, content_field(transform->geometry, INPUT_MATRIX),
                    "leads to a matrix that is not invertible: its first three columns {}", why);
}
