/* SPDX-License-Identifier: Apache-2.0 */
/* The rules about one entry of a journal, evaluated when a batch is replayed. All findings of a
 * replay go through them, which say to which command buffer and build a finding belongs: findings
 * about updates, micromaps, copies, queries, sparse buffers and destroyed objects. */
#ifndef ASSAY_CHECK_REPLAY_ENTRY_RULES_H
#define ASSAY_CHECK_REPLAY_ENTRY_RULES_H

#include "src/check/replay/states.h"
#include "src/check/walk/walk.h"

/* Lives on its caller's stack, and must not be moved or copied, because `walk` points into it.
 * Takes no lock and allocates no memory. */
struct entry_rules {
    struct replay *replay;
    const struct journal *journal;
    uint32_t first_build;     /* the position of the call's first build in the command buffer */
    struct location location; /* of the judged build, geometry or argument in the call */
    uint32_t origin;          /* of an argument, see journal_note_origin() */
    struct check_context context;
    struct walk walk; /* evaluates all active rules of the command */
};

/* Begins with the build at `location` of a call and at `position` in the command buffer of
 * `journal`. Nothing has to be released. */
void entry_rules_begin(struct entry_rules *rules, struct replay *replay,
                       const struct journal *journal, uint32_t position,
                       const struct location *location);

/* Begins with the entry of a build or update, or of the use of a micromap. */
void entry_rules_begin_entry(struct entry_rules *rules, struct replay *replay,
                             const struct journal *journal, const struct journal_entry *entry);

/* Begins with the entry of a copy, of another read or of a write from memory. */
void entry_rules_begin_read(struct entry_rules *rules, struct replay *replay,
                            const struct journal *journal, const struct journal_entry *entry);

/* Begins with the query that a read writes. */
void entry_rules_begin_query(struct entry_rules *rules, struct replay *replay,
                             const struct journal *journal, const struct journal_entry *entry);

/* Reports a finding about `rules->location` if `rule` is active, and the message of no other
 * active rule names it. */
void entry_rules_report(struct entry_rules *rules, enum rule rule, const struct finding *finding);

/* ---- updates */

/* Validates an update against the last build of its source, if that is known. */
void judge_update(struct replay *replay, const struct journal *journal,
                  const struct journal_entry *entry, const struct built *source);

/* Validates only the geometries of an update. Does nothing if their number differs from the
 * source's, because that is a finding about the update. */
void judge_updated_geometries(struct entry_rules *rules, const struct update_view *update);

/* ---- commands that read a structure and are no builds: copies, queries, serializations */

/* Validates the entry of a copy or another read by the last build of its source, if that is known.
 */
void judge_read(struct replay *replay, const struct journal *journal,
                const struct journal_entry *entry, const struct built *source);
/* Validates the size of dst of a copy, and that it does not overlap src, as far as sizes are known.
 */
void judge_copy_size(struct replay *replay, const struct journal *journal,
                     const struct journal_entry *entry, const struct built *source);

/* ---- micromaps that recorded builds use. The functions with a walk are events of its journal, as
 * those of states.h */

/* Validate the use of a micromap: when it is recorded, if the command buffer itself builds the
 * structures concerned, else when it is submitted. */
void replay_record_micromap(struct replay *replay, const struct structures *known,
                            const struct journal *journal, const struct journal_entry *entry);
void replay_submit_micromap(struct journal_walk *walk, const struct journal_entry *entry);

/* Reports a micromap that was destroyed after the entry was recorded. */
void replay_destroyed_micromap(struct journal_walk *walk, const struct journal_entry *entry);

/* Reports what a command that is no build uses, and that was destroyed, or has lost its memory,
 * after the command was recorded. */
void replay_destroyed_command(struct journal_walk *walk, const struct journal_entry *entry);

/* Validates the micromap of one geometry of an update. Does nothing if neither build has
 * micromaps. */
void judge_updated_micromap(struct walk *walk, const struct updated_geometry_view *geometry,
                            const struct location *location);

#endif
