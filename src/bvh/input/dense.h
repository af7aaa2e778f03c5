/* SPDX-License-Identifier: Apache-2.0 */
/* Dense geometry (VK_AMDX_dense_geometry_format, "Dense Geometry Format Version 1"), decoded. */
#ifndef ASSAY_BVH_INPUT_DENSE_H
#define ASSAY_BVH_INPUT_DENSE_H

#include "src/bvh/input/source.h"

/* The blocks' triangles in their order, `count` records; what the blocks don't have or say wrongly
 * is marked in `found`. */
void dense_decode(const struct builder_dense *dense, uint32_t count, struct dense_triangle *to);

#endif
