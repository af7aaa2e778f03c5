/* SPDX-License-Identifier: Apache-2.0 */
#include "src/model/input_names.h"

#define ADDRESS(name, nv, nv_offset)                                                               \
    {                                                                                              \
        name, name ".deviceAddress", name ".hostAddress", nv, nv_offset                            \
    }
#define TRIANGLES(name) ADDRESS(name "Data", name "Data", name "Offset")
#define CHAINED(name) ADDRESS(name, NULL, NULL)
#define OF_DEVICE(name)                                                                            \
    {                                                                                              \
        name, name, name, NULL, NULL                                                               \
    } /* a VkDeviceAddress */

static const char *const names[INPUT_ROLES][INPUT_FORMS] = {
    [INPUT_VERTEX] = TRIANGLES("geometry.triangles.vertex"),
    [INPUT_INDEX] = TRIANGLES("geometry.triangles.index"),
    [INPUT_MATRIX] = TRIANGLES("geometry.triangles.transform"),
    [INPUT_AABBS] =
        ADDRESS("geometry.aabbs.data", "geometry.aabbs.aabbData", "geometry.aabbs.offset"),
    [INPUT_INSTANCES] = ADDRESS("geometry.instances.data", "instanceData", "instanceOffset"),
    [INPUT_MOTION_VERTEX] = CHAINED(MOTION_DATA "vertexData"),
    [INPUT_SPHERE_VERTEX] = CHAINED(SPHERES_DATA "vertexData"),
    [INPUT_SPHERE_RADIUS] = CHAINED(SPHERES_DATA "radiusData"),
    [INPUT_SPHERE_INDEX] = CHAINED(SPHERES_DATA "indexData"),
    [INPUT_SWEPT_VERTEX] = CHAINED(SWEPT_DATA "vertexData"),
    [INPUT_SWEPT_RADIUS] = CHAINED(SWEPT_DATA "radiusData"),
    [INPUT_SWEPT_INDEX] = CHAINED(SWEPT_DATA "indexData"),
    [INPUT_MICROMAP_DATA] = OF_DEVICE(MICROMAP_DATA "data"),
    [INPUT_MICROMAP_TRIANGLES] = OF_DEVICE(MICROMAP_DATA "triangleArray"),
    [INPUT_OPACITY_INDEX] = OF_DEVICE(OPACITY_DATA "indexBuffer"),
    [INPUT_OPACITY_EXT_INDEX] = CHAINED(OPACITY_EXT_DATA "indexBuffer"),
    [INPUT_DENSE_DATA] = CHAINED(DENSE_DATA "compressedData"),
    [INPUT_SCRATCH] = ADDRESS("scratchData", "scratch", "scratchOffset"),
    [INPUT_UPDATE_SCRATCH] = ADDRESS("scratchData", "scratch", "scratchOffset"),
    [INPUT_INDIRECT] = OF_DEVICE("pIndirectDeviceAddresses"),
    [INPUT_DISPLACEMENT_INDEX] = CHAINED(DISPLACEMENT_DATA "indexBuffer"),
    [INPUT_DISPLACEMENT_VECTOR] = CHAINED(DISPLACEMENT_DATA "displacementVectorBuffer"),
    [INPUT_DISPLACEMENT_BIAS] = CHAINED(DISPLACEMENT_DATA "displacementBiasAndScaleBuffer"),
    [INPUT_DISPLACEMENT_FLAGS] = CHAINED(DISPLACEMENT_DATA "displacedMicromapPrimitiveFlags"),
};

const char *input_name(enum input_role role, enum input_form form)
{
    return names[role][form];
}
