/* SPDX-License-Identifier: Apache-2.0 */
/* Selects the extensions to validate. */
#include "src/check/call/extensions.h"

#include "src/base/recording_path.h"
#include "src/check/assemble/extended.h"
#include "src/view/geometry_data.h"

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
