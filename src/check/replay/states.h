/* SPDX-License-Identifier: Apache-2.0 */
/* A replay, and how it reads and writes the live states of a device. */
#ifndef ASSAY_CHECK_REPLAY_STATES_H
#define ASSAY_CHECK_REPLAY_STATES_H

#include "src/check/walk/context.h"
#include "src/state/commands/command_buffers.h"

struct built_flags;
struct input_notes;

struct replay {
    const bool (*active)[RULE_COUNT]; /* by command */
    struct resources *resources;

    /* At submission only. */
    struct build_states *states;           /* live */
    struct build_undo *undo;               /* notes what they were before, if not NULL */
    struct timestamp now;                  /* when the batch executes, */
    const struct execution_clock *follows; /* what it certainly follows, */
    bool predecessors_known;   /* and whether all that executes before it has been replayed */
    bool never_is_certain;     /* nothing but journalled commands builds on this device */
    bool unordered;            /* what the batch does has no order in itself */
    struct built_flags *flags; /* told of all writes; NULL: nobody asks */
    struct input_notes *notes; /* of builds that are read later; NULL: none is */
    bool out_of_memory;        /* set where a write could not be noted */

    /* Takes a finding about a call that `journal` holds, whose first build is at `first_build` in
     * the command buffer. Returns false if it wants no more of this rule. Only the judge calls it.
     */
    bool (*found)(void *user, const struct journal *journal, uint32_t first_build, enum rule rule,
                  const struct location *location, const struct finding *finding);
    void *user;
};

extern const struct built built_unknown, built_filled;

/* What the source of an entry was last built with for a reader in this batch, as far as that is
 * certain. */
const struct built *replay_read(struct replay *replay, const struct journal_entry *entry);

/* What it is built with after this batch; `id` 0 is ignored. */
void replay_write(struct replay *replay, uint64_t id, const struct built *built);

/* As if nothing had ever been written. */
void replay_erase(struct replay *replay, uint64_t id);

/* Sparse buffers: what an entry binds, whether the structures of a build are backed by memory, and
 * which ranges of a call share it. */
void replay_bind(struct replay *replay, const struct journal_entry *entry);
void replay_backing(struct replay *replay, const struct journal *journal,
                    const struct journal_entry *entry);
void replay_ranges(struct replay *replay, const struct journal *journal,
                   const struct journal_entry *entry);

/* Queries of compacted sizes: what each entry of the journal does. */
void replay_query(struct replay *replay, const struct journal_entry *entry);
void replay_reset_queries(struct replay *replay, const struct journal_entry *entry);
void replay_answer(struct replay *replay, const struct host_view *host,
                   const struct journal_entry *entry);

#endif
