/* SPDX-License-Identifier: Apache-2.0 */
/* Whether all rules hold of what a call brings.
 *
 * Nearly all calls keep all rules. Those of vkCmdBuildAccelerationStructuresKHR, the command that
 * is called most, are therefore first asked together, without findings to fill and whether they are
 * wanted or not: the compiler makes one chain of comparisons of them, and tests once what many of
 * them ask for, such as the type of a geometry. Only where one doesn't hold are the rows walked. */
#ifndef ASSAY_CHECK_WALK_FAST_PATH_H
#define ASSAY_CHECK_WALK_FAST_PATH_H

#include "src/view/view.h"

/* False for other commands, whose rows are always walked. `alike`: the rules that read the shape of
 * a build alone are known to hold, and aren't asked again. */
bool call_passes(const struct call_view *call);
bool build_parameters_pass(const struct build_view *build, bool same_shape);
bool build_state_passes(const struct build_view *build);
/* A geometry and, where its count is known, its range: their parameters, and their state. */
bool geometry_passes(const struct range_view *range, bool has_count, bool with_state,
                     bool same_shape);

#endif
