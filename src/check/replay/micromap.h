/* SPDX-License-Identifier: Apache-2.0 */
/* Judging the micromaps that recorded builds use, for replays. */
#ifndef ASSAY_CHECK_REPLAY_MICROMAP_H
#define ASSAY_CHECK_REPLAY_MICROMAP_H

#include "src/check/replay/states.h"
#include "src/check/walk/walk.h"

/* Judge an entry of JOURNAL_USE_MICROMAP: as it is recorded, if the command buffer knows what it is
 * about, and else as it is submitted. */
void replay_record_micromap(struct replay *replay, const struct build_states *known,
                            const struct journal *journal, struct journal_entry *entry);
void replay_submit_micromap(struct replay *replay, const struct journal *journal,
                            const struct journal_entry *entry);

/* Reports a micromap that was destroyed since the entry was recorded. */
void replay_destroyed_micromap(struct replay *replay, const struct journal *journal,
                               const struct journal_entry *entry);

/* The micromaps of one geometry of an update; nothing where neither build has any. */
void judge_updated_micromap(struct walk *walk, const struct updated_geometry_view *geometry,
                            const struct location *location);

#endif
