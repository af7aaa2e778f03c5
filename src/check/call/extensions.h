/* SPDX-License-Identifier: Apache-2.0 */
/* Checking what extensions add to builds and geometries. */
#ifndef ASSAY_CHECK_CALL_EXTENSIONS_H
#define ASSAY_CHECK_CALL_EXTENSIONS_H

#include "src/check/walk/walk.h"

/* Put what the enabled extensions add to a build, or to a geometry, to their rules, at level STATE
 * too if `with_state`. `chained` lives as long as the geometry's check. */
void check_extended_build(struct walk *walk, struct build_view *build, bool with_state);
void check_extended_geometry(struct walk *walk, struct geometry_view *geometry,
                             struct chained_inputs *chained, bool with_state);

/* The same of one extension that is enabled. */
void check_motion_build(struct walk *walk, const struct build_view *build, bool with_state);
void check_motion(struct walk *walk, struct geometry_view *geometry, bool with_state);
void check_spheres(struct walk *walk, struct geometry_view *geometry, bool with_state);
void check_micromap_build(struct walk *walk, const struct build_view *build, bool with_state);
void check_micromaps(struct walk *walk, struct geometry_view *geometry, bool with_state);
void check_dense_build(struct walk *walk, struct build_view *build);
void check_dense(struct walk *walk, struct geometry_view *geometry, bool with_state);
/* What the build in hand has of micromaps; NULL: nothing. */
const struct micromap_uses *found_micromaps(const struct walk *walk);

#endif
