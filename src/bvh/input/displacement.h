/* SPDX-License-Identifier: Apache-2.0 */
/* Displacement micromaps (VK_NV_displacement_micromap): how a triangle is subdivided, and what the
 * blocks of its data say.
 *
 * "Displacement Micromap Encoding" of the Vulkan specification has the fields of the blocks with
 * their places in bits, the prediction, and shifts "selected from interior or the 3 edges in vertex
 * order". Of the order of vertices and blocks it says that they follow one space-filling curve on
 * which "some triangles are flipped and wound differently". Which order that is, these say, and
 * agree: micromesh_core of NVIDIA's Displacement-MicroMap-SDK (vertices, blocks, what edges are
 * decimated to), sample mm_displacement of nvpro's vk_mini_samples (vertices, blocks),
 * optix_micromap_impl.h of OptiX 7.7 (blocks), and samples of OptiX_Utility (vertices). None of
 * their words or code is used here. Where the toolkit ignores the shifts of blocks that are used
 * for lower levels than their own, the specification is followed.
 *
 * - The curve: a triangle of vertices 0, 1, 2 is cut, m01 being the middle of 0 and 1, into
 *   (0, m01, m02), (m02, m12, m01), (m01, 1, m12), (m12, m02, 2), in this order, and so on.
 * - Vertices: 0, 1, 2; then those that each level adds. Only triangles that stand as the whole does
 *   name any: along the curve, each the middle of its edge parallel to 0-2, to 1-2, to 0-1.
 * - Blocks of a triangle beyond a block's level: along the curve; the order within a block is that
 *   of its own vertices 0, 1, 2, as the curve cuts them. */
#ifndef ASSAY_BVH_INPUT_DISPLACEMENT_H
#define ASSAY_BVH_INPUT_DISPLACEMENT_H

#include <stdint.h>

#define DISPLACEMENT_MAX_LEVEL 5u
#define DISPLACEMENT_MAX_VERTICES 561u /* of a triangle */
#define DISPLACEMENT_ONE 2047u         /* the value that means 1 */

/* Weights of vertices 1 and 2, in units in which an edge of the whole is 2^level. */
struct displacement_corner {
    uint8_t u, v;
};

/* Part `index` of 4^cuts along the curve, in units of an edge of `size`, at least 2^cuts. Its
 * vertices as the curve has them: every other one is wound the other way. */
void displacement_part(uint32_t cuts, uint32_t index, uint32_t size,
                       struct displacement_corner corners[3]);

/* The vertices of part `index` of 4^level, wound as the whole. `edges` says which edges of the
 * whole are decimated: bit 0: that of vertices 0 and 1; bit 1: 1 and 2; bit 2: 2 and 0. */
void displacement_microtriangle(uint32_t level, uint32_t index, uint32_t edges,
                                struct displacement_corner corners[3]);

/* How many vertices, and where each is among a triangle's values: row by row, v = 0 first. */
static inline uint32_t displacement_vertex_count(uint32_t level)
{
    uint32_t edge = (1u << level) + 1;
    return edge * (edge + 1) / 2;
}

static inline uint32_t displacement_place(uint32_t level, uint32_t u, uint32_t v)
{
    return v * ((1u << level) + 1) - v * (v - 1) / 2 + u;
}

/* Bytes of a triangle's blocks; 0 where there is no such VkDisplacementMicromapFormatNV or level.
 */
uint64_t displacement_bytes(uint32_t format, uint32_t level);

/* Values of all vertices, 0 to DISPLACEMENT_ONE. Any bytes will do. Where blocks of one triangle
 * give a vertex that they share different values, the later block's counts. */
void displacement_decode(uint32_t format, uint32_t level, const uint8_t *blocks, uint16_t *values);

#endif
