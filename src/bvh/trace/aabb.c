/* SPDX-License-Identifier: Apache-2.0 */
/* AABBs as primitives: all intervals include their ends. */
#include "src/bvh/trace/ray.h"

/* The relative error of the difference, the division and both sides of the comparison is below 4 *
 * 2^-53. The specification allows candidates outside the box; the pad can produce some. */
#define AABB_PAD (8 * 0x1p-53)

bool aabb_hit(const struct local_ray *ray, const struct aabb_record *box, double t_max, double *t)
{
    double enter = ray->t_min, leave = t_max;
    for (int axis = 0; axis < 3; axis++) {
        double direction = ray->direction[axis], origin = ray->origin[axis];
        double lower = box->lower[axis] - origin, upper = box->upper[axis] - origin;
        if (direction == 0) {
            if (lower > 0 || upper < 0)
                return false;
            continue;
        }
        double near = (direction > 0 ? lower : upper) / direction;
        double far = (direction > 0 ? upper : lower) / direction;
        enter = fmax(enter, near - fabs(near) * AABB_PAD);
        leave = fmin(leave, far + fabs(far) * AABB_PAD);
    }
    *t = enter;
    return enter <= leave;
}
