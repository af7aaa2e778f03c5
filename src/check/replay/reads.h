/* SPDX-License-Identifier: Apache-2.0 */
/* Validates commands that read a structure and are no builds: copies, queries, serializations. */
#ifndef ASSAY_CHECK_REPLAY_READS_H
#define ASSAY_CHECK_REPLAY_READS_H

#include "src/check/replay/judge.h"

/* Validates an entry of JOURNAL_READS by the last build of its source, if that is known. */
void judge_read(struct replay *replay, const struct journal *journal,
                const struct journal_entry *entry, const struct built *source);
/* Validates the size of dst of a copy, if the compacted size of its source is known. */
void judge_copy_size(struct replay *replay, const struct journal *journal,
                     const struct journal_entry *entry, const struct built *source);

#endif
