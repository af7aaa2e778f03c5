/* SPDX-License-Identifier: Apache-2.0 */
/* What a case or a program expects of messages, and why it failed or was skipped. */
#ifndef ASSAY_TESTS_PLAYER_REPORT_H
#define ASSAY_TESTS_PLAYER_REPORT_H

#include "tests/fixture/messages.h"

enum outcome { OUTCOME_PASSED, OUTCOME_FAILED, OUTCOME_SKIPPED };
enum { REPORT_TEXT_MAX = 32 * 1024 };

struct report {
    enum outcome outcome;
    bool fired, stayed_silent;  /* a case, as it should have */
    char text[REPORT_TEXT_MAX]; /* why it failed or was skipped */
};

__attribute__((format(printf, 2, 3))) void report_say(struct report *report, const char *format,
                                                      ...);
/* Says which messages came; those that are marked were expected, if `is_used` is not NULL. */
void report_say_messages(struct report *report, const struct messages *messages,
                         const bool *is_used);

/* Whether it is the whole id of a message, or the end of it behind a "-". */
bool report_id_ends(const char *id, const char *end);
/* Returns true if the parts of `wanted`, with " ... " between them, are in `text`, in this order;
 * what follows `NOT ` must not be in the rest. */
bool report_text_matches(const char *text, const char *wanted);

/* Whether what a message says beside the mistake is right: the hint of its row, counts that agree
 * with their nouns, and no id twice. */
bool report_judge_wording(struct report *report, const struct message *message);

#endif
