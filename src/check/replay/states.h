/* SPDX-License-Identifier: Apache-2.0 */
/* How a replay reads and writes the live states of a device, for the replay's own files. */
#ifndef ASSAY_CHECK_REPLAY_STATES_H
#define ASSAY_CHECK_REPLAY_STATES_H

#include "src/check/replay/replay.h"
#include "src/check/walk/walk.h"

extern const struct built built_unknown, built_filled;

/* What the source of an entry was last built with for a reader in this batch, as far as that is
 * certain. */
const struct built *replay_read(struct replay *replay, const struct journal_entry *entry);

/* What it is built with after this batch; `id` 0 is ignored. */
void replay_write(struct replay *replay, uint64_t id, const struct built *built);

/* As if nothing had ever been written. */
void replay_erase(struct replay *replay, uint64_t id);

/* An update on its way through the rules, whose findings are located and go to the replay's
 * `found`. */
struct update_judgement {
    struct replay *replay;
    const struct journal *journal;
    const struct journal_entry *entry;
    struct check_context context;
    struct walk walk; /* wants all rules that are active */
    struct location location;
};
void update_judgement_begin(struct update_judgement *judgement, struct replay *replay,
                            const struct journal *journal, const struct journal_entry *entry);
void judge_geometries(struct walk *walk, const struct update_view *update,
                      const struct location *build);

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
