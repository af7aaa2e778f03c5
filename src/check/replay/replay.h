/* SPDX-License-Identifier: Apache-2.0 */
/* Replays journals: judges each recorded update by what its source was last built with at that
 * point, and notes what each structure is built with after it.
 *
 * What a command buffer knows by itself (built, then updated there) is judged when it is recorded;
 * the rest at each submission, against the live states of the device. */
#ifndef ASSAY_CHECK_REPLAY_REPLAY_H
#define ASSAY_CHECK_REPLAY_REPLAY_H

#include "src/check/call/check.h"
#include "src/state/commands/command_buffers.h"

struct built_flags;
struct content_notes;

struct replay {
    const bool (*active)[RULE_COUNT]; /* by command */
    struct resources *resources;

    /* At submission only. */
    struct build_states *states;           /* live */
    struct build_undo *undo;               /* notes what they were before, if not NULL */
    struct moment now;                     /* when the batch executes, */
    const struct execution_clock *follows; /* what it certainly follows, */
    bool predecessors_known;     /* and whether all that executes before it has been replayed */
    bool never_is_certain;       /* nothing but journalled commands builds on this device */
    bool unordered;              /* what the batch does has no order in itself */
    struct built_flags *flags;   /* told of all writes; NULL: nobody asks */
    struct content_notes *notes; /* of builds that are read later; NULL: none is */
    bool out_of_memory;          /* set where a write could not be noted */

    /* Told before findings: which build of which command buffer they are about. */
    void (*locate)(void *user, const struct journal *journal, uint32_t position, uint32_t info);
    bool (*found)(void *user, enum rule rule, const struct location *location,
                  const struct finding *finding);
    void *user;
};

/* Judges the entries of a call just recorded, those behind `mark`, as far as the command buffer
 * knows their sources: for journals that ask for any (journal_asks). */
void replay_recorded(struct replay *replay, struct command_buffer *command_buffer,
                     const struct journal_mark *mark);

/* Adds the entries behind `mark` to what the command buffer knows by itself. */
void replay_keep(struct command_buffer *command_buffer, const struct journal_mark *mark);

/* Reports what the builds use that died since they were recorded. */
void replay_deaths(struct replay *replay, const struct journal *journal);

/* Replays a command buffer as it is submitted: judges its updates and notes what it writes. */
void replay_submitted(struct replay *replay, const struct journal *journal);

/* A command of the host, `unordered`: judges its updates; changes nothing. */
void replay_judge_work(struct replay *replay, const struct journal *journal);
/* It begins: until it ends, nothing is known of what it writes. */
void replay_begin_work(struct replay *replay, const struct journal *journal);
/* It has ended: notes what it wrote, of which nothing is known if it has failed. */
void replay_end_work(struct replay *replay, const struct journal *journal, bool failed);

#endif
