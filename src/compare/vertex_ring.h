/* SPDX-License-Identifier: Apache-2.0 */
/* Decides whether a ray hits a ring (rays.h) exactly once in any float arithmetic: the triangles
 * face the ray with the same side, none is edge-on, and the ray keeps its distance from the outer
 * boundary of the ring. */
#ifndef ASSAY_COMPARE_VERTEX_RING_H
#define ASSAY_COMPARE_VERTEX_RING_H

#include "src/compare/rays.h"

/* Returns whether ray number `ray` certainly hits its ring exactly once. */
bool ring_is_hit_once(const struct reference *reference, const struct rays *rays, uint32_t ray);

#endif
