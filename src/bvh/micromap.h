/* SPDX-License-Identifier: Apache-2.0 */
/* Micromaps: building, copying and reading them.
 *
 * Follows "Micromap" of the Vulkan specification. A micromap is one block of bytes without
 * pointers. A structure stores the 64-bit reference of a micromap; traversal resolves the reference
 * (trace.h). Scenes without micromaps never use this. */
#ifndef ASSAY_BVH_MICROMAP_H
#define ASSAY_BVH_MICROMAP_H

#include "src/bvh/bvh.h"

/* The maximum subdivision level for opacities; see displacement.h for displacements. */
#define MICROMAP_MAX_LEVEL 12u

/* VkMicromapBuildInfoEXT, or VkAccelerationStructureGeometryMicromapDataKHR of type opacity. Each
 * size is the readable size in bytes from its pointer on. */
struct micromap_input {
    VkMicromapTypeEXT type;
    uint32_t usage_count;
    const VkMicromapUsageEXT *usages;
    const void *data, *triangles; /* `triangles`: VkMicromapTriangleEXT elements */
    uint64_t data_size, triangles_size, stride;
};

/* Reads only the type and the usages. Returns BUILDER_UNKNOWN_FORMAT if a usage has a format or
 * level that is invalid for the type. Micromap builds need no scratch. */
enum builder_result micromap_get_size(const struct micromap_input *input, uint64_t *size);
/* As micromap_get_size(); also returns BUILDER_INPUT_OUT_OF_RANGE if the triangles do not match the
 * usages. */
enum builder_result micromap_build(const struct micromap_input *input, void *micromap,
                                   uint64_t size);

/* Returns the data size of one triangle in bytes, or 0 if the format or level is invalid for the
 * VkMicromapTypeEXT. */
uint64_t micromap_triangle_bytes(uint32_t type, uint32_t format, uint32_t level);

/* micromap_triangle_count() returns the sum of the usage counts. micromap_data_extent() returns the
 * end, in bytes from `data` on, of the data of all readable triangles. */
uint64_t micromap_triangle_count(const struct micromap_input *input);
uint64_t micromap_data_extent(const struct micromap_input *input);

/* Returns whether the block is a micromap; otherwise it is a structure. */
bool micromap_is(const void *bytes);
uint64_t micromap_size(const void *micromap); /* size of a clone in bytes */
uint64_t micromap_compacted_size(const void *micromap);
enum builder_result micromap_clone(const void *source, void *target, uint64_t target_size);
enum builder_result micromap_compact(const void *source, void *target, uint64_t target_size);

/* The serialized form: the header of serialized structures, then the micromap. Deserialization
 * validates untrusted bytes. */
/* Returns false if the bytes are a serialized structure. */
bool micromap_is_serialized(const void *bytes, uint64_t size);
uint64_t micromap_serialized_size(const void *micromap);
enum builder_result micromap_serialize(const void *micromap, const struct builder_uuids *uuids,
                                       void *bytes, uint64_t size);
enum builder_result micromap_deserialize(const void *bytes, uint64_t size,
                                         const struct builder_uuids *uuids, void *micromap,
                                         uint64_t micromap_size);

/* Returns the blocks of a displaced triangle, for displacement_decode(). Returns NULL if there is
 * no such triangle or the micromap has no displacements. */
const uint8_t *micromap_displacement(const void *micromap, uint64_t triangle, uint32_t *format,
                                     uint32_t *level);

/* ---- for traversal */

/* Values of a format with 4 states. A special index i stands for the value -1 - i. */
enum micromap_state {
    MICROMAP_TRANSPARENT,
    MICROMAP_OPAQUE,
    MICROMAP_UNKNOWN_TRANSPARENT,
    MICROMAP_UNKNOWN_OPAQUE,
    MICROMAP_NONE, /* no such triangle, or the micromap has no opacities */
};

/* Returns the opacity of the microtriangle at barycentrics u and v, the weights of vertices 1 and
 * 2. */
enum micromap_state micromap_opacity(const void *micromap, uint32_t triangle, float u, float v);

/* Returns the position of a microtriangle along the curve that orders microtriangles. */
uint32_t micromap_curve_index(float u, float v, uint32_t level);

#endif
