/* SPDX-License-Identifier: Apache-2.0 */
/* Validates what extensions add to builds and geometries. */
#ifndef ASSAY_CHECK_CALL_EXTENSIONS_H
#define ASSAY_CHECK_CALL_EXTENSIONS_H

#include "src/check/walk/walk.h"

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
