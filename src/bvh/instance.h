/* SPDX-License-Identifier: Apache-2.0 */
/* Transforms of instances (VkTransformMatrixKHR): their inverses, and the world bounds of a
 * transformed BLAS. */
#ifndef ASSAY_BVH_INSTANCE_H
#define ASSAY_BVH_INSTANCE_H

#include "src/bvh/structure.h"
#include "src/bvh/vector.h"

/* Computes the inverse of the 3x3 part, row by row; all 0 if the part is singular. */
void instance_invert(const VkTransformMatrixKHR *transform, double inverse[9]);

/* Returns the world bounds of an instance of `blas`. The bounds contain every point of the
 * structure, and cover the rounding of rays that traversal transforms into object space. If the
 * structure is empty, the bounds are a point. */
struct box instance_bounds(const VkTransformMatrixKHR *transform, const void *blas);

/* As instance_bounds(), for all matrices whose elements lie between `low` and `high`. */
struct box instance_bounds_between(double low[3][4], double high[3][4], const void *blas);

#endif
