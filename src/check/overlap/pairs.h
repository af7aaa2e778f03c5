/* SPDX-License-Identifier: Apache-2.0 */
/* Collects the ranges of a call and evaluates the rules about pairs of ranges. */
#ifndef ASSAY_CHECK_OVERLAP_PAIRS_H
#define ASSAY_CHECK_OVERLAP_PAIRS_H

#include "src/check/content/content.h"
#include "src/check/overlap/sweep.h"
#include "src/check/walk/walk.h"

/* Adds the ranges that a build uses. */
void pairs_collect(const struct check_context *context, struct sweep *sweep,
                   const struct build_view *build);
/* Returns true if a build by itself makes no pair. Most builds use only a dst and a scratch range,
 * which are apart. */
bool pairs_has_none_within(const struct check_context *context, const struct build_view *build);
/* Adds the dst of a build only. */
void pairs_collect_dst(struct sweep *sweep, const struct build_view *build);
/* Adds the structures that the instances of a build refer to. */
void pairs_collect_instances(struct sweep *sweep, const struct build_view *build,
                             const struct instance_uses *instances);

/* Evaluates the rules for all pairs that are the same structure or share memory. */
void pairs_walk(struct walk *walk, const struct call_view *call, struct sweep *sweep);
/* Evaluates the rules for all pairs that share memory and of which one is a piece of a sparse
 * buffer. */
void pairs_walk_pieces(struct walk *walk, const struct call_view *call, struct sweep *sweep);

#endif
