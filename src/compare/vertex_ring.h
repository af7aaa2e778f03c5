/* SPDX-License-Identifier: Apache-2.0 */
/* Whether a ray meets a fan (rays.h) exactly once, whatever float arithmetic a driver has: its
 * triangles show the ray the same side, none is seen edge-on, and the ray stays clear of the
 * boundary of them all. */
#ifndef ASSAY_COMPARE_VERTEX_RING_H
#define ASSAY_COMPARE_VERTEX_RING_H

#include "src/compare/rays.h"

bool ring_is_hit_once(const struct reference *reference, const struct rays *rays, uint32_t ray);

#endif
