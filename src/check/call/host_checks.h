/* SPDX-License-Identifier: Apache-2.0 */
/* Checking what only vkBuildAccelerationStructuresKHR has. */
#ifndef ASSAY_CHECK_CALL_HOST_CHECKS_H
#define ASSAY_CHECK_CALL_HOST_CHECKS_H

#include "src/check/walk/walk.h"

/* After the state of the build is known. */
void check_host_build(struct walk *walk, const struct build_view *build);
/* `range` may lack its build range. */
void check_host_geometry(struct walk *walk, const struct range_view *range);

#endif
