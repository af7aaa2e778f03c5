/* SPDX-License-Identifier: Apache-2.0 */
/* A replay, and its access to the live states of a device. */
#ifndef ASSAY_CHECK_REPLAY_STATES_H
#define ASSAY_CHECK_REPLAY_STATES_H

#include "src/check/walk/context.h"
#include "src/state/commands/command_buffers.h"

struct input_notes;

struct replay {
    const bool (*active)[RULE_COUNT]; /* by enum build_command */
    struct resources *resources;
    struct query_pools *query_pools; /* used at submission only */

    /* Used at submission only. */
    struct places *places;                 /* NULL: the device has no builds that note places */
    struct structures *structures;         /* the table of the device */
    struct timestamp now;                  /* when the batch executes */
    const struct execution_clock *follows; /* what certainly executes before the batch */
    uint64_t destroy_count;                /* resources_destroy_count() at the submission */
    bool may_fail;             /* the writes may be undone: the call has not gone down */
    bool predecessors_known;   /* all work that executes before the batch has been replayed */
    bool never_is_certain;     /* only commands in journals build structures on this device */
    bool sizes_may_be_unknown; /* the application may know sizes that the layer does not */
    bool unordered;            /* the commands of the batch are unordered among themselves */
    struct input_notes *notes; /* notes of builds whose inputs are read later; or NULL */
    bool out_of_memory;        /* set if a write could not be tracked */

    /* Reports a finding about a call that `journal` holds, whose first build is at `first_build` in
     * the command buffer, and whose labels and call site are those of `origin`. Returns false if it
     * needs no more findings of the rule. Only entry_rules.c calls it. */
    bool (*found)(void *user, const struct journal *journal, uint32_t first_build, uint32_t origin,
                  enum rule rule, const struct location *location, const struct finding *finding);
    /* Receives each compacted size that the host reads, with the structure's handle; or NULL. */
    void (*compacted)(void *user, uint64_t structure, VkDeviceSize size);
    void *user;
};

extern const struct built built_unknown, built_filled;

/* Returns the last build of the source of an entry, as certainly visible to this batch; else
 * built_unknown. */
const struct built *replay_read(struct replay *replay, const struct journal_entry *entry);

/* Returns the state of a query before the command that writes it; built_unknown if none is
 * certainly visible to this batch. Returns NULL if nothing has reset or written the query. */
const struct built *replay_find_query(struct replay *replay, const struct journal_entry *entry);

/* Sets the last build of a structure after this batch. Ignores `id` 0. */
void replay_write(struct replay *replay, uint64_t id, const struct built *built);

/* The functions with a walk are events of its journal; `user` is the struct replay. */

/* Sparse buffers: apply the binding of an entry, validate the memory of a build's structures, and
 * validate the ranges of a call that share memory. */
void replay_bind(struct journal_walk *walk, const struct journal_entry *entry);
void replay_backing(struct replay *replay, const struct journal *journal,
                    const struct journal_entry *entry);
void replay_ranges(struct journal_walk *walk, const struct journal_entry *entry);

/* Queries of properties: validate and apply the entries of a journal. */
void replay_judge_query(struct replay *replay, const struct journal *journal,
                        const struct journal_entry *entry);
void replay_query(struct journal_walk *walk, const struct journal_entry *entry);
/* Notes a compacting copy if the compacted size of its source is not known yet, and a query of the
 * layer's own will return it. */
void replay_note_compaction(struct replay *replay, const struct journal *journal,
                            const struct journal_entry *entry);
void replay_reset_queries(struct journal_walk *walk, const struct journal_entry *entry);
void replay_answer(struct journal_walk *walk, const struct journal_entry *entry);

#endif
