/* SPDX-License-Identifier: Apache-2.0 */
/* Paths of the members that hold the input addresses of a build. */
#ifndef ASSAY_RULES_INPUT_H
#define ASSAY_RULES_INPUT_H

#include "src/state/commands/journal.h"
#include "vuid-tables/rules.h"

struct geometry_view;

/* Paths of the structures that extensions chain, relative to their geometry. */
#define MOTION_DATA                                                                                \
    "geometry.triangles.pNext<VkAccelerationStructureGeometryMotionTrianglesDataNV>."
#define SPHERES_DATA "pNext<VkAccelerationStructureGeometrySpheresDataNV>."
#define SWEPT_DATA "pNext<VkAccelerationStructureGeometryLinearSweptSpheresDataNV>."
#define MICROMAP_DATA "pNext<VkAccelerationStructureGeometryMicromapDataKHR>."
#define OPACITY_DATA "geometry.triangles.pNext<VkAccelerationStructureTrianglesOpacityMicromapKHR>."
#define OPACITY_EXT_DATA                                                                           \
    "geometry.triangles.pNext<VkAccelerationStructureTrianglesOpacityMicromapEXT>."
#define DISPLACEMENT_DATA                                                                          \
    "geometry.triangles.pNext<VkAccelerationStructureTrianglesDisplacementMicromapNV>."
#define DENSE_DATA "pNext<VkAccelerationStructureDenseGeometryFormatTrianglesDataAMDX>."

/* Returns the path of the member that holds the device address of `role`, relative to the geometry,
 * or to the build info for scratch. */
const char *input_field(enum input_role role);
/* Returns the path of the member that holds the data which a build of the geometry reads. Host
 * builds use the host address. */
const char *content_field(const struct geometry_view *geometry, enum input_role role);

#endif
