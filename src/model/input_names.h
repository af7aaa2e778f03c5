/* SPDX-License-Identifier: Apache-2.0 */
/* How messages call the members that hold the addresses of a build's inputs. */
#ifndef ASSAY_MODEL_INPUT_NAMES_H
#define ASSAY_MODEL_INPUT_NAMES_H

#include "src/model/inputs.h"

/* Structures in the chain of a geometry or of its triangles. */
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

/* Which member of the union is used. */
enum input_form {
    INPUT_PLAIN, /* the union itself */
    INPUT_OF_DEVICE,
    INPUT_OF_HOST,
    INPUT_OF_NV, /* of vkCmdBuildAccelerationStructureNV: the buffer */
    INPUT_OFFSET_OF_NV,
    INPUT_FORMS,
};

/* Returns static text. */
const char *input_name(enum input_role role, enum input_form form);

#endif
