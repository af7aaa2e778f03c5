/* SPDX-License-Identifier: Apache-2.0 */
/* Geometries and builds of extensions: whether a driver can be asked about them, and their views.
 */
#ifndef ASSAY_CHECK_ASSEMBLE_EXTENDED_H
#define ASSAY_CHECK_ASSEMBLE_EXTENDED_H

#include "src/check/walk/context.h"
#include "src/view/extension_view.h"

/* Whether a driver can be asked about a geometry whose data is in its chain, which is readable. */
bool extended_geometry_is_well_formed(const VkAccelerationStructureGeometryKHR *geometry);
bool micromap_is_well_formed(const VkAccelerationStructureGeometryKHR *geometry);
/* Of a build whose sizes depend on its structures alone: drivers are given no counts. */
bool is_micromap_build_for_device(const struct build_view *build);
bool spheres_are_well_formed(const VkAccelerationStructureGeometryKHR *geometry);
/* What the chain of a geometry says of spheres, swept or not: nothing given where it has none. */
void view_spheres(const struct geometry_view *geometry, struct swept_spheres_view *view);
/* The same of a copy of what was chained, of either kind; sType 0: nothing was. */
void view_chained_spheres(const struct geometry_view *geometry,
                          const VkAccelerationStructureGeometryLinearSweptSpheresDataNV *chained,
                          struct swept_spheres_view *view);
/* How many triangles a geometry says that it has which takes no build range; false for others. */
bool dense_triangle_count(const VkAccelerationStructureGeometryKHR *geometry, uint32_t *count);
bool dense_is_well_formed(const VkAccelerationStructureGeometryKHR *geometry);

/* Where the structure that geometryType needs was not found in the chain of a geometry: whether
 * that is what is wrong, and not something else with the chain. */
bool extended_data_is_missing(const struct geometry_view *geometry);

/* Looks up an address in a chained structure, for the rules about all inputs and for the journal.
 * Not for host builds. */
const struct address_facts *chained_input(struct check_context *context,
                                          struct geometry_view *geometry, enum input_role role,
                                          VkDeviceAddress address);

/* Where the data of spheres can be read, or which addresses it has. */
void view_sphere_addresses(struct check_context *context, struct geometry_view *geometry,
                           bool is_swept, struct sphere_data *data);
/* Whether the device supports their formats. */
void view_sphere_formats(struct check_context *context, struct sphere_data *data);

#endif
