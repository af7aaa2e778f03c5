/* SPDX-License-Identifier: Apache-2.0 */
/* Geometries and builds of extensions: whether they are well-formed, that is, safe to pass to a
 * driver's size query; and their views. */
#ifndef ASSAY_CHECK_ASSEMBLE_EXTENDED_H
#define ASSAY_CHECK_ASSEMBLE_EXTENDED_H

#include "src/check/walk/context.h"
#include "src/view/extension_view.h"

/* Returns whether a geometry is well-formed whose data is in its chain. The chain must be
 * readable. */
bool extended_geometry_is_well_formed(const VkAccelerationStructureGeometryKHR *geometry);
bool micromap_is_well_formed(const VkAccelerationStructureGeometryKHR *geometry);
/* Returns whether a build is a device build of a micromap, whose sizes depend on its structures
 * alone: drivers get no counts for it. */
bool is_micromap_build_for_device(const struct build_view *build);
bool spheres_are_well_formed(const VkAccelerationStructureGeometryKHR *geometry);
/* Describes the chain of a geometry of spheres or linear swept spheres. */
void view_spheres(const struct geometry_view *geometry, struct sphere_data *data);
/* Gets the number of triangles of a dense geometry, which takes no build range. Returns false for
 * other geometries. */
bool dense_triangle_count(const VkAccelerationStructureGeometryKHR *geometry, uint32_t *count);
bool dense_is_well_formed(const VkAccelerationStructureGeometryKHR *geometry);

/* For a geometry whose chain lacks the structure that geometryType needs: returns whether this is
 * the chain's only defect. */
bool extended_data_is_missing(const struct geometry_view *geometry);

/* Looks up an address of a chained structure and lists it for the rules about all inputs and for
 * the journal. Not for host builds. */
const struct address_facts *chained_input(struct check_context *context,
                                          struct geometry_view *geometry, enum input_role role,
                                          VkDeviceAddress address);

/* Sets for host builds which data of the spheres is unreadable; looks up their addresses for other
 * builds. */
void view_sphere_addresses(struct check_context *context, struct geometry_view *geometry,
                           struct sphere_data *data);
/* Sets whether the device supports the formats of the spheres. */
void view_sphere_formats(struct check_context *context, struct sphere_data *data);

#endif
