/* SPDX-License-Identifier: Apache-2.0 */
/* What moves (VK_NV_ray_tracing_motion_blur): where it is at a ray's time, and where it ever is.
 *
 * Vertices and matrices are interpolated linearly; of an SRT transform ("VkSRTDataNV") each element
 * is, and the quaternion is then scaled to length 1. All in double, rounded once to float: what is
 * exact is so for the triangle or matrix that this gives. */
#ifndef ASSAY_BVH_MOTION_H
#define ASSAY_BVH_MOTION_H

#include "src/bvh/structure.h"
#include "src/bvh/vector.h"

/* Times below 0 or above 1, which the specification excludes, count as 0 and 1. */
void motion_triangle_at(const struct motion_triangle_record *record, float time,
                        struct triangle_record *now);
/* With the inverse of that time. */
void motion_instance_at(const struct motion_instance_record *record, float time,
                        struct instance_record *now);

/* World bounds from time 0 to 1 of an instance that moves. */
struct box motion_bounds(const struct motion_instance_record *record, const void *blas);

#endif
