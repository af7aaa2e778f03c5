/* SPDX-License-Identifier: Apache-2.0 */
/* Replays journals: judges each recorded update by what its source was last built with at that
 * point, and notes what each structure is built with after it.
 *
 * What a command buffer knows by itself (built, then updated there) is judged when it is recorded;
 * the rest at each submission, against the live states of the device. */
#ifndef ASSAY_CHECK_REPLAY_H
#define ASSAY_CHECK_REPLAY_H

#include "check/check.h"
#include "state/command_buffers.h"

struct replay {
    const bool (*active)[RULE_COUNT]; /* by command */
    struct resources *resources;
    struct command_buffers *command_buffers;

    /* At submission only. */
    struct build_states *states; /* live; the caller holds their lock */
    struct moment now;
    /* Whether the batch certainly executes after that. */
    bool (*follows)(void *user, struct moment written);

    /* Told before findings: which build of which command buffer they are about. */
    void (*locate)(void *user, const struct command_buffer *command_buffer, uint32_t position);
    bool (*found)(void *user, enum rule rule, const struct location *location,
                  const struct finding *finding);
    void *user;
};

/* Judges the entries of a call just recorded, those behind `mark`, as far as the command buffer
 * knows their sources. */
void replay_recorded(struct replay *replay, struct command_buffer *command_buffer,
                     const struct journal_mark *mark);

/* Adds the entries behind `mark` to what the command buffer knows by itself. */
void replay_keep(struct replay *replay, struct command_buffer *command_buffer,
                 const struct journal_mark *mark);

/* Reports what the command buffer's builds use that died since it was recorded. */
void replay_deaths(struct replay *replay, const struct command_buffer *command_buffer);

/* Replays a command buffer as it is submitted. */
void replay_submitted(struct replay *replay, const struct command_buffer *command_buffer);

/* After a submission that did not happen: nothing is known of what it would have written. */
void replay_forget(struct replay *replay, const struct command_buffer *command_buffer);

#endif
