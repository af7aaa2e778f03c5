/* SPDX-License-Identifier: Apache-2.0 */
/* Reads the radii of spheres and linear swept spheres with the reference builder's reader, and
 * evaluates their rules. Inactive primitives have no valid radius to check. */
#include "src/bvh/input/source.h"
#include "src/check/assemble/extended.h"
#include "src/check/content/content.h"
#include "src/rules/predicates.h"
#include "src/rules/shared.h"
#include "src/view/geometry_data.h"

static bool is_swept(const struct content *content)
{
    return content->range->geometry->geometry->geometryType ==
           VK_GEOMETRY_TYPE_LINEAR_SWEPT_SPHERES_NV;
}

/* If there are indices, they determine the number of vertices and radii. */
static bool find_arrays(const struct content *content, const struct sphere_data *from,
                        struct builder_spheres *to)
{
    const VkAccelerationStructureBuildRangeInfoKHR *range = content->range->range;
    const VkAccelerationStructureBuildRangeInfoKHR found = {.primitiveCount =
                                                                range->primitiveCount};
    uint32_t size = index_type_size(from->index_type);
    if (size) {
        uint64_t count = sphere_element_count(to, is_swept(content), range->primitiveCount);
        to->indices_size = content_find_some(content, from->indices, range->primitiveOffset, count,
                                             to->index_stride, size, &to->indices);
        if (!to->indices_size)
            return false;
    }
    uint64_t count = sphere_vertex_count(to, is_swept(content), &found);
    if (!count)
        return false;
    to->vertices_size = content_find_some(
        content, from->vertices, content_vertex_offset(range, size, to->vertex_stride), count,
        to->vertex_stride, vertex_format_find(to->vertex_format)->size, &to->vertices);
    to->radii_size = content_find_some(
        content, from->radii, content_vertex_offset(range, size, to->radius_stride), count,
        to->radius_stride, radius_format_size(to->radius_format), &to->radii);
    return to->vertices_size && to->radii_size;
}

static bool describe_without_data(const struct content *content, struct builder_geometry *described)
{
    struct swept_spheres_view view;
    if (content->chained)
        view_chained_spheres(content->range->geometry, &content->chained->spheres, &view);
    else
        view_spheres(content->range->geometry, &view);
    *described = (struct builder_geometry){
        .type = content->range->geometry->geometry->geometryType,
        .spheres = {.vertex_format = view.data.vertex_format,
                    .radius_format = view.data.radius_format,
                    .index_type = view.data.index_type,
                    .vertex_stride = view.data.vertex_stride,
                    .radius_stride = view.data.radius_stride,
                    .index_stride = view.data.index_stride,
                    .indexing_mode = view.indexing_mode},
    };
    return view.data.given && sphere_formats_are_known(&described->spheres) &&
           find_arrays(content, &view.data, &described->spheres);
}

static enum source_state read_radius(const struct source *source, struct radius_view *view)
{
    struct sphere_record sphere;
    struct swept_record swept;
    enum source_state state;
    if (view->is_swept) {
        state = source_swept(source, view->primitive, &swept);
        view->radius = swept.radius[0] < 0 ? swept.radius[0] : swept.radius[1];
    } else {
        state = source_sphere(source, view->primitive, &sphere);
        view->radius = sphere.radius;
    }
    return state;
}

/* Returns how many primitives to read. Without indices, every primitive after the first unreadable
 * one is unreadable. */
static uint64_t readable_primitive_count(const struct source *source)
{
    bool has_end = source->index_size == 0 && source->index_limit < source->count;
    return has_end ? source->index_limit : source->count;
}

void content_read_radii(struct content *content)
{
    struct radius_view view = {.geometry = content->range->geometry, .is_swept = is_swept(content)};
    struct builder_geometry described;
    struct source source = {0};
    if (!describe_without_data(content, &described) ||
        !content_open_source(content, &described, &source))
        return;
    const uint64_t count = readable_primitive_count(&source);
    for (; view.primitive < count; view.primitive++)
        if (read_radius(&source, &view) == SOURCE_UNDEFINED)
            content_walk_radius(content, &view);
}

static bool is_not_negative(const struct radius_view *radius, struct finding *finding,
                            enum input_role role)
{
    return radius->radius >= 0 || violated(finding, content_field(radius->geometry, role),
                                           "leads to primitive {}, whose radius {} is less than 0",
                                           number(radius->primitive), real(radius->radius));
}

bool spheres_radii_are_not_negative(const struct radius_view *radius, struct finding *finding)
{
    return radius->is_swept || is_not_negative(radius, finding, INPUT_SPHERE_RADIUS);
}

bool swept_spheres_radii_are_not_negative(const struct radius_view *radius, struct finding *finding)
{
    return !radius->is_swept || is_not_negative(radius, finding, INPUT_SWEPT_RADIUS);
}
