/* SPDX-License-Identifier: Apache-2.0 */
/* Validates the addresses of a build. */
#ifndef ASSAY_CHECK_CALL_ADDRESSES_H
#define ASSAY_CHECK_CALL_ADDRESSES_H

#include "src/check/walk/walk.h"

/* Validates the addresses of a geometry, including those in chained structures. */
void check_geometry_addresses(struct walk *walk, const struct geometry_view *geometry);
/* Validates the scratch address of a build if the scratch size is known. */
void check_scratch_address(struct walk *walk, const struct build_view *build);

/* Evaluates the rules about the indirect parameters of one build of COMMAND_INDIRECT, and passes
 * them to the build recorder. */
void check_indirect(struct walk *walk, const struct build_view *build, bool with_state);

#endif
