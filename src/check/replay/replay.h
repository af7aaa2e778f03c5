/* SPDX-License-Identifier: Apache-2.0 */
/* Replays journals: judges each recorded update by what its source was last built with at that
 * point, and notes what each structure is built with after it.
 *
 * What a command buffer knows by itself (built, then updated there) is judged when it is recorded;
 * the rest at each submission, against the live states of the device. */
#ifndef ASSAY_CHECK_REPLAY_REPLAY_H
#define ASSAY_CHECK_REPLAY_REPLAY_H

#include "src/check/replay/states.h"
#include "src/state/commands/command_buffers.h"

/* Judges the entries of a call just recorded, those behind `mark`, as far as the command buffer
 * knows their sources: for journals that ask for any (journal_entry_has_source_to_check). */
void replay_recorded(struct replay *replay, struct command_buffer *command_buffer,
                     const struct journal_mark *mark);

/* Adds the entries behind `mark` to what the command buffer knows by itself. */
void replay_keep(struct command_buffer *command_buffer, const struct journal_mark *mark);

/* Reports what the builds use that died since they were recorded. */
void replay_destroyed(struct replay *replay, const struct journal *journal);

/* Replays a command buffer as it is submitted: judges its updates and notes what it writes. */
void replay_submitted(struct replay *replay, const struct journal *journal);

/* A command of the host, `unordered`: judges its updates; changes nothing. */
void replay_judge_work(struct replay *replay, const struct journal *journal);
/* It begins: until it ends, nothing is known of what it writes. */
void replay_begin_work(struct replay *replay, const struct journal *journal);
/* It has ended: notes what it wrote, of which nothing is known if it has failed. */
void replay_end_work(struct replay *replay, const struct journal *journal, bool failed);

#endif
