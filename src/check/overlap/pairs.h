/* SPDX-License-Identifier: Apache-2.0 */
/* The ranges of a call, and the rules about two of them. */
#ifndef ASSAY_CHECK_OVERLAP_PAIRS_H
#define ASSAY_CHECK_OVERLAP_PAIRS_H

#include "src/check/content/content.h"
#include "src/check/overlap/sweep.h"
#include "src/check/walk/walk.h"

/* Adds what a build uses. */
void pairs_collect(const struct check_context *context, struct sweep *sweep,
                   const struct build_view *build);
/* Whether it is plain that a build alone makes no pair: most use their dst and a scratch, which are
 * apart. */
bool pairs_has_none_within(const struct check_context *context, const struct build_view *build);
/* Its dst alone. */
void pairs_collect_dst(struct sweep *sweep, const struct build_view *build);
/* What its instances refer to. */
void pairs_collect_instances(struct sweep *sweep, const struct build_view *build,
                             const struct instance_uses *instances);

/* Puts all pairs that are equal or share memory to the rules. */
void pairs_walk(struct walk *walk, const struct call_view *call, struct sweep *sweep);
/* Those that share memory, if one of them is a piece of a sparse buffer. */
void pairs_walk_pieces(struct walk *walk, const struct call_view *call, struct sweep *sweep);

#endif
