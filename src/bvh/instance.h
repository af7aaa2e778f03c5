/* SPDX-License-Identifier: Apache-2.0 */
/* Transforms of instances (VkTransformMatrixKHR): their inverses, and the world bounds that they
 * give to a bottom-level structure. */
#ifndef ASSAY_BVH_INSTANCE_H
#define ASSAY_BVH_INSTANCE_H

#include "src/bvh/structure.h"
#include "src/bvh/vector.h"

/* The inverse of the 3x3 part, row by row; all 0 if it is singular. */
void instance_invert(const VkTransformMatrixKHR *transform, double inverse[9]);

/* World bounds of an instance of `blas`, wide enough for every point of that structure and for the
 * rounding of rays that traversal takes into its space; a point if the structure is empty. */
struct box instance_bounds(const VkTransformMatrixKHR *transform, const void *blas);

/* The same for all matrices whose elements are from `low` to `high`. */
struct box instance_bounds_between(double low[3][4], double high[3][4], const void *blas);

#endif
