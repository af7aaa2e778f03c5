/* SPDX-License-Identifier: Apache-2.0 */
/* The parts of a build call that check_builds() validates one by one: addresses, host memory, and
 * what extensions add. */
#ifndef ASSAY_CHECK_CALL_PARTS_H
#define ASSAY_CHECK_CALL_PARTS_H

#include "src/check/walk/walk.h"

/* ---- addresses */

/* Validates the addresses of a geometry, including those in chained structures. */
void check_geometry_addresses(struct walk *walk, const struct geometry_view *geometry);
/* Validates the scratch address of a build if the scratch size is known. */
void check_scratch_address(struct walk *walk, const struct build_view *build);

/* Evaluates the rules about the indirect parameters of one build of COMMAND_INDIRECT, and passes
 * them to the build recorder. */
void check_indirect(struct walk *walk, const struct build_view *build, bool with_state);

/* ---- vkBuildAccelerationStructuresKHR only */

/* Call it after the state of the build is known. */
void check_host_build(struct walk *walk, const struct build_view *build);
/* The build range of `range` may be unknown. */
void check_host_geometry(struct walk *walk, const struct range_view *range);

/* ---- what extensions add to builds and geometries */

/* Evaluate the rules about what the enabled extensions add to a build or a geometry, at level STATE
 * too if `with_state`. The geometry's view then refers to the walk's chained inputs, until the next
 * geometry is validated. */
void check_extended_build(struct walk *walk, struct build_view *build, bool with_state);
void check_extended_geometry(struct walk *walk, struct geometry_view *geometry, bool with_state);

/* Evaluate the rules about what one enabled extension adds. */
void check_motion_build(struct walk *walk, const struct build_view *build, bool with_state);
void check_motion(struct walk *walk, struct geometry_view *geometry, bool with_state);
void check_spheres(struct walk *walk, struct geometry_view *geometry, bool with_state);
void check_micromap_build(struct walk *walk, const struct build_view *build, bool with_state);
void check_micromaps(struct walk *walk, struct geometry_view *geometry, bool with_state);
void check_dense_build(struct walk *walk, struct build_view *build);
void check_dense(struct walk *walk, struct geometry_view *geometry, bool with_state);
/* Returns the micromaps of the current build, or NULL if it has none. */
const struct micromap_uses *found_micromaps(const struct walk *walk);

#endif
