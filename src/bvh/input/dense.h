/* SPDX-License-Identifier: Apache-2.0 */
/* Decodes dense geometry (VK_AMDX_dense_geometry_format, "Dense Geometry Format Version 1"). */
#ifndef ASSAY_BVH_INPUT_DENSE_H
#define ASSAY_BVH_INPUT_DENSE_H

#include "src/bvh/input/source.h"

/* Decodes the triangles of the blocks in order into `count` elements. Marks missing and malformed
 * triangles in `found`. */
void dense_decode(const struct builder_dense *dense, uint32_t count, struct dense_triangle *to);

#endif
