/* SPDX-License-Identifier: Apache-2.0 */
/* Evaluates whether all rules hold for a device build call.
 *
 * Nearly all calls are valid. The rules of vkCmdBuildAccelerationStructuresKHR, the most frequent
 * command, are therefore first evaluated together, muted or not and without findings: the compiler
 * makes one chain of comparisons of them and tests shared conditions, such as the type of a
 * geometry, once. The rows are walked only if a rule is violated. */
#ifndef ASSAY_CHECK_WALK_FAST_PATH_H
#define ASSAY_CHECK_WALK_FAST_PATH_H

#include "src/view/view.h"

/* All return false for other commands, whose rows are always walked. */
bool call_passes(const struct call_view *call);
bool build_parameters_pass(const struct build_view *build);
bool build_state_passes(const struct build_view *build);
/* Evaluates the parameters and, if `with_state`, the state of a geometry and, if its count is
 * known, of its range. */
bool geometry_passes(const struct range_view *range, bool has_count, bool with_state);

#endif
