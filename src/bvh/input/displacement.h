/* SPDX-License-Identifier: Apache-2.0 */
/* Displacement micromaps (VK_NV_displacement_micromap): the subdivision of a triangle, and the data
 * of its blocks.
 *
 * "Displacement Micromap Encoding" of the Vulkan specification defines the fields of the blocks
 * with their bit positions, the prediction, and shifts "selected from interior or the 3 edges in
 * vertex order". It states that vertices and blocks follow one space-filling curve on which "some
 * triangles are flipped and wound differently", but not the order itself. The following sources
 * define the order and agree: micromesh_core of NVIDIA's Displacement-MicroMap-SDK (vertices,
 * blocks, decimation of edges), sample mm_displacement of nvpro's vk_mini_samples (vertices,
 * blocks), optix_micromap_impl.h of OptiX 7.7 (blocks), and samples of OptiX_Utility (vertices).
 * None of their words or code is used here. The toolkit ignores the shifts of blocks that are used
 * at lower levels than their own; this implementation follows the specification instead.
 *
 * - The curve: with m01 as the midpoint of vertices 0 and 1, a triangle of vertices 0, 1, 2 is
 *   divided into (0, m01, m02), (m02, m12, m01), (m01, 1, m12), (m12, m02, 2), in this order,
 *   recursively.
 * - Vertices: 0, 1, 2; then the vertices that each level adds. Only triangles with the orientation
 *   of the whole add vertices, in the order of the curve: the midpoints of their edges parallel to
 *   0-2, to 1-2, to 0-1.
 * - Blocks of a triangle whose level exceeds that of a block: in the order of the curve. Within a
 *   block, the order is that of the block's own vertices 0, 1, 2, as the curve divides them. */
#ifndef ASSAY_BVH_INPUT_DISPLACEMENT_H
#define ASSAY_BVH_INPUT_DISPLACEMENT_H

#include <stdint.h>

#define DISPLACEMENT_MAX_LEVEL 5u
#define DISPLACEMENT_MAX_VERTICES 561u /* maximum vertices per triangle */
#define DISPLACEMENT_ONE 2047u         /* the value that represents 1 */

/* Barycentric weights of vertices 1 and 2, in units in which an edge of the whole has length
 * 2^level. */
struct displacement_corner {
    uint8_t u, v;
};

/* Computes part `index` of 4^cuts along the curve, in units in which an edge has length `size`,
 * which is at least 2^cuts. The vertices are in the order of the curve: every other part has the
 * opposite winding. */
void displacement_part(uint32_t cuts, uint32_t index, uint32_t size,
                       struct displacement_corner corners[3]);

/* Computes the vertices of part `index` of 4^level with the winding of the whole. `edges` are the
 * decimated edges of the whole; bit 0: vertices 0 and 1; bit 1: 1 and 2; bit 2: 2 and 0. */
void displacement_microtriangle(uint32_t level, uint32_t index, uint32_t edges,
                                struct displacement_corner corners[3]);

/* The number of vertices, and the index of a vertex among the values of a triangle: row by row,
 * beginning with v = 0. */
static inline uint32_t displacement_vertex_count(uint32_t level)
{
    uint32_t edge = (1u << level) + 1;
    return edge * (edge + 1) / 2;
}

static inline uint32_t displacement_place(uint32_t level, uint32_t u, uint32_t v)
{
    return v * ((1u << level) + 1) - v * (v - 1) / 2 + u;
}

/* Returns the size of a triangle's blocks in bytes, or 0 if the VkDisplacementMicromapFormatNV or
 * the level is invalid. */
uint64_t displacement_bytes(uint32_t format, uint32_t level);

/* Decodes the values of all vertices, 0 to DISPLACEMENT_ONE. All bytes are valid input. If blocks
 * of one triangle give different values for a shared vertex, the later block wins. */
void displacement_decode(uint32_t format, uint32_t level, const uint8_t *blocks, uint16_t *values);

#endif
