/* SPDX-License-Identifier: Apache-2.0 */
/* Evaluates the rules about updates. */
#ifndef ASSAY_CHECK_REPLAY_UPDATES_H
#define ASSAY_CHECK_REPLAY_UPDATES_H

#include "src/check/replay/judge.h"

/* Validates an update against the last build of its source, if that is known. */
void judge_update(struct replay *replay, const struct journal *journal,
                  const struct journal_entry *entry, const struct built *source);

/* Validates only the geometries of an update. Does nothing if their number differs from the
 * source's, because that is a finding about the update. */
void judge_updated_geometries(struct judge *judge, const struct update_view *update);

#endif
