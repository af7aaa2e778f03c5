/* SPDX-License-Identifier: Apache-2.0 */
/* Transforms of instances (VkTransformMatrixKHR): their inverses, the world bounds of a
 * transformed BLAS, and motion. */
#ifndef ASSAY_BVH_MOTION_H
#define ASSAY_BVH_MOTION_H

#include "src/bvh/structure.h"
#include "src/bvh/vector.h"

/* Computes the inverse of the 3x3 part, row by row; all 0 if the part is singular. */
void instance_invert(const VkTransformMatrixKHR *transform, double inverse[9]);

/* Returns the world bounds of an instance of `blas`. The bounds contain every point of the
 * structure, and cover the rounding of rays that traversal transforms into object space. If the
 * structure is empty, the bounds are a point. */
struct box instance_bounds(const VkTransformMatrixKHR *transform, const void *blas);

/* ---- Motion (VK_NV_ray_tracing_motion_blur): the state at a ray's time, and bounds over all
 * times.
 *
 * Vertices and matrices are interpolated linearly. Each element of an SRT transform ("VkSRTDataNV")
 * is interpolated linearly, and the quaternion is then normalized. All of this happens in double
 * and is rounded to float once; traversal is exact for the rounded triangle or matrix. */

/* Times below 0 or above 1, which the specification excludes, count as 0 and 1. */
void motion_triangle_at(const struct motion_triangle_record *record, float time,
                        struct triangle_record *now);
/* Also computes the inverse at that time. */
void motion_instance_at(const struct motion_instance_record *record, float time,
                        struct instance_record *now);

/* Returns the world bounds of a moving instance over times 0 to 1. */
struct box motion_bounds(const struct motion_instance_record *record, const void *blas);

#endif
