/* SPDX-License-Identifier: Apache-2.0 */
/* Micromaps: what they are built from, and copies of them.
 *
 * Follows "Micromap" of the Vulkan specification. A micromap is one block of bytes without
 * pointers; structures name it by a 64-bit reference, which rays have resolved (trace.h). Only used
 * by scenes that have micromaps. */
#ifndef ASSAY_BVH_MICROMAP_H
#define ASSAY_BVH_MICROMAP_H

#include "src/bvh/bvh.h"

#define MICROMAP_MAX_LEVEL 12u /* of subdivision, for opacities; others: displacement.h */

/* VkMicromapBuildInfoEXT, or VkAccelerationStructureGeometryMicromapDataKHR with type opacity. The
 * sizes are what may be read from each pointer on. */
struct micromap_input {
    VkMicromapTypeEXT type;
    uint32_t usage_count;
    const VkMicromapUsageEXT *usages;
    const void *data, *triangles; /* the latter are VkMicromapTriangleEXT */
    uint64_t data_size, triangles_size, stride;
};

/* BUILDER_UNKNOWN_FORMAT where a usage has a format or level that its type doesn't have. Of the
 * input, only type and usages are read. No scratch is needed. */
enum builder_result micromap_get_size(const struct micromap_input *input, uint64_t *size);
/* BUILDER_INPUT_OUT_OF_RANGE, too, where triangles are other than the usages say. */
enum builder_result micromap_build(const struct micromap_input *input, void *micromap,
                                   uint64_t size);

/* How many triangles the usages count, and how much data those of the input name from `data` on, as
 * far as they can be read. */
uint64_t micromap_triangle_count(const struct micromap_input *input);
uint64_t micromap_data_extent(const struct micromap_input *input);

/* Of the block of a structure or a micromap: whether it is the latter. */
bool micromap_is(const void *bytes);
uint64_t micromap_size(const void *micromap); /* bytes that a clone takes */
uint64_t micromap_compacted_size(const void *micromap);
enum builder_result micromap_clone(const void *source, void *target, uint64_t target_size);
enum builder_result micromap_compact(const void *source, void *target, uint64_t target_size);

/* The header that structures have, too, then the micromap. Bytes may come from anywhere. */
bool micromap_is_serialized(const void *bytes, uint64_t size); /* or may be; else a structure */
uint64_t micromap_serialized_size(const void *micromap);
enum builder_result micromap_serialize(const void *micromap, const struct builder_uuids *uuids,
                                       void *bytes, uint64_t size);
enum builder_result micromap_deserialize(const void *bytes, uint64_t size,
                                         const struct builder_uuids *uuids, void *micromap,
                                         uint64_t micromap_size);

/* The blocks of a displaced triangle, for displacement_decode(); NULL where there is no such
 * triangle, or not of displacements. */
const uint8_t *micromap_displacement(const void *micromap, uint64_t triangle, uint32_t *format,
                                     uint32_t *level);

/* ---- what rays ask */

/* Values of a format with 4 states, and of special indices: -1 - index. */
enum micromap_state {
    MICROMAP_TRANSPARENT,
    MICROMAP_OPAQUE,
    MICROMAP_UNKNOWN_TRANSPARENT,
    MICROMAP_UNKNOWN_OPAQUE,
    MICROMAP_NONE, /* no such triangle, or not of opacities */
};

/* Of the microtriangle at barycentrics u, v of vertices 1 and 2. */
enum micromap_state micromap_opacity(const void *micromap, uint32_t triangle, float u, float v);

/* The place of a microtriangle along the curve that orders them. */
uint32_t micromap_curve_index(float u, float v, uint32_t level);

#endif
