/* SPDX-License-Identifier: Apache-2.0 */
/* Selects the extensions to validate, and validates motion, dense geometry and spheres. */
#include "src/check/call/parts.h"

#include "src/base/chain.h"
#include "src/base/recording_path.h"
#include "src/check/assemble/extended.h"
#include "src/check/assemble/views.h"
#include "src/model/geometry.h"

/* The rows of extensions don't state whether they affect the sizes of a build, so every finding
 * counts. */
static void hide_sizes_on_findings(struct walk *walk, uint32_t findings_before)
{
    walk->hides_sizes |= walk->findings != findings_before;
}

void check_extended_build(struct walk *walk, struct build_view *build, bool with_state)
{
    const struct device_facts *device = build->call->device;
    uint32_t findings_before = walk->findings;
    if (device->extension.motion_blur_nv)
        check_motion_build(walk, build, with_state);
    if (device->micromap.any)
        check_micromap_build(walk, build, with_state);
    if (device->extension.dense_geometry_format_amdx)
        check_dense_build(walk, build);
    hide_sizes_on_findings(walk, findings_before);
}

/* Returns true if no extension applies to a geometry, as for most geometries even if extensions are
 * enabled. Extensions only add chained structures and types. */
static bool has_no_extensions(const struct geometry_view *geometry)
{
    const VkAccelerationStructureGeometryKHR *data = geometry->geometry;
    if (data->pNext ||
        geometry->build->info->type == VK_ACCELERATION_STRUCTURE_TYPE_OPACITY_MICROMAP_KHR)
        return false;
    const VkAccelerationStructureGeometryTrianglesDataKHR *triangles = triangles_in(data);
    return triangles ? !triangles->pNext : aabbs_in(data) || instances_in(data);
}

OFF_RECORDING_PATH void check_extended_geometry(struct walk *walk, struct geometry_view *geometry,
                                                bool with_state)
{
    const struct device_facts *device = geometry->build->call->device;
    uint32_t findings_before = walk->findings;
    if (has_no_extensions(geometry))
        return;
    walk->chained.count = 0;
    geometry->chained = &walk->chained;
    if (device->extension.motion_blur_nv)
        check_motion(walk, geometry, with_state);
    if (device->extension.linear_swept_spheres_nv)
        check_spheres(walk, geometry, with_state);
    if (device->micromap.any)
        check_micromaps(walk, geometry, with_state);
    if (device->extension.dense_geometry_format_amdx)
        check_dense(walk, geometry, with_state);
    hide_sizes_on_findings(walk, findings_before);
}

/* ---- motion */

static bool geometry_has_motion(struct check_context *context,
                                const VkAccelerationStructureGeometryKHR *geometry)
{
    const VkAccelerationStructureGeometryTrianglesDataKHR *triangles = triangles_in(geometry);
    return triangles && triangles->pNext && chain_is_readable(context, triangles->pNext) &&
           chain_find(triangles->pNext,
                      VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_MOTION_TRIANGLES_DATA_NV);
}

/* Only the structures that lack motion are searched, so builds with motion cost no more. */
static uint32_t first_motion_geometry(struct check_context *context, const struct build_view *build)
{
    uint32_t i = build->dst.details_known &&
                         !(build->dst.create_flags & VK_ACCELERATION_STRUCTURE_CREATE_MOTION_BIT_NV)
                     ? 0
                     : build->geometry_count;
    while (i < build->geometry_count &&
           !geometry_has_motion(context, build_geometry(build->info, i)))
        i++;
    return i;
}

void check_motion_build(struct walk *walk, const struct build_view *build, bool with_state)
{
    struct motion_build_view view = {.build = build,
                                     .first_motion_geometry = build->geometry_count};
    walk_motion_build(walk, &view, LEVEL_PARAMETERS);
    if (!with_state)
        return;
    view.first_motion_geometry = first_motion_geometry(walk->context, build);
    walk_motion_build(walk, &view, LEVEL_STATE);
}

void check_motion(struct walk *walk, struct geometry_view *geometry, bool with_state)
{
    const VkAccelerationStructureGeometryTrianglesDataKHR *triangles =
        triangles_in(geometry->geometry);
    bool is_host = geometry->build->call->command == COMMAND_HOST;
    if (!triangles)
        return;
    const VkAccelerationStructureGeometryMotionTrianglesDataNV *data =
        chain_member(triangles->pNext, &geometry->triangles_chain,
                     VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_MOTION_TRIANGLES_DATA_NV);
    const struct motion_triangles_view view = {.geometry = geometry,
                                               .vertices = data ? &data->vertexData : NULL};
    if (with_state && data && !is_host)
        chained_input(walk->context, geometry, INPUT_MOTION_VERTEX, view.vertices->deviceAddress);
    walk_motion_triangles(walk, &view, LEVEL_PARAMETERS);
}

/* ---- dense geometry */

void check_dense_build(struct walk *walk, struct build_view *build)
{
    struct dense_build_view view = {.build = build};
    bool any = false, readable = true;
    for (uint32_t i = 0; i < build->geometry_count; i++) {
        const VkAccelerationStructureGeometryKHR *geometry = build_geometry(build->info, i);
        if (!type_is_dense(geometry->geometryType))
            continue;
        any = true;
        readable = readable && chain_is_readable(walk->context, geometry->pNext);
    }
    build->dense_readable = any && readable;
    if (any)
        walk_dense_build(walk, &view, LEVEL_PARAMETERS);
}

void check_dense(struct walk *walk, struct geometry_view *geometry, bool with_state)
{
    if (!type_is_dense(geometry->geometry->geometryType))
        return;
    struct dense_view view = {
        .geometry = geometry,
        .missing = extended_data_is_missing(geometry),
        .data = chain_member(
            geometry->geometry->pNext, &geometry->chain,
            VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_DENSE_GEOMETRY_FORMAT_TRIANGLES_DATA_AMDX)};
    walk_dense(walk, &view, LEVEL_PARAMETERS);
    if (!with_state)
        return;
    if (view.data && geometry->build->call->command != COMMAND_HOST && !dense_is_empty(view.data))
        view.address = chained_input(walk->context, geometry, INPUT_DENSE_DATA,
                                     view.data->compressedData.deviceAddress);
    walk_dense(walk, &view, LEVEL_STATE);
}

/* ---- spheres */

static void walk_sphere_data(struct walk *walk, const struct sphere_data *data, enum level level)
{
    if (data->is_swept)
        walk_swept_spheres(walk, &(struct swept_spheres_view){data}, level);
    else
        walk_spheres(walk, &(struct spheres_view){data}, level);
}

void check_spheres(struct walk *walk, struct geometry_view *geometry, bool with_state)
{
    const VkGeometryTypeKHR type = geometry->geometry->geometryType;
    struct sphere_data data;
    if (!type_is_spheres(type) && !type_is_swept_spheres(type))
        return;
    view_spheres(geometry, &data);
    if (data.given)
        view_sphere_addresses(walk->context, geometry, &data);
    walk_sphere_data(walk, &data, LEVEL_PARAMETERS);
    if (!with_state)
        return;
    if (data.given)
        view_sphere_formats(walk->context, &data);
    walk_sphere_data(walk, &data, LEVEL_STATE);
}
