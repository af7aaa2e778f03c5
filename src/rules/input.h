/* SPDX-License-Identifier: Apache-2.0 */
/* The addresses that builds use, by what they are to the build. */
#ifndef ASSAY_RULES_INPUT_H
#define ASSAY_RULES_INPUT_H

#include "src/state/commands/journal.h"
#include "vuid-tables/rules.h"

struct geometry_view;

/* Paths of structures that extensions chain, relative to their geometry. */
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

/* The member that gives the address, relative to its geometry, or to the build for scratch. */
const char *input_field(enum input_role role);
/* The same for the data that a command reads, which host builds have at host addresses. */
const char *input_data_field(enum build_command command, enum input_role role);

/* The member that leads to that data, by the geometry's command. */
const char *content_field(const struct geometry_view *geometry, enum input_role role);

#endif
