/* SPDX-License-Identifier: Apache-2.0 */
/* Judging updates: asks the rules of an update, locates what they find, and reports it. */
#ifndef ASSAY_CHECK_REPLAY_JUDGE_H
#define ASSAY_CHECK_REPLAY_JUDGE_H

#include "src/check/replay/states.h"
#include "src/check/walk/walk.h"

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

/* Judges an update by what its source was last built with, as far as that is known. */
void judge_update(struct replay *replay, const struct journal *journal,
                  const struct journal_entry *entry, const struct built *source);

#endif
