/* SPDX-License-Identifier: Apache-2.0 */
/* Replays journals: validates each recorded update against the last build of its source at that
 * point, and tracks the last build of each structure.
 *
 * Updates of structures that the same command buffer has built are validated when they are
 * recorded, all others at each submission against the live states of the device. */
#ifndef ASSAY_CHECK_REPLAY_REPLAY_H
#define ASSAY_CHECK_REPLAY_REPLAY_H

#include "src/check/replay/states.h"
#include "src/state/commands/command_buffers.h"

/* Validates the entries of the journal's last call, as far as the command buffer knows their
 * sources. For journals with sources to check (journal_entry_has_source_to_check). */
void replay_recorded(struct replay *replay, struct command_buffer *command_buffer);

/* Applies the entries of the journal's last call to the states that the command buffer knows by
 * itself. */
void replay_keep(struct command_buffer *command_buffer);

/* Reports objects that the builds use and that were destroyed after recording. */
void replay_destroyed(struct replay *replay, const struct journal *journal);

/* Replays a command buffer when it is submitted: validates its updates and tracks its writes. */
void replay_submitted(struct replay *replay, const struct journal *journal);

/* Validates the updates of a host command, with `replay->unordered` set. Changes no state. */
void replay_judge_work(struct replay *replay, const struct journal *journal);
/* The host command begins: the states it writes are unknown until it ends. */
void replay_begin_work(struct replay *replay, const struct journal *journal);
/* The host command has ended: tracks its writes, which are unknown if it failed. */
void replay_end_work(struct replay *replay, const struct journal *journal, bool failed);

#endif
