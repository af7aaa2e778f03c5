/* SPDX-License-Identifier: Apache-2.0 */
/* What builds read: the arrays of each geometry, said once for the rules about ranges and host
 * memory, the hazard check, snapshots, content, comparison and backend cpu. Builds of
 * VK_NV_ray_tracing and of VK_EXT_opacity_micromap are translated first (nv_info_copy(),
 * micromap_info_copy()). */
#ifndef ASSAY_MODEL_INPUTS_H
#define ASSAY_MODEL_INPUTS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <vulkan/vulkan.h>

#include "src/model/chained_input.h"

/* The use that a build makes of an address. */
enum input_role {
    INPUT_VERTEX,
    INPUT_INDEX,
    INPUT_MATRIX,
    INPUT_AABBS,
    INPUT_INSTANCES,
    INPUT_LAST_PLAIN = INPUT_INSTANCES, /* those behind it are in chains, or of no geometry */
    INPUT_MOTION_VERTEX,
    INPUT_SPHERE_VERTEX,
    INPUT_SPHERE_RADIUS,
    INPUT_SPHERE_INDEX,
    INPUT_SWEPT_VERTEX,
    INPUT_SWEPT_RADIUS,
    INPUT_SWEPT_INDEX,
    INPUT_MICROMAP_DATA,
    INPUT_MICROMAP_TRIANGLES,
    INPUT_OPACITY_INDEX,
    INPUT_OPACITY_EXT_INDEX,
    INPUT_DENSE_DATA,
    INPUT_SCRATCH,
    INPUT_UPDATE_SCRATCH,
    INPUT_INDIRECT, /* build ranges */
    INPUT_DISPLACEMENT_INDEX,
    INPUT_DISPLACEMENT_VECTOR,
    INPUT_DISPLACEMENT_BIAS,
    INPUT_DISPLACEMENT_FLAGS,
    INPUT_ROLES,
};

/* An array that a build reads: `count` elements of `size` bytes, `stride` bytes apart. The first
 * one lies `offset` bytes behind the address. */
struct geometry_input {
    enum input_role role;
    bool is_chosen;       /* indices or other data choose; otherwise the build reads each element */
    bool follows_indices; /* the indices of the triangles choose, as they choose vertices */
    bool is_of_device;    /* the address is one of the device in builds of the host, too */
    VkDeviceOrHostAddressConstKHR address; /* as input_place() holds it; may be 0 */
    uint64_t offset;                       /* UINT64_MAX: beyond all addresses */
    uint64_t count, stride, size;          /* size 0: the format is unknown */
    uint64_t most; /* bytes that an element may have; the first `size` of them are read */
};

/* Returns the member that holds the address of an input. `geometry` has the type that reads the
 * input; `chained` may be NULL for a role up to INPUT_LAST_PLAIN. Write to it only if both are the
 * caller's own. Returns NULL for roles of no geometry. */
static inline VkDeviceOrHostAddressConstKHR *
input_place(const VkAccelerationStructureGeometryKHR *geometry, const struct chained_input *chained,
            enum input_role role)
{
    VkAccelerationStructureGeometryKHR *in = (VkAccelerationStructureGeometryKHR *)geometry;
    struct chained_input *more = (struct chained_input *)chained;
    switch (role) {
    case INPUT_VERTEX:
        return &in->geometry.triangles.vertexData;
    case INPUT_INDEX:
        return &in->geometry.triangles.indexData;
    case INPUT_MATRIX:
        return &in->geometry.triangles.transformData;
    case INPUT_AABBS:
        return &in->geometry.aabbs.data;
    case INPUT_INSTANCES:
        return &in->geometry.instances.data;
    case INPUT_MOTION_VERTEX:
        return &more->motion_vertices;
    case INPUT_SPHERE_VERTEX:
    case INPUT_SWEPT_VERTEX:
        return &more->spheres.vertexData;
    case INPUT_SPHERE_RADIUS:
    case INPUT_SWEPT_RADIUS:
        return &more->spheres.radiusData;
    case INPUT_SPHERE_INDEX:
    case INPUT_SWEPT_INDEX:
        return &more->spheres.indexData;
    case INPUT_MICROMAP_DATA:
        return &more->micromap.data;
    case INPUT_MICROMAP_TRIANGLES:
        return &more->micromap.triangles;
    case INPUT_OPACITY_INDEX:
    case INPUT_OPACITY_EXT_INDEX:
        return &more->opacity.indexBuffer;
    case INPUT_DENSE_DATA:
        return &more->dense.compressedData;
    case INPUT_DISPLACEMENT_INDEX:
        return &more->displacement.indexBuffer;
    case INPUT_DISPLACEMENT_VECTOR:
        return &more->displacement.displacementVectorBuffer;
    case INPUT_DISPLACEMENT_BIAS:
        return &more->displacement.displacementBiasAndScaleBuffer;
    case INPUT_DISPLACEMENT_FLAGS:
        return &more->displacement.displacedMicromapPrimitiveFlags;
    case INPUT_SCRATCH:
    case INPUT_UPDATE_SCRATCH:
    case INPUT_INDIRECT:
    case INPUT_ROLES:
        break;
    }
    return NULL;
}

/* Returns the device address of an input that is in no chain. */
static inline VkDeviceAddress input_address(const VkAccelerationStructureGeometryKHR *geometry,
                                            enum input_role role)
{
    return input_place(geometry, NULL, role)->deviceAddress;
}

/* Triangles with motion, opacity and displacement have as many. */
enum { GEOMETRY_INPUTS = 9 };

/* Fills in what a build with these flags reads of a geometry, and returns how many arrays that are;
 * 0 if the range has no primitives. `chained` may be NULL. Members are read as geometryType says.
 */
uint32_t inputs_of_geometry(VkBuildAccelerationStructureFlagsKHR flags,
                            const VkAccelerationStructureGeometryKHR *geometry,
                            const struct chained_input *chained,
                            const VkAccelerationStructureBuildRangeInfoKHR *range,
                            struct geometry_input inputs[GEOMETRY_INPUTS]);

/* Returns the input of a role; NULL: there is none. */
static inline const struct geometry_input *input_of_role(const struct geometry_input *inputs,
                                                         uint32_t count, enum input_role role)
{
    for (uint32_t i = 0; i < count; i++)
        if (inputs[i].role == role)
            return &inputs[i];
    return NULL;
}

/* offset + count * stride + size, at most UINT64_MAX. */
static inline uint64_t input_extent(uint64_t offset, uint64_t count, uint64_t stride, uint64_t size)
{
    uint64_t sum;
    return __builtin_mul_overflow(count, stride, &sum) ||
                   __builtin_add_overflow(sum, offset, &sum) ||
                   __builtin_add_overflow(sum, size, &sum)
               ? UINT64_MAX
               : sum;
}

/* Returns how many bytes behind its address an input ends at most; UINT64_MAX if it wraps. */
static inline uint64_t input_end(const struct geometry_input *input)
{
    return input->count ? input_extent(input->offset, input->count - 1, input->stride, input->most)
                        : 0;
}

#endif
