/* SPDX-License-Identifier: Apache-2.0 */
/* Evaluates the rules that apply to vkBuildAccelerationStructuresKHR only. */
#ifndef ASSAY_CHECK_CALL_HOST_CHECKS_H
#define ASSAY_CHECK_CALL_HOST_CHECKS_H

#include "src/check/walk/walk.h"

/* Call it after the state of the build is known. */
void check_host_build(struct walk *walk, const struct build_view *build);
/* The build range of `range` may be unknown. */
void check_host_geometry(struct walk *walk, const struct range_view *range);

#endif
