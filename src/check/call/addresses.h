/* SPDX-License-Identifier: Apache-2.0 */
/* Checking what the addresses of a build lead to. */
#ifndef ASSAY_CHECK_CALL_ADDRESSES_H
#define ASSAY_CHECK_CALL_ADDRESSES_H

#include "src/check/walk/walk.h"

/* The addresses of a geometry, with those that extensions chain to it. */
void check_geometry_addresses(struct walk *walk, const struct geometry_view *geometry);
/* The scratch of a build, if its size is known. */
void check_scratch_address(struct walk *walk, const struct build_view *build);

/* Asks the rules about one build of COMMAND_INDIRECT, and shows its address to the witness. */
void check_indirect(struct walk *walk, const struct build_view *build, bool with_state);

#endif
