/* SPDX-License-Identifier: Apache-2.0 */
/* Validates the micromaps that recorded builds use. */
#ifndef ASSAY_CHECK_REPLAY_MICROMAP_H
#define ASSAY_CHECK_REPLAY_MICROMAP_H

#include "src/check/replay/states.h"
#include "src/check/walk/walk.h"

/* Validate an entry of kind JOURNAL_USE_MICROMAP: when it is recorded, if the command buffer itself
 * builds the structures concerned, else when it is submitted. */
void replay_record_micromap(struct replay *replay, const struct structures *known,
                            const struct journal *journal, struct journal_entry *entry);
void replay_submit_micromap(struct replay *replay, const struct journal *journal,
                            const struct journal_entry *entry);

/* Reports a micromap that was destroyed after the entry was recorded. */
void replay_destroyed_micromap(struct replay *replay, const struct journal *journal,
                               const struct journal_entry *entry);

/* Validates the micromap of one geometry of an update. Does nothing if neither build has
 * micromaps. */
void judge_updated_micromap(struct walk *walk, const struct updated_geometry_view *geometry,
                            const struct location *location);

#endif
