/* SPDX-License-Identifier: Apache-2.0 */
/* Reads the radii of spheres and linear swept spheres with the reference builder's reader, and
 * evaluates their rules. Inactive primitives have no valid radius to check. */
#include "src/bvh/input/source.h"
#include "src/check/content/content.h"
#include "src/model/geometry.h"
#include "src/rules/predicates.h"
#include "src/rules/shared.h"
#include "src/snapshots/build_input.h"

static bool is_swept(const struct content *content)
{
    return type_is_swept_spheres(content->range->geometry->geometry->geometryType);
}

/* If there are indices, they determine the number of vertices and radii. */
static uint64_t find_elements(const struct content *content, enum input_role role, uint64_t count,
                              const void **bytes)
{
    const struct geometry_input *given = content_input(content, role);
    struct geometry_input input = given ? *given : (struct geometry_input){0};
    input.count = count;
    return content_find_some_input(content, &input, bytes);
}

static bool find_arrays(const struct content *content, struct builder_spheres *to)
{
    const VkAccelerationStructureBuildRangeInfoKHR found = {
        .primitiveCount = content->range->range->primitiveCount};
    const bool swept = is_swept(content);
    const struct geometry_input *indices =
        content_input(content, swept ? INPUT_SWEPT_INDEX : INPUT_SPHERE_INDEX);
    to->indices_size = content_find_some_input(content, indices, &to->indices);
    if (indices && !to->indices_size)
        return false;
    const uint64_t count = sphere_vertex_count(to, swept, &found);
    to->vertices_size = find_elements(content, swept ? INPUT_SWEPT_VERTEX : INPUT_SPHERE_VERTEX,
                                      count, &to->vertices);
    to->radii_size =
        find_elements(content, swept ? INPUT_SWEPT_RADIUS : INPUT_SPHERE_RADIUS, count, &to->radii);
    return to->vertices_size && to->radii_size;
}

static bool describe(const struct content *content, struct builder_geometry *described)
{
    if (!content->chained || !content->chained->spheres.sType)
        return false;
    build_input_describe(content->range->geometry->geometry, content->chained, described);
    return sphere_formats_are_known(&described->spheres) &&
           find_arrays(content, &described->spheres);
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
    if (!describe(content, &described) || !content_open_source(content, &described, &source))
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
