/* SPDX-License-Identifier: Apache-2.0 */
/* Advice about input data: legal, and hardly meant. The name of the structure precedes the
 * sentence. */
#include "src/advice/rules.h"
#include "src/model/formats.h"
#include "src/model/geometry.h"
#include "src/view/names.h"

static uint32_t limit_of(const struct advice_limits *limits, enum advice_limit limit)
{
    return limits->of[limit];
}

static const VkAccelerationStructureGeometryTrianglesDataKHR *
triangles_of(const struct mesh_view *mesh)
{
    return triangles_in(mesh->geometry->geometry);
}

static struct value triangle_count(uint64_t count)
{
    return count_of(count, "triangle");
}

static bool overlap(const struct mesh_view *mesh)
{
    const VkDeviceSize stride = triangles_of(mesh)->vertexStride;
    return stride && stride < format_position_size(triangles_of(mesh)->vertexFormat);
}

/* The triangles that are read are not those of the mesh, whatever else they are. */
static bool is_misread(const struct mesh_view *mesh)
{
    return mesh->other || overlap(mesh) || mesh->smooth;
}

/* ---- triangles */

/* An update may give degenerate triangles an area, but makes no inactive one active. */
bool most_triangles_can_be_hit(const struct mesh_view *mesh, struct finding *finding,
                               uint64_t *weight)
{
    const struct triangle_figures *figures = mesh->figures;
    const uint64_t dead = figures->inactive + figures->degenerate;
    const bool may_grow =
        mesh->geometry->build->info->flags & VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_UPDATE_BIT_KHR;
    const uint64_t wasted = may_grow && dead < figures->count ? figures->inactive : dead;
    const uint32_t first =
        !figures->inactive ? figures->first_degenerate
        : !figures->degenerate || figures->first_inactive < figures->first_degenerate
            ? figures->first_inactive
            : figures->first_degenerate;
    *weight = wasted;
    return is_misread(mesh) || figures->count < limit_of(mesh->limits, ADVICE_LIMIT_triangles) ||
           wasted * 100 <= figures->count * limit_of(mesh->limits, ADVICE_LIMIT_unhit_percent) ||
           violated(finding, "",
                    "was built from pGeometries[{}] with {}, of which {} are inactive and {} are "
                    "degenerate, the first one triangle {}: no ray can hit those",
                    number(mesh->geometry->index), triangle_count(figures->count),
                    number(figures->inactive), number(figures->degenerate), number(first));
}

/* NaN in X makes a triangle inactive; the specification leaves NaN in Y or Z alone undefined. */
bool vertices_are_numbers(const struct mesh_view *mesh, struct finding *finding, uint64_t *weight)
{
    const struct triangle_figures *figures = mesh->figures;
    *weight = figures->undefined;
    return is_misread(mesh) || !figures->undefined ||
           violated(finding, "",
                    "was built from pGeometries[{}] with {}, of which {} have a vertex with NaN in "
                    "Y or Z and not in X, the first one triangle {}: what a ray hits there is "
                    "undefined",
                    number(mesh->geometry->index), triangle_count(figures->count),
                    number(figures->undefined), number(figures->first_undefined));
}

/* A stride of 0 is a way to repeat one vertex. */
bool vertices_do_not_overlap(const struct mesh_view *mesh, struct finding *finding,
                             uint64_t *weight)
{
    const VkAccelerationStructureGeometryTrianglesDataKHR *triangles = triangles_of(mesh);
    *weight = mesh->figures->count;
    return !overlap(mesh) || !mesh->figures->measured ||
           violated(
               finding, "",
               "was built from pGeometries[{}], whose vertexStride {} is less than the {} that "
               "the position of a vertex has: the vertices overlap",
               number(mesh->geometry->index), number(triangles->vertexStride),
               count_of(format_position_size(triangles->vertexFormat), "byte"));
}

bool triangles_do_not_jump(const struct mesh_view *mesh, struct finding *finding, uint64_t *weight)
{
    const struct other_stride *smooth = mesh->smooth;
    *weight = mesh->figures->count;
    return mesh->other || overlap(mesh) || !smooth ||
           violated(
               finding, "",
               "was built from pGeometries[{}], whose triangles jump across it with vertexStride "
               "{}. With {}, nine of ten are smaller than {}, and all together than {}",
               number(mesh->geometry->index), number(triangles_of(mesh)->vertexStride),
               number(smooth->stride), real(smooth->small), real(smooth->extent));
}

bool vertices_have_one_layout(const struct mesh_view *mesh, struct finding *finding,
                              uint64_t *weight)
{
    const struct vertex_layout *other = mesh->contradicting;
    *weight = mesh->figures->count;
    if (is_misread(mesh) || !other)
        return true;
    return other->stride != mesh->layout->stride
               ? violated(finding, "",
                          "was built from pGeometries[{}] and pGeometries[{}], which read the same "
                          "bytes as vertices with vertexStride {} and {}",
                          number(other->geometry), number(mesh->geometry->index),
                          number(other->stride), number(mesh->layout->stride))
               : violated(finding, "",
                          "was built from pGeometries[{}] and pGeometries[{}], which read the same "
                          "vertices with vertexFormat {} and {}",
                          number(other->geometry), number(mesh->geometry->index),
                          format((VkFormat)other->format), format((VkFormat)mesh->layout->format));
}

static const char *index_type_of(uint32_t size)
{
    return size == sizeof(uint8_t)    ? "VK_INDEX_TYPE_UINT8"
           : size == sizeof(uint16_t) ? "VK_INDEX_TYPE_UINT16"
                                      : "VK_INDEX_TYPE_UINT32";
}

bool indices_have_their_type(const struct mesh_view *mesh, struct finding *finding,
                             uint64_t *weight)
{
    *weight = mesh->figures->count;
    return !mesh->other ||
           violated(
               finding, "",
               "was built from pGeometries[{}] with indexType {}, whose index data looks like {}: "
               "read so, it is {} of vertices 0 to {}; as it is, {}",
               number(mesh->geometry->index), phrase(index_type_of(mesh->index_size)),
               phrase(index_type_of(mesh->other->size)), triangle_count(mesh->other->triangles),
               number(mesh->other->max),
               phrase(mesh->other->size > mesh->index_size
                          ? "every second triangle or more has an index twice"
                          : "less than a hundredth of the vertices is used"));
}

/* ---- coordinates */

/* To move the vertices helps if they are far from the origin, compared with their extent. */
bool coordinates_are_fine_enough(const struct mesh_view *mesh, struct finding *finding,
                                 uint64_t *weight)
{
    const struct triangle_figures *figures = mesh->figures;
    *weight = figures->coarse;
    return is_misread(mesh) || figures->measured < limit_of(mesh->limits, ADVICE_LIMIT_triangles) ||
           !figures->coarse || figures->coarse * 2 < figures->measured ||
           violated(
               finding, "",
               "was built from pGeometries[{}], whose coordinates reach {}, where the next float "
               "is {} away. That is too coarse for {}, the first one triangle {}, whose extent "
               "is {}",
               number(mesh->geometry->index), real(figures->farthest), real(figures->step),
               triangle_count(figures->coarse), number(figures->first_coarse),
               real(figures->smallest_coarse));
}

bool no_vertex_is_far_from_all_others(const struct mesh_view *mesh, struct finding *finding,
                                      uint64_t *weight)
{
    const struct triangle_figures *figures = mesh->figures;
    const double limit = (double)limit_of(mesh->limits, ADVICE_LIMIT_stray_times);
    *weight = figures->count;
    return is_misread(mesh) || !mesh->stray ||
           figures->measured < limit_of(mesh->limits, ADVICE_LIMIT_triangles) ||
           figures->extent < limit * figures->median ||
           violated(finding, "",
                    "was built from pGeometries[{}], whose extent is {} with one vertex and {} "
                    "without it: that of triangle {} whose x is {}",
                    number(mesh->geometry->index), real(figures->extent), real(mesh->stray->extent),
                    number(mesh->stray->triangle), real(mesh->stray->position[0]));
}

/* ---- instances */

bool transforms_are_stored_by_rows(const struct placing_view *placing, struct finding *finding,
                                   uint64_t *weight)
{
    uint32_t first;
    *weight = placing->figures->placed;
    return !instances_are_stored_by_columns(placing->figures, &first) ||
           violated(
               finding, "",
               "was built from {} whose transforms look as if they were stored by columns, the "
               "first one instance {}",
               count_of(placing->figures->placed, "instance"), number(first));
}

bool transforms_keep_their_inverse(const struct placing_view *placing, struct finding *finding,
                                   uint64_t *weight)
{
    const struct instance_figures *figures = placing->figures;
    uint32_t first;
    *weight = figures->lossy;
    return !figures->lossy || instances_are_stored_by_columns(figures, &first) ||
           violated(
               finding, "",
               "was built from {} whose transform is nearly singular, the first one instance {}: "
               "the inverse loses {} of the 24 bits of a float",
               count_of(figures->lossy, "instance"), number(figures->first_lossy),
               number((uint64_t)figures->lost_bits));
}

bool no_instance_repeats_another(const struct placing_view *placing, struct finding *finding,
                                 uint64_t *weight)
{
    const struct instance_figures *figures = placing->figures;
    *weight = figures->repeated;
    return !figures->repeated ||
           violated(
               finding, "",
               "was built from {}. Instance {} has the structure, transform, flags and SBT offset "
               "of instance {}, and a mask that overlaps with its mask",
               count_of(figures->repeated, "repeated instance"), number(figures->first_repeated),
               number(figures->twin));
}

/* If one of these has another advice about its place, that explains the boxes. An unknown box may
 * make the box around all larger. */
bool instances_overlap_little(const struct placing_view *placing, struct finding *finding,
                              uint64_t *weight)
{
    const struct instance_figures *figures = placing->figures;
    const double depth = box_figures_depth(&figures->boxes);
    uint32_t first;
    *weight = figures->placed;
    return figures->unboxed || figures->singular || figures->repeated ||
           depth < limit_of(placing->limits, ADVICE_LIMIT_overlap) ||
           instances_are_stored_by_columns(figures, &first) ||
           violated(finding, "",
                    "was built from {} whose boxes overlap: a random point of the box around all "
                    "lies in {} of them on average, and a random line through it meets {}",
                    count_of(figures->placed, "instance"), real(depth),
                    real(box_figures_met(&figures->boxes)));
}
